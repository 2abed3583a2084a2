// The job everybody starts with, whole: 91 x 21 attitudes of jobs/knee-generic.toml.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <numeric>
#include <thread>

#include "app/remeasure.hpp"
#include "app/scenes.hpp"
#include "app/summary.hpp"
#include "store/motion_model_file.hpp"
#include "support/real_knees.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;

const std::string job = (test::source_directory() / "jobs" / "knee-generic.toml").string();

std::vector<Eigen::Index> spine_of(const MotionModel& model)
{
  std::vector<Eigen::Index> spine;
  for (Eigen::Index i = 0; i < model.is_spine.rows(); ++i) {
    Eigen::Index column = 0;
    model.is_spine.row(i).maxCoeff(&column);
    spine.push_back(column);
  }
  return spine;
}

void expect_balanced_spine(const MotionModel& model)
{
  const std::vector<Eigen::Index> spine = spine_of(model);
  const auto difference = [&](Eigen::Index i, Eigen::Index j) {
    return model.gap_medial_mm(i, j) - model.gap_lateral_mm(i, j);
  };
  for (Eigen::Index i = 0; i < model.status.rows(); ++i) {
    SCOPED_TRACE(model.flexion_deg[static_cast<std::size_t>(i)]);
    const Eigen::Index j = spine[static_cast<std::size_t>(i)];
    ASSERT_GT(j, 0);
    ASSERT_LT(j, model.status.cols() - 1);
    const bool both_touch = model.contact_medial(i, j) == 1 && model.contact_lateral(i, j) == 1;
    EXPECT_TRUE(both_touch || difference(i, j - 1) * difference(i, j + 1) < 0.0)
        << difference(i, j - 1) << ' ' << difference(i, j) << ' ' << difference(i, j + 1);
  }
}

// Mean internal rotation along the spine between two flexions: the facets of the mesh move single values by
// two degrees either way (DESIGN.md 5.3), a mean over ten flexions by well under one.
double mean_rotation_deg(const MotionModel& model, double from_deg, double to_deg)
{
  const std::vector<Eigen::Index> spine = spine_of(model);
  double sum = 0.0;
  int n = 0;
  for (std::size_t i = 0; i < spine.size(); ++i) {
    if (model.flexion_deg[i] < from_deg || model.flexion_deg[i] > to_deg) continue;
    sum += model.clinical.internal_rotation_deg(static_cast<Eigen::Index>(i), spine[i]);
    ++n;
  }
  return sum / n;
}

TEST(GenericKnee, EveryAttitudeIsSolvedBalancedTouchingAndTurnsTheAnatomicalWay)
{
  const test::Scratch scratch;
  const std::string output = (scratch.path() / "knee.h5").string();
  const test::Ended ended = test::run_vrda({"run", job, "-o", output, "--progress", "none"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const MotionModel model = read_motion_model(output);
  EXPECT_THAT(validate_motion_model(output), testing::IsEmpty());
  EXPECT_EQ(model.status.rows(), 91);
  EXPECT_EQ(model.status.cols(), 21);
  EXPECT_EQ(unsolved_fraction(model), 0.0) << status_line(model);
  expect_balanced_spine(model);

  // Screw-home: the tibia turns inward as the knee bends, half of it early (Walker 1988: 15 degrees over 100
  // of flexion, half by 25).
  const double extended_deg = mean_rotation_deg(model, 0, 9), early_deg = mean_rotation_deg(model, 25, 34);
  const double middle_deg = mean_rotation_deg(model, 45, 54), flexed_deg = mean_rotation_deg(model, 81, 90);
  EXPECT_GT(early_deg, extended_deg + 2.0);
  EXPECT_GT(middle_deg, early_deg - 1.0);
  EXPECT_GT(flexed_deg, middle_deg - 1.0);
  EXPECT_THAT(flexed_deg - extended_deg, testing::AllOf(testing::Gt(5.0), testing::Lt(20.0)));

  const AuditExtremes audit = extremes(model, remeasured(model, 2));
  EXPECT_EQ(audit.n_overlapping, 0);
  EXPECT_EQ(audit.largest_penetration_mm, 0.0);
  EXPECT_LE(audit.largest_gap_mm, model.contact_resolution_mm);
}

TEST(GenericKnee, OneHashForThreadsProcessorFeaturesAndKills)
{
  const test::Scratch scratch;
  const fs::path one = scratch.path() / "one.h5", two = scratch.path() / "two.h5",
                 plain = scratch.path() / "plain.h5";
  ASSERT_EQ(
      test::run_vrda({"run", job, "-o", one.string(), "--threads", "1", "--progress", "none"}).exit_code, 0);
  const std::string hash = test::sha256_of_file(one);

  test::Command without_avx = test::vrda({"run", job, "-o", plain.string(), "--progress", "none"});
  without_avx.environment["GLIBC_TUNABLES"] = "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable";
  ASSERT_EQ(test::run(without_avx).exit_code, 0);
  EXPECT_EQ(test::sha256_of_file(plain), hash);

  // Two threads, killed three times on the way.
  const fs::path journal = two.string() + ".journal";
  std::uintmax_t written = 0;
  for (int k = 0; k < 3; ++k) {
    test::Process process(
        test::vrda({"run", job, "-o", two.string(), "--threads", "2", "--progress", "none"}));
    std::error_code ignored;
    while (process.is_running() &&
           (!fs::exists(journal) || fs::file_size(journal, ignored) < written + 200000)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_TRUE(process.is_running());
    process.send(SIGKILL);
    process.wait();
    written = fs::file_size(journal);
  }
  ASSERT_EQ(
      test::run_vrda({"run", job, "-o", two.string(), "--threads", "2", "--progress", "none"}).exit_code, 0);
  EXPECT_EQ(test::sha256_of_file(two), hash);
}

}  // namespace
}  // namespace vrda
