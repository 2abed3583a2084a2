#include "job/sampled_case.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "job/job.hpp"
#include "job/uncertainty_job.hpp"

namespace vrda::sampled_case_test {

// The generic knee, coarse, with [uncertainty] of `parameters`.
job::Case knee(const std::string& parameters, const std::string& uncertainty = "samples = 64\n")
{
  std::string text = R"(
[reference]
[[reference.component]]
name = "femur"
generate = { shape = "knee", part = "femur", resolution = 0.5 }
[moving]
[[moving.component]]
name = "tibia"
generate = { shape = "knee", part = "tibia", resolution = 0.5 }
[push]
force_n = 20
moment_nmm = 100
[[push.line]]
name = "hamstrings"
tension_n = 50
reference_mm = [[-20, 300, 10]]
moving_mm = [[-25, -30, 10]]
[ligaments]
generate = { shape = "knee" }
[grid]
flexion = { from = 0, to = 30, step = 10 }
varus = "free"
[uncertainty]
)";
  return job::load_case(job::parse_job("knee.toml", text + uncertainty + parameters), "");
}

std::string parameter(const std::string& keys)
{
  return "[[uncertainty.parameter]]\n" + keys + "\n";
}

TEST(SampledCase, one_bundle)
{
  const job::Case job = knee(parameter(R"(quantity = "stiffness"
bundle = "ACLam"
distribution = "lognormal"
sd = 0.3)"));
  const job::SampledCase samples(job);
  ASSERT_EQ(samples.draw_names(), std::vector<std::string>{"stiffness ACLam"});
  EXPECT_TRUE(samples.has_same_geometry());
  double mean_log = 0.0, mean_square = 0.0;
  for (int s = 0; s < samples.n_samples(); ++s) {
    const model::Ligaments sampled = samples.ligaments_at(s);
    const double factor = samples.values()(s, 0);
    mean_log += std::log(factor) / samples.n_samples();
    mean_square += std::log(factor) * std::log(factor) / samples.n_samples();
    for (std::size_t k = 0; k < sampled.fibres.size(); ++k) {
      const bool is_acl = job.ligaments.fibres[k].bundle == "ACLam";
      EXPECT_DOUBLE_EQ(sampled.fibres[k].stiffness_n,
                       job.ligaments.fibres[k].stiffness_n * (is_acl ? factor : 1.0));
      EXPECT_EQ(sampled.fibres[k].slack_length_mm, job.ligaments.fibres[k].slack_length_mm);
    }
  }
  EXPECT_NEAR(mean_log, 0.0, 0.01);
  EXPECT_NEAR(std::sqrt(mean_square), 0.3, 0.02);
}

TEST(SampledCase, positive_stiffness)
{
  const job::Case job = knee(parameter(R"(quantity = "stiffness"
distribution = "normal"
sd = 2.0
shared_by = "fibre")"));
  const job::SampledCase samples(job);
  EXPECT_EQ(samples.draw_names().size(), job.ligaments.fibres.size());
  for (int s = 0; s < samples.n_samples(); ++s) {
    for (const model::Fibre& fibre : samples.ligaments_at(s).fibres) EXPECT_GT(fibre.stiffness_n, 0.0);
  }
}

double strain_of(const model::Ligaments& ligaments, std::size_t k)
{
  return model::fibre_states(ligaments, {}, {})[k].strain;
}

TEST(SampledCase, reference_strain)
{
  const job::Case job = knee(parameter(R"(quantity = "reference_strain"
distribution = "uniform"
from = -0.02
to = 0.04
shared_by = "all")"));
  const job::SampledCase samples(job);
  ASSERT_EQ(samples.draw_names().size(), 1u);
  for (const int s : {0, 17, 63}) {
    const model::Ligaments sampled = samples.ligaments_at(s);
    for (std::size_t k = 0; k < sampled.fibres.size(); ++k)
      EXPECT_NEAR(strain_of(sampled, k), strain_of(job.ligaments, k) + samples.values()(s, 0), 1e-12);
  }
}

TEST(SampledCase, correlation)
{
  const job::Case job = knee(parameter(R"(quantity = "reference_strain"
bundle = "ACLam"
distribution = "normal"
sd = 0.02
shared_by = "fibre"
correlation = 0.6)"),
                             "samples = 2000\n");
  const job::SampledCase samples(job);
  std::vector<std::size_t> acl;
  for (std::size_t k = 0; k < job.ligaments.fibres.size(); ++k)
    if (job.ligaments.fibres[k].bundle == "ACLam") acl.push_back(k);
  ASSERT_GE(acl.size(), 2u);
  EXPECT_EQ(samples.draw_names().size(), acl.size() + 1) << "one for each fibre, and what they share";
  double aa = 0.0, ab = 0.0;
  for (int s = 0; s < samples.n_samples(); ++s) {
    const model::Ligaments sampled = samples.ligaments_at(s);
    const double a = strain_of(sampled, acl[0]) - strain_of(job.ligaments, acl[0]);
    const double b = strain_of(sampled, acl[1]) - strain_of(job.ligaments, acl[1]);
    aa += a * a / samples.n_samples();
    ab += a * b / samples.n_samples();
  }
  EXPECT_NEAR(std::sqrt(aa), 0.02, 0.001);
  EXPECT_NEAR(ab / aa, 0.6, 4.0 * 0.64 / std::sqrt(2000.0));  // four standard errors, 1 - 0.6^2 each
}

TEST(SampledCase, attachments)
{
  const std::string text = parameter(R"(quantity = "attachment"
body = "moving"
distribution = "uniform"
to = 4
shared_by = "fibre")");
  const job::Case job = knee(text);
  const job::SampledCase samples(job);
  EXPECT_EQ(samples.draw_names().size(), 3 * job.ligaments.fibres.size());
  double farthest_mm = 0.0;
  for (int s = 0; s < samples.n_samples(); ++s) {
    const model::Ligaments sampled = samples.ligaments_at(s);
    for (std::size_t k = 0; k < sampled.fibres.size(); ++k) {
      const model::Fibre& fibre = sampled.fibres[k];
      EXPECT_EQ(fibre.reference_mm, job.ligaments.fibres[k].reference_mm);
      EXPECT_EQ(fibre.slack_length_mm, job.ligaments.fibres[k].slack_length_mm) << "given, so it is kept";
      // The chord of a path along the surface; where the surface is bent the nearest point may be a little
      // farther.
      farthest_mm = std::max(farthest_mm, (fibre.moving_mm - job.ligaments.fibres[k].moving_mm).norm());
    }
  }
  EXPECT_GT(farthest_mm, 3.5);
  EXPECT_LT(farthest_mm, 5.0);
}

TEST(SampledCase, loads_and_centre)
{
  const job::Case job = knee(parameter(R"(quantity = "load"
load = "moment"
distribution = "normal"
sd = 500)") + parameter(R"(quantity = "load"
load = "hamstrings"
distribution = "uniform"
factor = true
from = 0
to = 2)") + parameter(R"(quantity = "load"
load = "force"
distribution = "normal"
sd = 30)") + parameter(R"(quantity = "rotation_centre"
distribution = "normal"
sd = 2)"));
  const job::SampledCase samples(job);
  EXPECT_EQ(samples.draw_names().size(), 6u);
  EXPECT_FALSE(samples.has_same_geometry());
  for (int s = 0; s < samples.n_samples(); ++s) {
    const job::Case sampled = samples.at(s);
    for (const job::Push& push : sampled.path_push) {
      EXPECT_NEAR(push.moment_nmm, 100.0 + samples.values()(s, 0), 1e-9);
      EXPECT_NEAR(push.line_tension_n[0], 50.0 * samples.values()(s, 1), 1e-9);
      // The draw kept is the one used, truncated where the push ends.
      EXPECT_GT(push.force_n.y(), 0.0);
      EXPECT_NEAR(push.force_n.y(), job.push.front().force_n.y() + samples.values()(s, 2), 1e-9);
    }
    const Eigen::Vector3d moved_mm = samples.values().block<1, 3>(s, 3).transpose();
    EXPECT_EQ(sampled.frame.rotation_centre_mm, job.frame.rotation_centre_mm + moved_mm);
  }
}

TEST(SampledCase, positive_offset)
{
  const job::Case job = knee(parameter(R"(quantity = "offset"
body = "reference"
component = "femur"
distribution = "normal"
sd = 1)"));
  const job::SampledCase samples(job);
  for (int s = 0; s < samples.n_samples(); ++s) {
    const std::vector<double>& offset_mm = samples.at(s).reference.contact.mesh.offset_mm;
    ASSERT_EQ(offset_mm.size(), static_cast<std::size_t>(job.reference.contact.mesh.triangles.rows()));
    EXPECT_GT(offset_mm.front(), 0.0);
    EXPECT_EQ(offset_mm.front(), samples.values()(s, 0));
    EXPECT_EQ(std::set<double>(offset_mm.begin(), offset_mm.end()).size(), 1u);
  }
}

}  // namespace vrda::sampled_case_test
