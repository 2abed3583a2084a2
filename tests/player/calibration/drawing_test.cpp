#include "calibration/drawing.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

#include "calibration/parts.hpp"
#include "calibration/task.hpp"
#include "player/calibration/trial.hpp"

namespace vrda::calibration::drawing_test {

using test::Trial;

/// Rounding error of clipping.
constexpr double rounding_px = 1e-9;

std::vector<double> begin_of(const Task& task)
{
  std::vector<double> values;
  for (const Dial& dial : task.dials) values.push_back(dial.value);
  return values;
}

struct Drawn {
  Task task;
  std::vector<DrawnLine> lines;
};

/// All tasks of a bench with their lines, for the true eyes.
std::vector<Drawn> all_drawn(const BenchFile& bench, const Calibration& calibration)
{
  std::vector<Drawn> drawn;
  for (const CalibrationPart part : parts_of(bench)) {
    for (const Task& task : calibration::tasks_of(part, bench, calibration))
      drawn.push_back({task, task.kind->draw(task, begin_of(task), calibration)});
  }
  return drawn;
}

BenchFile adjusted_bench()
{
  const std::string head = "[calibration]\n";
  return test::virtual_bench(HeadKind::stage, head, head + "distortion = \"adjust\"\n");
}

void expect_within(const DrawnLine& line, const view::Viewport& v)
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
  for (const BenchFile& bench : {test::virtual_bench(HeadKind::stage), adjusted_bench()}) {
    const Calibration truth = virtual_truth(bench, 3).calibration;
    for (const Drawn& drawn : all_drawn(bench, truth)) {
      SCOPED_TRACE(drawn.task.name);
      for (const DrawnLine& line : drawn.lines) {
        const view::Eye& eye = view::side_of(truth.eyes, line.is_right);
        const bool is_scan = test::kind_of(drawn.task) == "scan line";
        expect_within(line, is_scan ? eye.window : eye.visible);
        EXPECT_GE(line.points_px.size(), 2u);
        n_lines += is_scan ? 0 : 1;
        // Only the arms of a plain cross are always straight.
        const double longest_px = test::kind_of(drawn.task) == "node" ? 16.0 : 8.0;
        for (std::size_t k = 1; !is_scan && k < line.points_px.size(); ++k)
          EXPECT_LE((line.points_px[k] - line.points_px[k - 1]).norm(), longest_px + rounding_px);
      }
    }
  }
  EXPECT_GT(n_lines, 1000);
}

TEST(CalibrationDrawing, AnAlignedCrossThatLiesOutsideDrawsNothing)
{
  const BenchFile bench = test::virtual_bench(HeadKind::stage);
  const Calibration truth = virtual_truth(bench, 3).calibration;
  const Task task = calibration::tasks_of(CalibrationPart::distortion, bench, truth).front();
  const view::Viewport& v = truth.eyes.left.visible;
  EXPECT_TRUE(task.kind->draw(task, std::vector<double>{v.x - 20.0, v.y - 20.0}, truth).empty());
  // Half of it inside.
  EXPECT_EQ(task.kind->draw(task, std::vector<double>{v.x + 0.0, v.y + 50.0}, truth).size(), 2u);
}

/// Pre-distorted lines are straight after the optics.
TEST(CalibrationDrawing, SidesAreUprightAsShown)
{
  const BenchFile bench = test::virtual_bench(HeadKind::stage);
  const Calibration truth = virtual_truth(bench, 3).calibration;
  const view::Eye& eye = truth.eyes.left;
  const Task task = calibration::tasks_of(CalibrationPart::eyepoints, bench, truth).front();
  const std::vector<double> sides{eye.sight_px.x() - 90.0, eye.sight_px.x() + 75.0};
  const std::vector<DrawnLine> lines = task.kind->draw(task, sides, truth);
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
  Trial trial(test::virtual_bench(HeadKind::stage));
  trial.go_to(CalibrationPart::ipd, "pupillary distance");
  struct Row {
    double ipd_mm, image_mm;
  };
  for (const Row& row : {Row{59.0, 900.0}, Row{69.0, 700.0}}) {
    SCOPED_TRACE(row.ipd_mm);
    give(trial, row.ipd_mm);
    give(trial, 0.5 * row.ipd_mm);
    give(trial, 0.5 * row.ipd_mm);
    give(trial, row.image_mm);
    ASSERT_TRUE(trial.is_requested(CalibrationPart::ipd, "look"));
    // The calibration changes only after the confirmation.
    const Calibration& now = trial.session->calibration();
    EXPECT_FALSE(now.records.at(CalibrationPart::ipd).estimate);
    const Task& look = *trial.session->task();
    const DrawnLines lines = look.kind->draw(look, {}, trial.session->drawing_calibration());
    ASSERT_EQ(lines.size(), 8u);
    for (const bool is_right : {false, true}) {
      view::Eye eye = view::side_of(now.eyes, is_right);
      eye.position_head_mm.x() = (is_right ? 0.5 : -0.5) * row.ipd_mm;
      const Eigen::Vector3d corner(-0.5 * test_frame_size_mm, -0.5 * test_frame_size_mm, -row.image_mm);
      constexpr double step_of_dial_px = 1e-6;
      EXPECT_LT((lines[is_right ? 4 : 0].points_px[0] - view::drawn_px(eye, corner)).norm(), step_of_dial_px);
    }
    trial.press('R');
    EXPECT_TRUE(trial.is_requested(CalibrationPart::ipd, "pupillary distance"));
  }
}

}  // namespace vrda::calibration::drawing_test
