// Uncertain jobs from job file to bands: samples as steps of a run, the same bytes however they are solved.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>

#include "app/scenes.hpp"
#include "store/journal.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::uncertainty_test {

namespace fs = std::filesystem;
using testing::IsEmpty;

fs::path job_of(const test::Scratch& scratch, const std::string& uncertainty)
{
  static int n = 0;
  const std::string name = "knee_" + std::to_string(n++) + ".toml";
  scratch.write(name, test::coarse_knee_text + uncertainty);
  return scratch.path() / name;
}

test::Ended run(const fs::path& job, const fs::path& output, const std::vector<std::string>& more = {})
{
  return test::run_vrda({"run", job.string(), "-o", output.string(), "--quiet"}, more);
}

store::MotionModel solved(const test::Scratch& scratch, const std::string& uncertainty,
                          const std::vector<std::string>& settings = {})
{
  return test::solved(job_of(scratch, uncertainty), settings);
}

TEST(Uncertainty, AShardThatIsMissingIsNamedWithItsSamples)
{
  const test::Scratch scratch;
  const fs::path job = job_of(scratch, test::stiffness_and_strain), output = scratch.path() / "knee.h5";
  // Four flexions: the fifth of five shards has samples only.
  for (int shard = 1; shard <= 4; ++shard)
    ASSERT_EQ(run(job, output, {"--shard", std::to_string(shard) + "/5"}).exit_code, 0);
  EXPECT_THAT(test::run_vrda({"merge", "-o", output.string()}),
              test::refuses({output.string(), "journals", {"9", "48", "shard 5 of 5"}}));
}

TEST(Uncertainty, WithoutSpreadEverySampleIsTheJob)
{
  const test::Scratch scratch;
  const store::MotionModel model = solved(scratch, R"(
[uncertainty]
samples = 10
[[uncertainty.parameter]]
quantity = "stiffness"
distribution = "normal"
sd = 1e-9
)");
  ASSERT_TRUE(model.uncertainty);
  // Poses of one equilibrium from different starts differ by the tolerance of the solver, and rotation, a
  // flat direction, by more.
  constexpr double same_mm = 0.02, same_deg = 0.1;
  const store::Motion raw(model, "raw");
  for (const std::string& set : store::quantile_set_names(model)) {
    const store::Motion sample(model, set);
    for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
      const double flexion_rad = rad_from_deg(model.flexion_deg[i]);
      const store::JointPose a = raw.at({flexion_rad, raw.balanced_varus_rad(flexion_rad)});
      const store::JointPose b = sample.at({flexion_rad, sample.balanced_varus_rad(flexion_rad)});
      ASSERT_EQ(b.status, store::PoseStatus::solved);
      EXPECT_LT((a.X_reference_moving.translation() - b.X_reference_moving.translation()).norm(),
                5 * same_mm);
      EXPECT_LT(Eigen::AngleAxisd(a.X_reference_moving.linear().transpose() * b.X_reference_moving.linear())
                    .angle(),
                rad_from_deg(same_deg));
    }
  }
  EXPECT_EQ(store::quantile_set_names(model).size(), 5u);
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    EXPECT_EQ(model.uncertainty->n_solved[i], 10);
    EXPECT_NEAR(model.uncertainty->rotation_band_deg[3 * (2 * model.flexion_deg.size() + i) + 2],
                model.clinical[JointCoordinate::internal](row, 0), same_deg);
    EXPECT_NEAR(model.uncertainty->translation_band_mm[3 * (2 * model.flexion_deg.size() + i) + 1],
                model.clinical[JointCoordinate::proximal](row, 0), same_mm);
  }
}

TEST(Uncertainty, ASampleIsTheRunOfAJobWithItsInputs)
{
  const test::Scratch scratch;
  const store::MotionModel model = solved(scratch, R"(
[uncertainty]
samples = 10
sequence = "latin-hypercube"
[[uncertainty.parameter]]
quantity = "load"
load = "moment"
distribution = "uniform"
from = -800
to = 800
[[uncertainty.parameter]]
quantity = "load"
load = "force"
factor = true
distribution = "table"
values = [0.5, 1, 3]
)");
  ASSERT_TRUE(model.uncertainty);
  const store::UncertainMotion& motion = *model.uncertainty;
  EXPECT_THAT(motion.draw, testing::ElementsAre("load moment", "load force"));
  for (const std::size_t s : {0u, 4u, 9u}) {
    SCOPED_TRACE(s);
    const auto number = [](double value) { return std::to_string(value); };
    const store::MotionModel own = solved(scratch, "",
                                          {"push.moment_nmm=" + number(motion.value[2 * s]),
                                           "push.force_n=" + number(20.0 * motion.value[2 * s + 1])});
    for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
      const std::size_t at = s * model.flexion_deg.size() + i;
      const auto row = static_cast<Eigen::Index>(i);
      // Facets make equilibria a fraction of a degree apart (solve/uncertain_motion).
      EXPECT_NEAR(motion.rotation_deg[3 * at + 2], own.clinical[JointCoordinate::internal](row, 0), 0.5);
      EXPECT_NEAR(motion.translation_mm[3 * at], own.clinical[JointCoordinate::anterior](row, 0), 0.1);
      EXPECT_NEAR(motion.translation_mm[3 * at + 1], own.clinical[JointCoordinate::proximal](row, 0), 0.05);
    }
  }
  // The moment alone decides the rotation.
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i) {
    std::vector<std::pair<double, double>> of_moment;
    for (std::size_t s = 0; s < 10; ++s)
      of_moment.emplace_back(motion.value[2 * s],
                             motion.rotation_deg[3 * (s * model.flexion_deg.size() + i) + 2]);
    std::sort(of_moment.begin(), of_moment.end());
    EXPECT_LT(of_moment.front().second, of_moment.back().second) << "internal rotation rises with the moment";
  }
}

TEST(Uncertainty, FailedSamplesAreCountedAndLeftOut)
{
  const test::Scratch scratch;
  const store::MotionModel model = solved(scratch, R"(
[uncertainty]
samples = 12
[[uncertainty.parameter]]
quantity = "load"
load = "anterior_force"
distribution = "uniform"
from = 0
to = 200000
)");
  ASSERT_TRUE(model.uncertainty);
  const store::UncertainMotion& motion = *model.uncertainty;
  const auto n_stable = std::count(motion.status.begin(), motion.status.end(), status_stable);
  EXPECT_LT(n_stable, 48) << "100 kN pull the tibia off the femur";
  EXPECT_EQ(n_stable, std::accumulate(motion.n_solved.begin(), motion.n_solved.end(), 0));
  for (std::size_t i = 0; i < model.flexion_deg.size(); ++i)
    EXPECT_EQ(std::isfinite(motion.rotation_band_deg[3 * (2 * model.flexion_deg.size() + i)]),
              motion.n_solved[i] > 0);
}

TEST(Uncertainty, FramesHaveSamplesToo)
{
  const test::Scratch scratch;
  scratch.write("frames.csv", "time_s,flexion_deg\n0,20\n0.5,5\n1,20\n");
  std::string text = test::coarse_knee_text + (R"(
[uncertainty]
samples = 10
[[uncertainty.parameter]]
quantity = "stiffness"
distribution = "normal"
sd = 0.2
[[uncertainty.parameter]]
quantity = "rotation_centre"
distribution = "uniform"
to = 3
)");
  const std::string grid = "[grid]\nflexion = { from = 0, to = 30, step = 10 }\nvarus = \"free\"\n";
  text.replace(text.find(grid), grid.size(),
               "[frames]\nfile = \"frames.csv\"\n[coordinates]\nflexion = { column = \"flexion_deg\" }\n");
  scratch.write("frames.toml", text);
  const fs::path output = scratch.path() / "frames.h5";
  const test::Ended ended = run(scratch.path() / "frames.toml", output);
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const store::MotionModel model = store::read_motion_model(output.string());
  ASSERT_TRUE(model.uncertainty);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(model.uncertainty->n_solved[i], 10);
    for (const std::size_t p : {0u, 4u})
      EXPECT_NEAR(model.uncertainty->rotation_band_deg[3 * (3 * p + i)], i == 1 ? 5.0 : 20.0, 1e-9)
          << "flexion is given";
  }
  EXPECT_THAT(store::quantile_set_names(model), IsEmpty());
}

TEST(Uncertainty, BandsArePrintedAsTablesAndJson)
{
  const test::Scratch scratch;
  const fs::path job = job_of(scratch, test::stiffness_and_strain), output = scratch.path() / "knee.h5";
  ASSERT_EQ(run(job, output).exit_code, 0);
  const store::UncertainMotion motion = *store::read_motion_model(output.string()).uncertainty;
  const test::Ended bands = test::run_vrda({"bands", output.string()});
  EXPECT_EQ(test::n_lines(bands.out), 1 + 4);
  EXPECT_THAT(bands.out, testing::StartsWith("flexion_deg,solved,flexion_min_deg"));
  const auto json = test::json_of({"bands", output.string()});
  EXPECT_EQ(json["samples"], 48);
  EXPECT_EQ(json["quantities"].size(), 9u);
  EXPECT_NEAR(json["quantities"][2]["p95"][1].get<double>(), motion.rotation_band_deg[3 * (3 * 4 + 1) + 2],
              1e-6);
  double sum = 0.0;
  for (const auto& share : json["quantities"][2]["shares"]) sum += share["first_order"].get<double>();
  EXPECT_GT(sum, 0.5) << "most of the spread of rotation comes from single draws";
  const auto n_fibres = static_cast<std::ptrdiff_t>(motion.tension_band_n.size() / (5 * 4));
  EXPECT_EQ(test::n_lines(test::run_vrda({"bands", output.string(), "--table", "fibres"}).out),
            1 + 4 * n_fibres);
  EXPECT_EQ(test::n_lines(test::run_vrda({"bands", output.string(), "--table", "samples"}).out), 1 + 4 * 48);
  EXPECT_EQ(test::n_lines(test::run_vrda({"bands", output.string(), "--table", "shares"}).out),
            1 + 9 * 4 * static_cast<std::ptrdiff_t>(motion.draw.size()));

  const fs::path certain = job_of(scratch, ""), without = scratch.path() / "certain.h5";
  ASSERT_EQ(run(certain, without).exit_code, 0);
  test::expect_refused({"bands", without.string()}, {.file = without.string(), .field = "/uncertainty"});
}

}  // namespace vrda::uncertainty_test
