#include "calibration/statistics.hpp"

#include <gtest/gtest.h>

#include "calibration/operator.hpp"

namespace vrda::alignment_test {

/// Tolerance of Newton's method and the secant method.
constexpr double solved_px = 1e-7;

const bench::BenchFile& bench()
{
  static const bench::BenchFile file =
      bench::parse_bench_file(calibration::virtual_bench_text(), "virtual bench");
  return file;
}

TEST(ScanReading, IsTheFirstOrLastOfWhichHalfIsSeen)
{
  struct Row {
    double border_px;
    bool is_last;
    double expected;
  };
  // Column c extends from c to c + 1.
  for (const Row& row : {Row{10.0, false, 10},
                         {10.4, false, 10},
                         {10.5, false, 10},
                         {10.6, false, 11},
                         {20.0, true, 19},
                         {20.4, true, 19},
                         {20.5, true, 20},
                         {20.6, true, 20}}) {
    EXPECT_EQ(calibration::scan_reading(row.border_px, row.is_last), row.expected) << row.border_px;
  }
}

TEST(SideValue, TheLineDrawnThroughWhatWasFoundIsSeenOnTheSide)
{
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const calibration::VirtualTruth truth = calibration::virtual_truth(bench(), seed);
    // The drawing calibration is of another bench: distortion and principal point are wrong.
    const bench::Calibration found = calibration::virtual_truth(bench(), seed + 1).calibration;
    for (const bool is_right : {false, true}) {
      const calibration::RectangleSides sides = calibration::rectangle_sides(bench(), truth, 2);
      calibration::SideLine line;
      line.drawing = view::side_of(found.eyes, is_right);
      line.row_px = line.drawing.sight_px.y();
      const double value =
          calibration::side_value(line, truth, is_right, {sides.left_table_mm, sides.z_table_mm}, 0.0);
      const Eigen::Vector2d drawn = view::drawn_px(line.drawing.distortion, {value, line.row_px});
      const Eigen::Vector2d seen =
          view::shown_px(view::side_of(truth.calibration.eyes, is_right).distortion, drawn);
      // The side's points project onto a line through the seen point.
      const double y_mm = truth.calibration.X_table_eyes.shift_mm.y();
      const Eigen::Vector2d low =
          calibration::seen_px(truth, is_right, {sides.left_table_mm, y_mm - 50.0, sides.z_table_mm});
      const Eigen::Vector2d high =
          calibration::seen_px(truth, is_right, {sides.left_table_mm, y_mm + 50.0, sides.z_table_mm});
      const Eigen::Vector2d along = (high - low).normalized(), off = seen - low;
      EXPECT_NEAR(along.x() * off.y() - along.y() * off.x(), 0.0, solved_px);
      const double aside =
          calibration::side_value(line, truth, is_right, {sides.left_table_mm, sides.z_table_mm}, 0.7);
      EXPECT_NEAR(view::drawn_px(line.drawing.distortion, {aside, line.row_px}).x() - drawn.x(), 0.7,
                  solved_px);
    }
  }
}

TEST(CrossValue, TheCrossDrawnThroughWhatWasFoundIsSeenOnTheMarker)
{
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench(), 3);
  const bench::Calibration found = calibration::virtual_truth(bench(), 9).calibration;
  const view::Eye& eye = truth.calibration.eyes.left;
  const Eigen::Vector2d marker = eye.sight_px + Eigen::Vector2d(120.0, -80.0);
  const Eigen::Vector2d value = calibration::cross_value(found.eyes.left, truth, false, marker, {0.0, 0.0});
  const Eigen::Vector2d seen =
      view::shown_px(eye.distortion, view::drawn_px(found.eyes.left.distortion, value));
  EXPECT_NEAR((seen - marker).norm(), 0.0, solved_px);
}

TEST(DrawnNode, IsSeenOnTheGrid)
{
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench(), 6);
  const view::Eye& eye = truth.calibration.eyes.right;
  const Eigen::Vector2d drawn = calibration::drawn_node_px(truth, true, {2.0, -1.0});
  EXPECT_NEAR((view::shown_px(eye.distortion, drawn) -
               calibration::shown_px(truth.grids[1], eye.pixel_aspect, {2.0, -1.0}))
                  .norm(),
              0.0, solved_px);
}

TEST(SeenLines, AreCurvedByTheOpticsAndEndWithWhatIsSeen)
{
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench(), 2);
  const view::Eye& eye = truth.calibration.eyes.left;
  calibration::DrawnLine line;
  const double row = eye.sight_px.y() - 100.0;
  line.points_px = {{eye.window.x + 0.0, row}, {eye.window.x + eye.window.width + 0.0, row}};
  const std::vector<calibration::DrawnLine> seen = calibration::seen_lines(std::span(&line, 1), truth);
  ASSERT_EQ(seen.size(), 1u);
  const std::vector<Eigen::Vector2d>& points = seen.front().points_px;
  const calibration::VirtualTruth::Edges& edges = truth.edges_px[0];
  EXPECT_NEAR((points.front() - view::shown_px(eye.distortion, {edges.left, row})).norm(), 0.0, solved_px);
  EXPECT_NEAR((points.back() - view::shown_px(eye.distortion, {edges.right, row})).norm(), 0.0, solved_px);
  EXPECT_GT(points.size(), 60u);
  // Pincushion distortion: the ends of a line above the centre are seen higher than its middle.
  EXPECT_LT(points.front().y(), points[points.size() / 2].y() - 1.0);
}

TEST(SeenLines, OneThatLeavesAndComesBackIsTwo)
{
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench(), 2);
  const calibration::VirtualTruth::Edges& e = truth.edges_px[1];
  calibration::DrawnLine line;
  line.is_right = true;
  const double middle = 0.5 * (e.top + e.bottom);
  line.points_px = {{e.right - 50, middle},
                    {e.right + 20, middle},
                    {e.right + 20, middle + 40},
                    {e.right - 50, middle + 40}};
  EXPECT_EQ(calibration::seen_lines(std::span(&line, 1), truth).size(), 2u);
  line.points_px = {{e.right + 5, middle}, {e.right + 20, middle}};
  EXPECT_TRUE(calibration::seen_lines(std::span(&line, 1), truth).empty());
}

TEST(ErrorsOf, AnEstimateOfTheTruthHasNone)
{
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench(), 8);
  const bench::Calibration& c = truth.calibration;
  bench::Estimate estimate;
  estimate.names = {"left.k1",       "right.sight_y", "ipd",          "table.shift_x", "table.shift_y",
                    "table.shift_z", "table.turn_x",  "table.turn_y", "table.turn_z",  "depth_apart"};
  const Eigen::Vector3d turn_deg = c.X_tracker_table.turn_rad * (180.0 / 3.14159265358979323846);
  estimate.values.resize(10);
  estimate.values << c.eyes.left.distortion.k1, c.eyes.right.sight_px.y(),
      c.eyes.right.position_head_mm.x() - c.eyes.left.position_head_mm.x(), c.X_tracker_table.shift_mm,
      turn_deg, c.eyes.left.position_head_mm.z() - c.eyes.right.position_head_mm.z();
  constexpr double rounding = 1e-9;
  EXPECT_NEAR(calibration::errors_of(estimate, truth).norm(), 0.0, rounding);
  estimate.values[1] += 0.25;
  estimate.values[4] -= 2.0;
  const Eigen::VectorXd errors = calibration::errors_of(estimate, truth);
  EXPECT_NEAR(errors[1], 0.25, rounding);
  EXPECT_NEAR(errors[4], -2.0, rounding);
}

TEST(ErrorsOf, ATurnOfAPlaceIsAboutTheFixedAxesFoundLessTrue)
{
  const calibration::VirtualTruth truth = calibration::virtual_truth(bench(), 8);
  const Pose X = bench::pose_of(truth.calibration.X_tracker_table);
  constexpr double deg = 3.14159265358979323846 / 180.0, off_deg = 0.2;
  Pose found = X;
  found.linear() = rotation_y(off_deg * deg) * X.linear();
  const bench::PoseParameters six = bench::pose_parameters_of(found);
  bench::Estimate estimate;
  estimate.names = {"table.shift_x", "table.shift_y", "table.shift_z",
                    "table.turn_x",  "table.turn_y",  "table.turn_z"};
  estimate.values.resize(6);
  estimate.values << six.shift_mm, six.turn_rad / deg;
  const Eigen::VectorXd errors = calibration::errors_of(estimate, truth);
  EXPECT_NEAR((errors.tail<3>() - Eigen::Vector3d(0.0, off_deg, 0.0)).norm(), 0.0, 1e-9);
}

TEST(TargetErrors, AreZeroForTheTruthAndTheLengthOfAShift)
{
  calibration::VirtualNoise none{0, 0, 0, 0, 0, 0, 0};
  for (const bench::HeadKind head : {bench::HeadKind::stage, bench::HeadKind::tracker}) {
    const bench::BenchFile file =
        bench::parse_bench_file(calibration::virtual_bench_text(head), "virtual bench");
    const calibration::VirtualTruth truth = calibration::virtual_truth(file, 11);
    // The encoder counts 5 um.
    const double counted_mm = head == bench::HeadKind::stage ? file.stage_mm_per_count : 1e-9;
    const std::vector<calibration::TargetError> errors =
        calibration::target_errors(truth.calibration, file, truth, none);
    ASSERT_EQ(errors.size(), 40u);
    for (const calibration::TargetError& error : errors) EXPECT_LT(error.mm, counted_mm);
    // The display's image is 2 px higher: 2 px of about 880 at about 800 mm.
    bench::Calibration off = truth.calibration;
    off.eyes.left.sight_px.y() -= 2.0;
    const std::vector<calibration::TargetError> shifted = calibration::target_errors(off, file, truth, none);
    constexpr double expected_mm = 2.0 * 800.0 / 880.0;
    for (std::size_t k = 0; k < shifted.size(); k += 2) {
      // Distances, depths and distortion vary by a fifth.
      EXPECT_NEAR(shifted[k].mm, expected_mm, 0.2 * expected_mm);
      EXPECT_LT(shifted[k + 1].mm, counted_mm);
      EXPECT_NEAR(shifted[k].arc_min, shifted[k].mm / 800.0 * 3437.7, 0.15 * shifted[k].arc_min);
    }
  }
}

}  // namespace vrda::alignment_test
