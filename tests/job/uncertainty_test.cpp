#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "job/job.hpp"
#include "job/job_parts.hpp"
#include "job/sampled_case.hpp"

namespace vrda::uncertainty_test {

using job::Distribution;
using job::DistributionKind;

TEST(Distribution, closed_forms)
{
  const Distribution normal{.kind = DistributionKind::normal, .mean = 2.0, .sd = 0.5};
  EXPECT_NEAR(job::quantile_of(normal, 0.5), 2.0, 1e-15);
  EXPECT_NEAR(job::quantile_of(normal, 0.95), 2.0 + 0.5 * 1.6448536269514722, 1e-12);
  const Distribution lognormal{.kind = DistributionKind::lognormal, .mean = 3.0, .sd = 0.2};
  EXPECT_NEAR(job::quantile_of(lognormal, 0.05), 3.0 * std::exp(-0.2 * 1.6448536269514722), 1e-12);
  const Distribution uniform{.kind = DistributionKind::uniform, .from = -1.0, .to = 3.0};
  EXPECT_DOUBLE_EQ(job::quantile_of(uniform, 0.25), 0.0);
  const Distribution table{.kind = DistributionKind::table, .values = {1.0, 2.0, 10.0}};
  EXPECT_DOUBLE_EQ(job::quantile_of(table, 0.25), 1.5);
  EXPECT_DOUBLE_EQ(job::quantile_of(table, 0.75), 6.0);
}

TEST(Distribution, truncated)
{
  const Distribution normal{.kind = DistributionKind::normal, .mean = 1.0, .sd = 1.0};
  EXPECT_GT(job::quantile_above(normal, 1e-9, 0.0), 0.0);
  // P(x < q | x > 0) = (F(q) - F(0)) / (1 - F(0)).
  const double q = job::quantile_above(normal, 0.3, 0.0);
  const double below_0 = job::probability_of_score(-1.0);
  EXPECT_NEAR((job::probability_of_score(q - 1.0) - below_0) / (1.0 - below_0), 0.3, 1e-12);
  const Distribution table{.kind = DistributionKind::table, .values = {0.0, 1.0, 2.0}};
  EXPECT_DOUBLE_EQ(job::quantile_above(table, 0.5, 1.0), 1.5);
  const Distribution uniform{.kind = DistributionKind::uniform, .from = 0.0, .to = 1.0};
  EXPECT_DOUBLE_EQ(job::quantile_above(uniform, 0.5, 0.5), 0.75);
  EXPECT_DOUBLE_EQ(job::quantile_above(uniform, 0.5, -3.0), 0.5) << "nothing is cut off";
}

using job::SampleSequence;

class Sampling : public testing::TestWithParam<SampleSequence> {};

TEST_P(Sampling, seeds)
{
  const Eigen::MatrixXd a = job::unit_samples(GetParam(), 64, 5, 7);
  EXPECT_EQ(a, job::unit_samples(GetParam(), 64, 5, 7));
  EXPECT_NE(a, job::unit_samples(GetParam(), 64, 5, 8));
  EXPECT_GT(a.minCoeff(), 0.0);
  EXPECT_LT(a.maxCoeff(), 1.0);
}

TEST_P(Sampling, intervals)
{
  // True of 2^k points of a Sobol sequence, and of any number of a Latin hypercube.
  const Eigen::Index n = 128;
  const Eigen::MatrixXd samples = job::unit_samples(GetParam(), n, 9, 3);
  for (Eigen::Index d = 0; d < samples.cols(); ++d) {
    std::set<int> intervals;
    for (Eigen::Index s = 0; s < n; ++s)
      intervals.insert(static_cast<int>(samples(s, d) * static_cast<double>(n)));
    EXPECT_EQ(intervals.size(), static_cast<std::size_t>(n)) << "dimension " << d;
  }
}

TEST_P(Sampling, independent_dimensions)
{
  const Eigen::MatrixXd samples = job::unit_samples(GetParam(), 512, 20, 1).array() - 0.5;
  // Of independent uniform numbers the correlation has a standard error of 1 / sqrt(512) = 0.044.
  for (Eigen::Index d = 1; d < samples.cols(); ++d)
    EXPECT_LT(std::abs(12.0 * samples.col(d - 1).dot(samples.col(d)) / 512.0), 4.0 * 0.044) << d;
}

INSTANTIATE_TEST_SUITE_P(BothSequences, Sampling,
                         testing::Values(SampleSequence::sobol, SampleSequence::latin_hypercube));

TEST(Sampling, first_points)
{
  // Of Sobol's only: more samples refine what is there.
  EXPECT_EQ(job::unit_samples(SampleSequence::sobol, 16, 4, 2),
            job::unit_samples(SampleSequence::sobol, 64, 4, 2).topRows(16));
}

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TEST(Statistics, quantiles)
{
  EXPECT_DOUBLE_EQ(job::quantile({4, 1, 3, 2}, 0.5), 2.5);
  EXPECT_DOUBLE_EQ(job::quantile({4, 1, nan, 3, 2}, 0.5), 2.5) << "failed samples are left out";
  EXPECT_DOUBLE_EQ(job::quantile({4, 1, 3, 2}, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(job::quantile({4, 1, 3, 2}, 1.0), 4.0);
  EXPECT_TRUE(std::isnan(job::quantile({nan}, 0.5)));
}

TEST(Statistics, rank_correlation)
{
  const std::vector<double> x{1, 2, 3, 4, 5}, cubes{1, 8, 27, 64, 125}, falling{9, 7, 5, 3, 1};
  EXPECT_DOUBLE_EQ(job::rank_correlation(x, cubes), 1.0);
  EXPECT_DOUBLE_EQ(job::rank_correlation(x, falling), -1.0);
  // Ranks 1, 2.5, 2.5, 4 against 1, 2, 3, 4: 4.5 / sqrt(5 * 4.5).
  EXPECT_NEAR(job::rank_correlation(std::vector<double>{1, 2, 2, 3}, std::vector<double>{1, 2, 3, 4}),
              std::sqrt(0.9), 1e-12);
  EXPECT_TRUE(std::isnan(job::rank_correlation(x, std::vector<double>{1, 1, 1, 1, 1})));
}

struct Study {
  Eigen::MatrixXd scores;
  Eigen::MatrixXd result;  // one column
  std::vector<int> group;
};

// y = 3 z0 + 2 (z1^2 - 1) / sqrt(2) + z0 z2: variances 9, 4 and 1.
Study study(std::uint32_t seed, job::SampleSequence sequence)
{
  const Eigen::Index n = 400;
  Study made;
  made.scores = job::unit_samples(sequence, n, 4, seed).unaryExpr(&job::score_of_probability);
  made.result.resize(n, 1);
  for (Eigen::Index s = 0; s < n; ++s) {
    const auto z = made.scores.row(s);
    made.result(s, 0) = 3.0 * z[0] + 2.0 * (z[1] * z[1] - 1.0) / std::sqrt(2.0) + z[0] * z[2];
  }
  made.group = job::jackknife_groups(static_cast<std::size_t>(n), seed);
  return made;
}

TEST(Statistics, first_order_indices)
{
  const Study made = study(1, job::SampleSequence::sobol);
  const double expected[] = {9.0 / 14.0, 4.0 / 14.0, 0.0, 0.0};
  for (Eigen::Index d = 0; d < 4; ++d) {
    const auto index = job::first_order_indices(made.scores.col(d), made.result, made.group).front();
    // The standard error of a share of 0.3 from 400 samples is 0.04.
    EXPECT_NEAR(index.index, expected[d], 0.04) << d;
    EXPECT_LE(index.low, index.index);
    EXPECT_GE(index.high, index.index);
  }
}

TEST(Statistics, intervals)
{
  const double expected[] = {9.0 / 14.0, 4.0 / 14.0};
  int n_held = 0, n_all = 0;
  for (std::uint32_t seed = 1; seed <= 100; ++seed) {
    const Study made = study(seed, job::SampleSequence::latin_hypercube);
    for (Eigen::Index d = 0; d < 2; ++d, ++n_all) {
      const auto index = job::first_order_indices(made.scores.col(d), made.result, made.group).front();
      n_held += index.low <= expected[d] && expected[d] <= index.high ? 1 : 0;
    }
  }
  // 180 of 200 are expected; the standard deviation of independent ones is 4.
  EXPECT_GE(n_held, 180 - 4 * 4) << "of " << n_all;
}

TEST(Statistics, failed_samples)
{
  Study made = study(1, job::SampleSequence::sobol);
  const double whole = job::first_order_indices(made.scores.col(0), made.result, made.group)[0].index;
  for (Eigen::Index s = 0; s < 20; ++s) made.result(s, 0) = nan;
  const double most = job::first_order_indices(made.scores.col(0), made.result, made.group)[0].index;
  EXPECT_NEAR(most, whole, 0.03);
  EXPECT_NE(most, whole);
  made.result.topRows(361).setConstant(nan);
  EXPECT_TRUE(std::isnan(job::first_order_indices(made.scores.col(0), made.result, made.group)[0].index));
  made.result.setConstant(5.0);
  EXPECT_TRUE(std::isnan(job::first_order_indices(made.scores.col(0), made.result, made.group)[0].index))
      << "no spread";
}

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

// Lines on the femur far from the bone move freely; the tendon on the patella moves along it. What is given
// is kept: strains in the scan, or slack lengths.
TEST(SampledCase, attachments_and_direction_of_a_follower)
{
  const std::string follower = R"([[follower]]
name = "patella"
generate = { shape = "knee" }
[[follower.component]]
name = "patella"
generate = { shape = "knee", part = "patella", resolution = 0.5 }
[[follower.direction]]
bundle = "PT"
stiffness_nmm_per_rad = 3000
)";
  const auto of_patella = [](const std::string& keys) {
    return parameter("follower = \"patella\"\ndistribution = \"normal\"\n" + keys);
  };
  job::Case job =
      knee(of_patella("quantity = \"attachment\"\nbody = \"reference\"\nbundle = \"QUAD\"\nsd = 3") +
           of_patella("quantity = \"attachment\"\nbody = \"patella\"\nbundle = \"PT\"\nsd = 3") +
           of_patella("quantity = \"direction\"\nbundle = \"PT\"\nsd = 5") + follower);
  std::vector<double>& given_strain = job.followers.at(0).reference_strain;
  EXPECT_TRUE(std::isnan(given_strain.at(0))) << "the shape has slack lengths";
  for (std::size_t k = 0; k < given_strain.size(); k += 2) given_strain[k] = 0.02;
  const job::SampledCase samples(job);
  ASSERT_EQ(samples.draw_names().size(), 7u);
  EXPECT_EQ(samples.draw_names()[0], "attachment patella reference QUAD anterior");
  EXPECT_EQ(samples.draw_names()[6], "direction patella PT");
  const job::Follower& given = job.followers.at(0);
  const std::vector<double> strain = job::scan_strains(job.followers, 0);
  int n_lines = 0, n_moved = 0;
  for (const int s : {0, 17, 63}) {
    const job::Case sampled = samples.at(s);
    const job::Follower& patella = sampled.followers.at(0);
    EXPECT_DOUBLE_EQ(patella.directions[0].rest_rad, rad_from_deg(samples.values()(s, 6)));
    const std::vector<double> sampled_strain = job::scan_strains(sampled.followers, 0);
    for (std::size_t k = 0; k < strain.size(); ++k) {
      const model::Fibre &before = given.ligaments.fibres[k], &after = patella.ligaments.fibres[k];
      const Eigen::Vector3d from = after.reference_mm - before.reference_mm,
                            to = after.moving_mm - before.moving_mm;
      const bool is_line = before.tension_n > 0.0, is_tendon = before.bundle == "PT";
      n_lines += is_line;
      n_moved += is_tendon && to.norm() > 0.5;
      EXPECT_NEAR((from - (is_line ? 1.0 : 0.0) * samples.values().row(s).head<3>().transpose()).norm(), 0.0,
                  1e-9)
          << k;
      EXPECT_EQ(to.norm() > 0.0, is_tendon) << k;
      if (is_line) continue;
      if (k % 2 == 0)
        EXPECT_NEAR(sampled_strain[k], strain[k], 1e-9) << k;
      else
        EXPECT_EQ(after.slack_length_mm, before.slack_length_mm) << k;
    }
  }
  EXPECT_GT(n_lines, 3);
  EXPECT_GT(n_moved, 3);
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

}  // namespace vrda::uncertainty_test
