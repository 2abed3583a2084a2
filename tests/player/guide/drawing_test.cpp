#include "guide/drawing.hpp"

#include <gtest/gtest.h>

#include "guide/optics_tasks.hpp"
#include "guide/parts.hpp"
#include "guide/tasks.hpp"
#include "trial.hpp"

namespace vrda {
namespace {

/// Of what clipping leaves.
constexpr double rounding_px = 1e-9;

std::vector<double> begin_of(const Task& task)
{
  std::vector<double> values;
  for (const Dial& dial : task.dials) values.push_back(dial.value);
  return values;
}

struct Drawn {
  Task task;
  std::vector<GuideLine> lines;
};

/// Every task of a bench with what it draws, before eyes as they truly are.
std::vector<Drawn> all_drawn(const BenchFile& bench, const Calibration& calibration)
{
  std::vector<Drawn> drawn;
  for (const CalibrationPart part : parts_of(bench)) {
    for (const Task& task : tasks_of(part, bench, calibration))
      drawn.push_back({task, drawing_of(task, begin_of(task), calibration)});
  }
  return drawn;
}

BenchFile adjusted_bench()
{
  const std::string head = "[calibration]\n";
  return test::virtual_bench(HeadKind::stage, head, head + "distortion = \"adjust\"\n");
}

void expect_within(const GuideLine& line, const Viewport& v)
{
  for (const Eigen::Vector2d& p : line.points_px) {
    EXPECT_GE(p.x(), v.x - rounding_px);
    EXPECT_LE(p.x(), v.x + v.width + rounding_px);
    EXPECT_GE(p.y(), v.y - rounding_px);
    EXPECT_LE(p.y(), v.y + v.height + rounding_px);
  }
}

TEST(GuideDrawing, StaysWithinWhatIsVisible)
{
  int n_lines = 0;
  for (const BenchFile& bench : {test::virtual_bench(HeadKind::stage), adjusted_bench()}) {
    const Calibration truth = virtual_truth(bench, 3).calibration;
    for (const Drawn& drawn : all_drawn(bench, truth)) {
      SCOPED_TRACE(drawn.task.name);
      for (const GuideLine& line : drawn.lines) {
        const Eye& eye = eye_of(truth, line.is_right);
        const bool is_scan = drawn.task.kind == TaskKind::scan_line;
        expect_within(line, is_scan ? eye.window : eye.visible);
        EXPECT_GE(line.points_px.size(), 2u);
        n_lines += is_scan ? 0 : 1;
        // The arms of a plain cross are straight; everything else may be curved.
        const double longest_px = drawn.task.kind == TaskKind::point ? 16.0 : 8.0;
        for (std::size_t k = 1; !is_scan && k < line.points_px.size(); ++k)
          EXPECT_LE((line.points_px[k] - line.points_px[k - 1]).norm(), longest_px + rounding_px);
      }
    }
  }
  EXPECT_GT(n_lines, 1000);
}

TEST(GuideDrawing, AnAlignedCrossThatLiesOutsideDrawsNothing)
{
  const BenchFile bench = test::virtual_bench(HeadKind::stage);
  const Calibration truth = virtual_truth(bench, 3).calibration;
  const Task task = tasks_of(CalibrationPart::distortion, bench, truth).front();
  const Viewport& v = truth.eyes.left.visible;
  EXPECT_TRUE(drawing_of(task, std::vector<double>{v.x - 20.0, v.y - 20.0}, truth).empty());
  // Half of it within.
  EXPECT_EQ(drawing_of(task, std::vector<double>{v.x + 0.0, v.y + 50.0}, truth).size(), 2u);
}

TEST(GuideDrawing, AScanLineIsOneCrispColumnOrRow)
{
  const BenchFile bench = test::virtual_bench(HeadKind::stage);
  const Calibration nominal = nominal_calibration(bench);
  const std::vector<Task> tasks = tasks_of(CalibrationPart::viewport, bench, nominal);
  const std::vector<GuideLine> column = drawing_of(tasks[0], std::vector<double>{700}, nominal);
  ASSERT_EQ(column.size(), 1u);
  const Viewport& window = bench.display.windows.left;
  EXPECT_FALSE(column[0].is_smooth);
  EXPECT_EQ(column[0].width_px, 1.0);
  EXPECT_EQ(column[0].points_px[0], Eigen::Vector2d(700.5, window.y));
  EXPECT_EQ(column[0].points_px[1], Eigen::Vector2d(700.5, window.y + window.height));
  const std::vector<GuideLine> row = drawing_of(tasks[2], std::vector<double>{100}, nominal);
  EXPECT_EQ(row[0].points_px[0], Eigen::Vector2d(window.x, 100.5));
  EXPECT_EQ(row[0].points_px[1], Eigen::Vector2d(window.x + window.width, 100.5));
}

/// What is drawn through the pre-distortion is straight through the optics.
TEST(GuideDrawing, SidesAreUprightAsShown)
{
  const BenchFile bench = test::virtual_bench(HeadKind::stage);
  const Calibration truth = virtual_truth(bench, 3).calibration;
  const Eye& eye = truth.eyes.left;
  const Task task = tasks_of(CalibrationPart::eyepoints, bench, truth).front();
  const std::vector<double> sides{eye.sight_px.x() - 90.0, eye.sight_px.x() + 75.0};
  const std::vector<GuideLine> lines = drawing_of(task, sides, truth);
  ASSERT_EQ(lines.size(), 2u);
  // Between points eight px apart a line as curved as the optics' is off by as much as an eighth of the
  // square of that by its radius; only where it was clipped at the border the chord counts.
  constexpr double chord_px = 0.02;
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_FALSE(lines[k].is_right);
    for (const Eigen::Vector2d& p : lines[k].points_px)
      EXPECT_NEAR(shown_px(eye.distortion, p).x(), sides[k], chord_px);
    const double height = lines[k].points_px.back().y() - lines[k].points_px.front().y();
    EXPECT_NEAR(height, eye.visible.height, 1.0);
  }
}

TEST(GuideDrawing, TheTestObjectStandsAtTheImagesDistanceForBothEyes)
{
  const BenchFile bench = test::virtual_bench(HeadKind::stage);
  const Calibration truth = virtual_truth(bench, 3).calibration;
  const Task task = tasks_of(CalibrationPart::ipd, bench, truth).back();
  ASSERT_EQ(task.kind, TaskKind::look);
  const std::vector<GuideLine> lines = drawing_of(task, {}, truth);
  ASSERT_EQ(lines.size(), 8u);
  for (const bool is_right : {false, true}) {
    const Eye& eye = eye_of(truth, is_right);
    const Eigen::Vector3d corner(-0.5 * look_size_mm, -0.5 * look_size_mm, -truth.image_distance_mm);
    EXPECT_EQ(lines[is_right ? 4 : 0].is_right, is_right);
    EXPECT_LT((lines[is_right ? 4 : 0].points_px[0] - drawn_px(eye, corner)).norm(), rounding_px);
  }
}

}  // namespace
}  // namespace vrda
