#include "calibration/drawing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "calibration/parts.hpp"
#include "calibration/task.hpp"
#include "player/calibration/trial.hpp"

namespace vrda::drawing_test {

using test::Trial;

/// Rounding error of clipping.
constexpr double rounding_px = 1e-9;

std::vector<double> begin_of(const calibration::Task& task)
{
  std::vector<double> values;
  for (const calibration::Dial& dial : task.dials) values.push_back(dial.value);
  return values;
}

struct Drawn {
  calibration::Task task;
  std::vector<calibration::DrawnLine> lines;
};

/// All tasks of a bench with their lines, for the true eyes.
std::vector<Drawn> all_drawn(const bench::BenchFile& bench, const bench::Calibration& calibration)
{
  std::vector<Drawn> drawn;
  for (const bench::CalibrationPart part : calibration::parts_of(bench)) {
    for (const calibration::Task& task : calibration::tasks_of(part, bench, calibration))
      drawn.push_back({task, calibration::task_lines(task, begin_of(task), calibration)});
  }
  return drawn;
}

bench::BenchFile adjusted_bench()
{
  const std::string head = "[calibration]\n";
  return test::virtual_bench(bench::HeadKind::stage, head, head + "distortion = \"adjust\"\n");
}

void expect_within(const calibration::DrawnLine& line, const view::Viewport& v)
{
  for (const Eigen::Vector2d& p : line.points_px) {
    EXPECT_GE(p.x(), v.x - rounding_px);
    EXPECT_LE(p.x(), v.x + v.width + rounding_px);
    EXPECT_GE(p.y(), v.y - rounding_px);
    EXPECT_LE(p.y(), v.y + v.height + rounding_px);
  }
}

TEST(CalibrationDrawing, StaysWithinWhatIsVisible)
{
  int n_lines = 0;
  for (const bench::BenchFile& bench : {test::virtual_bench(bench::HeadKind::stage), adjusted_bench()}) {
    const bench::Calibration truth = calibration::virtual_truth(bench, 3).calibration;
    for (const Drawn& drawn : all_drawn(bench, truth)) {
      SCOPED_TRACE(drawn.task.name);
      for (const calibration::DrawnLine& line : drawn.lines) {
        const view::Eye& eye = view::side_of(truth.eyes, line.is_right);
        const bool is_scan = drawn.task.kind == calibration::TaskKind::scan_line;
        expect_within(line, is_scan ? eye.window : eye.visible);
        EXPECT_GE(line.points_px.size(), 2u);
        n_lines += is_scan ? 0 : 1;
        // Only the arms of a plain cross are always straight.
        const double longest_px = drawn.task.kind == calibration::TaskKind::point ? 16.0 : 8.0;
        for (std::size_t k = 1; !is_scan && k < line.points_px.size(); ++k)
          EXPECT_LE((line.points_px[k] - line.points_px[k - 1]).norm(), longest_px + rounding_px);
      }
    }
  }
  EXPECT_GT(n_lines, 1000);
}

TEST(CalibrationDrawing, AnAlignedCrossThatLiesOutsideDrawsNothing)
{
  const bench::BenchFile bench = test::virtual_bench(bench::HeadKind::stage);
  const bench::Calibration truth = calibration::virtual_truth(bench, 3).calibration;
  const calibration::Task task =
      calibration::tasks_of(bench::CalibrationPart::distortion, bench, truth).front();
  const view::Viewport& v = truth.eyes.left.visible;
  EXPECT_TRUE(calibration::task_lines(task, std::vector<double>{v.x - 20.0, v.y - 20.0}, truth).empty());
  // Half of it inside.
  EXPECT_EQ(calibration::task_lines(task, std::vector<double>{v.x + 0.0, v.y + 50.0}, truth).size(), 2u);
}

TEST(CalibrationDrawing, AScanLineIsOneCrispColumnOrRow)
{
  const bench::BenchFile bench = test::virtual_bench(bench::HeadKind::stage);
  const bench::Calibration nominal = bench::nominal_calibration(bench);
  const std::vector<calibration::Task> tasks =
      calibration::tasks_of(bench::CalibrationPart::viewport, bench, nominal);
  const std::vector<calibration::DrawnLine> column =
      calibration::task_lines(tasks[0], std::vector<double>{700}, nominal);
  ASSERT_EQ(column.size(), 1u);
  const view::Viewport& window = bench.display.windows.left;
  EXPECT_FALSE(column[0].is_smooth);
  EXPECT_EQ(column[0].width_px, 1.0);
  EXPECT_EQ(column[0].points_px[0], Eigen::Vector2d(700.5, window.y));
  EXPECT_EQ(column[0].points_px[1], Eigen::Vector2d(700.5, window.y + window.height));
  const std::vector<calibration::DrawnLine> row =
      calibration::task_lines(tasks[2], std::vector<double>{100}, nominal);
  EXPECT_EQ(row[0].points_px[0], Eigen::Vector2d(window.x, 100.5));
  EXPECT_EQ(row[0].points_px[1], Eigen::Vector2d(window.x + window.width, 100.5));
}

/// Pre-distorted lines are straight after the optics.
TEST(CalibrationDrawing, SidesAreUprightAsShown)
{
  const bench::BenchFile bench = test::virtual_bench(bench::HeadKind::stage);
  const bench::Calibration truth = calibration::virtual_truth(bench, 3).calibration;
  const view::Eye& eye = truth.eyes.left;
  const calibration::Task task =
      calibration::tasks_of(bench::CalibrationPart::eyepoints, bench, truth).front();
  const std::vector<double> sides{eye.sight_px.x() - 90.0, eye.sight_px.x() + 75.0};
  const std::vector<calibration::DrawnLine> lines = calibration::task_lines(task, sides, truth);
  ASSERT_EQ(lines.size(), 2u);
  // The sagitta of an 8 px chord is 8^2 / (8 radius); chords occur only at clipped ends.
  constexpr double chord_px = 0.02;
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_FALSE(lines[k].is_right);
    for (const Eigen::Vector2d& p : lines[k].points_px)
      EXPECT_NEAR(view::shown_px(eye.distortion, p).x(), sides[k], chord_px);
    const double height = lines[k].points_px.back().y() - lines[k].points_px.front().y();
    EXPECT_NEAR(height, eye.visible.height, 1.0);
  }
}

/// Sets the number of the current task and confirms it.
void give(Trial& trial, double wanted)
{
  const double step = trial.session->task()->dials[0].step;
  const long n = std::lround((wanted - trial.session->values()[0]) / step);
  for (long k = 0; k < std::labs(n); ++k) trial.press(n > 0 ? view::Key::right : view::Key::left);
  trial.press(view::Key::enter);
}

/// The look draws the test object with the new measurements before they are confirmed.
TEST(CalibrationDrawing, ALookIsDrawnByTheMarksOfItsPart)
{
  Trial trial(test::virtual_bench(bench::HeadKind::stage));
  trial.go_to(bench::CalibrationPart::ipd, "pupillary distance");
  struct Row {
    double ipd_mm, image_mm;
  };
  for (const Row& row : {Row{59.0, 900.0}, Row{69.0, 700.0}}) {
    SCOPED_TRACE(row.ipd_mm);
    give(trial, row.ipd_mm);
    give(trial, 0.5 * row.ipd_mm);
    give(trial, 0.5 * row.ipd_mm);
    give(trial, row.image_mm);
    ASSERT_TRUE(trial.is_requested(bench::CalibrationPart::ipd, "look"));
    // The calibration changes only after the confirmation.
    const bench::Calibration& now = trial.session->calibration();
    EXPECT_FALSE(now.records.at(bench::CalibrationPart::ipd).estimate);
    const std::vector<calibration::DrawnLine> lines = calibration::task_lines(*trial.session);
    ASSERT_EQ(lines.size(), 8u);
    for (const bool is_right : {false, true}) {
      view::Eye eye = view::side_of(now.eyes, is_right);
      eye.position_head_mm.x() = (is_right ? 0.5 : -0.5) * row.ipd_mm;
      const Eigen::Vector3d corner(-0.5 * calibration::test_frame_size_mm,
                                   -0.5 * calibration::test_frame_size_mm, -row.image_mm);
      constexpr double step_of_dial_px = 1e-6;
      EXPECT_LT((lines[is_right ? 4 : 0].points_px[0] - view::drawn_px(eye, corner)).norm(), step_of_dial_px);
    }
    trial.press('R');
    EXPECT_TRUE(trial.is_requested(bench::CalibrationPart::ipd, "pupillary distance"));
  }
}

/// On the virtual bench both frames have the same size and disparity.
TEST(CalibrationDrawing, WithoutNoiseTheLookIsSeenWhereTheRealOneIs)
{
  const bench::BenchFile bench = test::virtual_bench(bench::HeadKind::stage);
  Trial trial(bench);
  calibration::VirtualOperator steady(bench, trial.truth, calibration::VirtualNoise{0, 0, 0, 0, 0, 0, 0});
  while (!trial.is_requested(bench::CalibrationPart::ipd, "look")) steady.do_task(*trial.session);
  const std::vector<calibration::DrawnLine> seen =
      calibration::seen_lines(calibration::task_lines(*trial.session), trial.truth);
  const std::vector<calibration::DrawnLine> real =
      calibration::physical_outlines(*trial.session->task(), bench, trial.truth);
  ASSERT_EQ(real.size(), 2u);
  std::array<double, 2> width_px{}, middle_px{};
  for (const bool is_right : {false, true}) {
    double low = 1e9, high = -1e9;
    for (const calibration::DrawnLine& line : seen) {
      for (const Eigen::Vector2d& p : line.points_px) {
        if (line.is_right != is_right) continue;
        low = std::min(low, p.x());
        high = std::max(high, p.x());
      }
    }
    const std::vector<Eigen::Vector2d>& corners = real[is_right ? 1 : 0].points_px;
    const view::Eye& eye = view::side_of(trial.truth.calibration.eyes, is_right);
    width_px[is_right] = (high - low) - (corners[1].x() - corners[0].x());
    // The optical axis is estimated later by the bull's-eyes; relative to it the drawing is correct.
    middle_px[is_right] = 0.5 * (low + high) -
                          view::side_of(trial.session->drawing_calibration().eyes, is_right).sight_px.x() -
                          (0.5 * (corners[0].x() + corners[1].x()) - eye.sight_px.x());
  }
  // The distance of 880 px is determined to a step of 0.25 px at each side: 0.3 % of 110 px.
  constexpr double step_px = 0.4;
  for (const std::size_t k : {0U, 1U}) {
    EXPECT_NEAR(width_px[k], 0.0, step_px);
    EXPECT_NEAR(middle_px[k], 0.0, step_px);
  }
}

TEST(CalibrationDrawing, TheTestObjectIsAtTheImagesDistanceForBothEyes)
{
  const bench::BenchFile bench = test::virtual_bench(bench::HeadKind::stage);
  const bench::Calibration truth = calibration::virtual_truth(bench, 3).calibration;
  const calibration::Task task = calibration::tasks_of(bench::CalibrationPart::ipd, bench, truth).back();
  ASSERT_EQ(task.kind, calibration::TaskKind::depth_check);
  const std::vector<calibration::DrawnLine> lines = calibration::task_lines(task, {}, truth);
  ASSERT_EQ(lines.size(), 8u);
  for (const bool is_right : {false, true}) {
    const view::Eye& eye = view::side_of(truth.eyes, is_right);
    const Eigen::Vector3d corner(-0.5 * calibration::test_frame_size_mm,
                                 -0.5 * calibration::test_frame_size_mm, -truth.image_distance_mm);
    EXPECT_EQ(lines[is_right ? 4 : 0].is_right, is_right);
    EXPECT_LT((lines[is_right ? 4 : 0].points_px[0] - view::drawn_px(eye, corner)).norm(), rounding_px);
  }
}

}  // namespace vrda::drawing_test
