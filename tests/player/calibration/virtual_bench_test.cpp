// The truth of a virtual bench, and the errors of estimates and calibrations against it.
#include <gtest/gtest.h>

#include <cmath>

#include "bench/rigid_body.hpp"
#include "calibration/statistics.hpp"
#include "core/units.hpp"
#include "player/calibration/trial.hpp"

namespace vrda::calibration::virtual_bench_test {

/// Mean square of many draws over their variance: one, within five standard deviations of chi-square.
void expect_variance(double sum_of_squares, int n, double sd)
{
  const double ratio = sum_of_squares / n / (sd * sd);
  EXPECT_NEAR(ratio, 1.0, 5.0 * std::sqrt(2.0 / n));
}

TEST(VirtualTruth, IsTheSameForTheSameSeedAndUsable)
{
  const BenchFile bench = test::virtual_bench(HeadKind::stage);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const VirtualTruth truth = virtual_truth(bench, seed);
    EXPECT_EQ(bench::calibration_text(truth.calibration, bench),
              bench::calibration_text(virtual_truth(bench, seed).calibration, bench));
    EXPECT_NE(bench::calibration_text(truth.calibration, bench),
              bench::calibration_text(virtual_truth(bench, seed + 1).calibration, bench));
    EXPECT_NO_THROW(view::require_usable(truth.calibration.eyes, "truth"));
  }
}

TEST(VirtualTruth, WhatIsStatedAsKnownIsDrawnWithThoseDeviations)
{
  const BenchFile bench = test::virtual_bench(HeadKind::stage);
  constexpr int n = 500;
  double sights = 0.0, heights = 0.0, turns = 0.0;
  for (std::uint64_t seed = 1; seed <= n; ++seed) {
    const VirtualTruth truth = virtual_truth(bench, seed);
    const Calibration& c = truth.calibration;
    for (std::size_t k = 0; k < 2; ++k) {
      const VirtualTruth::Edges& e = truth.edges_px[k];
      const Eigen::Vector2d middle = 0.5 * Eigen::Vector2d(e.left + e.right, e.top + e.bottom);
      sights += ((k == 0 ? c.eyes.left : c.eyes.right).sight_px - middle).squaredNorm();
    }
    heights += std::pow(c.eyes.left.position_head_mm.y() - c.eyes.right.position_head_mm.y(), 2);
    turns += bench::turn_of(bench::pose_of(c.X_table_eyes).linear()).squaredNorm();
  }
  expect_variance(sights, 4 * n, bench.calibration.sight_sd_px);
  expect_variance(heights, n, bench.calibration.eye_height_sd_mm);
  expect_variance(turns, 3 * n, bench.calibration.alignment_sd_rad);
}

/// Tolerance of Newton's method and the secant method.
constexpr double solved_px = 1e-7;

TEST(SeenLines, AreCurvedByTheOpticsAndEndWithWhatIsSeen)
{
  const VirtualTruth truth = virtual_truth(test::bench(), 2);
  const view::Eye& eye = truth.calibration.eyes.left;
  DrawnLine line;
  const double row = eye.sight_px.y() - 100.0;
  line.points_px = {{eye.window.x + 0.0, row}, {eye.window.x + eye.window.width + 0.0, row}};
  const std::vector<DrawnLine> seen = seen_lines(std::span(&line, 1), truth);
  ASSERT_EQ(seen.size(), 1u);
  const std::vector<Eigen::Vector2d>& points = seen.front().points_px;
  const VirtualTruth::Edges& edges = truth.edges_px[0];
  EXPECT_NEAR((points.front() - view::shown_px(eye.distortion, {edges.left, row})).norm(), 0.0, solved_px);
  EXPECT_NEAR((points.back() - view::shown_px(eye.distortion, {edges.right, row})).norm(), 0.0, solved_px);
  EXPECT_GT(points.size(), 60u);
  // Pincushion distortion: the ends of a line above the centre are seen higher than its middle.
  EXPECT_LT(points.front().y(), points[points.size() / 2].y() - 1.0);
}

TEST(SeenLines, OneThatLeavesAndComesBackIsTwo)
{
  const VirtualTruth truth = virtual_truth(test::bench(), 2);
  const VirtualTruth::Edges& e = truth.edges_px[1];
  DrawnLine line;
  line.is_right = true;
  const double middle = 0.5 * (e.top + e.bottom);
  line.points_px = {{e.right - 50, middle},
                    {e.right + 20, middle},
                    {e.right + 20, middle + 40},
                    {e.right - 50, middle + 40}};
  EXPECT_EQ(seen_lines(std::span(&line, 1), truth).size(), 2u);
  line.points_px = {{e.right + 5, middle}, {e.right + 20, middle}};
  EXPECT_TRUE(seen_lines(std::span(&line, 1), truth).empty());
}

TEST(ErrorsOf, AnEstimateOfTheTruthHasNone)
{
  const VirtualTruth truth = virtual_truth(test::bench(), 8);
  const Calibration& c = truth.calibration;
  Estimate estimate;
  estimate.names = {"left.k1",       "right.sight_y", "ipd",          "table.shift_x", "table.shift_y",
                    "table.shift_z", "table.turn_x",  "table.turn_y", "table.turn_z",  "depth_apart"};
  const Eigen::Vector3d turn_deg = c.X_tracker_table.turn_rad * (180.0 / 3.14159265358979323846);
  estimate.values.resize(10);
  estimate.values << c.eyes.left.distortion.k1, c.eyes.right.sight_px.y(),
      c.eyes.right.position_head_mm.x() - c.eyes.left.position_head_mm.x(), c.X_tracker_table.shift_mm,
      turn_deg, c.eyes.left.position_head_mm.z() - c.eyes.right.position_head_mm.z();
  constexpr double rounding = 1e-9;
  EXPECT_NEAR(errors_of(estimate, truth).norm(), 0.0, rounding);
  estimate.values[1] += 0.25;
  estimate.values[4] -= 2.0;
  const Eigen::VectorXd errors = errors_of(estimate, truth);
  EXPECT_NEAR(errors[1], 0.25, rounding);
  EXPECT_NEAR(errors[4], -2.0, rounding);
}

TEST(ErrorsOf, ATurnOfAPlaceIsAboutTheFixedAxesFoundLessTrue)
{
  const VirtualTruth truth = virtual_truth(test::bench(), 8);
  const Pose X = bench::pose_of(truth.calibration.X_tracker_table);
  constexpr double deg = 3.14159265358979323846 / 180.0, off_deg = 0.2;
  Pose found = X;
  found.linear() = rotation_y(off_deg * deg) * X.linear();
  const bench::PoseParameters six = bench::pose_parameters_of(found);
  Estimate estimate;
  estimate.names = {"table.shift_x", "table.shift_y", "table.shift_z",
                    "table.turn_x",  "table.turn_y",  "table.turn_z"};
  estimate.values.resize(6);
  estimate.values << six.shift_mm, six.turn_rad / deg;
  const Eigen::VectorXd errors = errors_of(estimate, truth);
  EXPECT_NEAR((errors.tail<3>() - Eigen::Vector3d(0.0, off_deg, 0.0)).norm(), 0.0, 1e-9);
}

TEST(TargetErrors, AreZeroForTheTruthAndTheLengthOfAShift)
{
  VirtualNoise none{0, 0, 0, 0, 0, 0, 0};
  for (const HeadKind head : {HeadKind::stage, HeadKind::tracker}) {
    const BenchFile file = test::virtual_bench(head);
    const VirtualTruth truth = virtual_truth(file, 11);
    // The encoder counts 5 um.
    const double counted_mm = head == HeadKind::stage ? file.stage_mm_per_count : 1e-9;
    const std::vector<TargetError> errors = calibration::target_errors(truth.calibration, file, truth, none);
    ASSERT_EQ(errors.size(), 40u);
    for (const TargetError& error : errors) EXPECT_LT(error.mm, counted_mm);
    // The display's image is 2 px higher: 2 px of about 880 at about 800 mm.
    Calibration off = truth.calibration;
    off.eyes.left.sight_px.y() -= 2.0;
    const std::vector<TargetError> shifted = calibration::target_errors(off, file, truth, none);
    constexpr double expected_mm = 2.0 * 800.0 / 880.0;
    for (std::size_t k = 0; k < shifted.size(); k += 2) {
      // Distances, depths and distortion vary by a fifth.
      EXPECT_NEAR(shifted[k].mm, expected_mm, 0.2 * expected_mm);
      EXPECT_LT(shifted[k + 1].mm, counted_mm);
      EXPECT_NEAR(shifted[k].arc_min, shifted[k].mm / 800.0 * 3437.7, 0.15 * shifted[k].arc_min);
    }
  }
}

}  // namespace vrda::calibration::virtual_bench_test
