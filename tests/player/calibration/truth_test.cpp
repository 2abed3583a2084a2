#include "calibration/truth.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bench/rigid_body.hpp"
#include "calibration/bench_poses.hpp"
#include "core/units.hpp"

namespace vrda::truth_test {

bench::BenchFile bench_of(bench::HeadKind head)
{
  return bench::parse_bench_file(calibration::virtual_bench_text(head), "virtual bench");
}

/// Mean square of many draws over their variance: one, within five standard deviations of chi-square.
void expect_variance(double sum_of_squares, int n, double sd)
{
  const double ratio = sum_of_squares / n / (sd * sd);
  EXPECT_NEAR(ratio, 1.0, 5.0 * std::sqrt(2.0 / n));
}

TEST(VirtualBenchText, IsABenchOfEitherHead)
{
  for (const bench::HeadKind head : {bench::HeadKind::stage, bench::HeadKind::tracker}) {
    const bench::BenchFile bench = bench_of(head);
    EXPECT_EQ(bench.head, head);
    EXPECT_EQ(bench.leg, bench::LegKind::rigid);
    EXPECT_TRUE(bench.calibration.is_present);
    int n_targets = 0;
    for (const bench::CalibrationPoint& point : bench.calibration.points)
      n_targets += point.is_target ? 1 : 0;
    EXPECT_EQ(n_targets, 4);
    EXPECT_EQ(bench.calibration.points.size(), 16u);
    EXPECT_EQ(bench.calibration.landmarks.size(), 6u);
    EXPECT_EQ(bench.board.has_value(), head == bench::HeadKind::stage);
  }
}

TEST(VirtualTruth, IsTheSameForTheSameSeedAndUsable)
{
  const bench::BenchFile bench = bench_of(bench::HeadKind::stage);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const calibration::VirtualTruth truth = calibration::virtual_truth(bench, seed);
    EXPECT_EQ(bench::calibration_text(truth.calibration, bench),
              bench::calibration_text(calibration::virtual_truth(bench, seed).calibration, bench));
    EXPECT_NE(bench::calibration_text(truth.calibration, bench),
              bench::calibration_text(calibration::virtual_truth(bench, seed + 1).calibration, bench));
    EXPECT_NO_THROW(view::require_usable(truth.calibration.eyes, "truth"));
  }
}

TEST(VirtualTruth, WhatIsStatedAsKnownIsDrawnWithThoseDeviations)
{
  const bench::BenchFile bench = bench_of(bench::HeadKind::stage);
  constexpr int n = 500;
  double sights = 0.0, heights = 0.0, turns = 0.0;
  for (std::uint64_t seed = 1; seed <= n; ++seed) {
    const calibration::VirtualTruth truth = calibration::virtual_truth(bench, seed);
    const bench::Calibration& c = truth.calibration;
    for (std::size_t k = 0; k < 2; ++k) {
      const calibration::VirtualTruth::Edges& e = truth.edges_px[k];
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

TEST(VirtualTruth, ScreensAndRailsAreConsistent)
{
  const bench::BenchFile bench = bench_of(bench::HeadKind::tracker);
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const calibration::VirtualTruth truth = calibration::virtual_truth(bench, seed);
    const view::Eye& eye = truth.calibration.eyes.right;
    const calibration::VirtualTruth::Edges& e = truth.edges_px[1];
    const double aspect =
        truth.screen_mm[1].y() / (e.bottom - e.top) / (truth.screen_mm[1].x() / (e.right - e.left));
    EXPECT_NEAR(aspect, eye.pixel_aspect, 1e-12);
    EXPECT_NEAR(truth.z_rail_table.norm(), 1.0, 1e-12);
    EXPECT_EQ(truth.z_rail_table.y(), 0.0);
  }
}

TEST(Standing, TheTipRestsAndTheMarkerStaysOnItsRail)
{
  const bench::BenchFile bench = bench_of(bench::HeadKind::stage);
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench, 4);
  const Eigen::Vector3d tip = calibration::pivot_poses(truth, 0.0).X_tracker_tool * truth.tip_probe_mm;
  const Pose X_table_tracker = bench::pose_of(truth.calibration.X_tracker_table).inverse();
  constexpr double rounding_mm = 1e-9;
  for (const double way : {0.0, 0.25, 0.6, 1.0}) {
    SCOPED_TRACE(way);
    EXPECT_NEAR((calibration::pivot_poses(truth, way).X_tracker_tool * truth.tip_probe_mm - tip).norm(), 0.0,
                rounding_mm);
    const calibration::BenchPoses on_x = calibration::x_rail_poses(truth, way);
    const Eigen::Vector3d p = X_table_tracker * on_x.X_tracker_tool.translation();
    EXPECT_NEAR(p.y(), 0.0, rounding_mm);
    EXPECT_NEAR(p.z(), 0.0, rounding_mm);
    // The marker moves along the stage's direction.
    EXPECT_NEAR(on_x.stage_mm - p.x(), calibration::x_rail_poses(truth, 0.0).stage_mm + 150.0, rounding_mm);
    const Eigen::Vector3d q =
        X_table_tracker * calibration::z_rail_poses(truth, way).X_tracker_tool.translation();
    EXPECT_NEAR(q.y(), truth.z_rail_above_mm, rounding_mm);
    EXPECT_NEAR(q.x() * truth.z_rail_table.z(), q.z() * truth.z_rail_table.x(), rounding_mm);
  }
}

TEST(Standing, TouchedPointsAreThoseOfTheScaledModel)
{
  const bench::BenchFile bench = bench_of(bench::HeadKind::stage);
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench, 5);
  const Pose X_body_model = bench::pose_of(truth.calibration.X_body_model[0]);
  for (int index = 0; index < 16; ++index) {
    calibration::TouchedPoint touched;
    touched.index = index;
    touched.p_model_mm = bench.calibration.points[static_cast<std::size_t>(index)].p_model_mm;
    const Eigen::Vector3d tip_body =
        truth.X_tracker_leg.inverse() *
        (calibration::touch_poses(truth, touched).X_tracker_tool * truth.tip_probe_mm);
    const Eigen::Vector3d p_body = X_body_model * (truth.calibration.subject_scale * touched.p_model_mm);
    EXPECT_NEAR((tip_body - p_body).norm(), 0.0, 1e-9);
  }
}

}  // namespace vrda::truth_test
