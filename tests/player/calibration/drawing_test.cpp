#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>

#include "calibration/virtual_bench.hpp"
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

/// A box with outward faces.
Body box_body(const Eigen::Vector3d& half_mm)
{
  Body body;
  Mesh& mesh = body.contact.mesh;
  mesh.vertices_mm.resize(8, 3);
  for (int k = 0; k < 8; ++k)
    mesh.vertices_mm.row(k) = half_mm.cwiseProduct(
        Eigen::Vector3d((k & 1) != 0 ? 1 : -1, (k & 2) != 0 ? 1 : -1, (k & 4) != 0 ? 1 : -1));
  mesh.triangles.resize(12, 3);
  mesh.triangles << 0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6,
      1, 3, 5, 3, 7, 5;
  return body;
}

TEST(Outline, OfABoxIsItsRectangleInBothViews)
{
  const BodyOutline outline = outline_of(box_body({20.0, 50.0, 30.0}));
  for (std::size_t view = 0; view < 2; ++view) {
    double length_mm = 0.0;
    for (const auto& [a, b] : outline.pieces[view]) length_mm += (a - b).norm();
    const double width_mm = view == 0 ? 60.0 : 40.0;
    EXPECT_NEAR(length_mm, 2.0 * (width_mm + 100.0), 1e-9) << view;
  }
}

TEST(Diagram, EveryTaskHasOneWithSomethingLitWithinTheFrame)
{
  for (const char* lines : {"", "distortion = \"adjust\"\nmodel = \"adjust\"\n"}) {
    std::string text = virtual_bench_text();
    const std::string table = "[calibration]\n";
    text.insert(text.find(table) + table.size(), lines);
    const BenchFile bench = bench::parse_bench_file(text, "bench.toml");
    const Calibration nominal = bench::nominal_calibration(bench);
    std::map<std::pair<CalibrationPart, std::string>, std::size_t> kinds;
    for (const CalibrationPart part : parts_of(bench)) {
      for (const Task& task : calibration::tasks_of(part, bench, nominal)) {
        SCOPED_TRACE(task.name);
        const Diagram diagram = diagram_of(task, bench, nullptr);
        const bool is_lit = std::ranges::any_of(
            diagram.lines, [](const DiagramLine& line) { return line.ink == DiagramInk::lit; });
        EXPECT_TRUE(is_lit || task.kind->traits().places_model);
        for (const DiagramLine& line : diagram.lines) {
          ASSERT_GE(line.points.size(), 2u);
          for (const Eigen::Vector2d& p : line.points) {
            EXPECT_TRUE(p.x() >= 0.0 && p.x() <= 1.0 && p.y() >= 0.0 && p.y() <= diagram.height)
                << p.transpose();
          }
        }
      }
    }
  }
}

/// Middle of the largest lit ring on the left half: the view from the front.
Eigen::Vector2d lit_point(const Diagram& diagram)
{
  Eigen::Vector2d middle(-1.0, -1.0);
  for (const DiagramLine& line : diagram.lines) {
    if (line.ink != DiagramInk::lit || line.points.front().x() > 0.5) continue;
    middle.setZero();
    for (std::size_t k = 1; k < line.points.size(); ++k)
      middle += line.points[k] / static_cast<double>(line.points.size() - 1);
  }
  return middle;
}

TEST(Diagram, TheNextPointIsLitWhereItIsOnTheModel)
{
  const BenchFile bench = bench::parse_bench_file(virtual_bench_text(), "bench.toml");
  const auto part = CalibrationPart::leg;
  const std::vector<Task> tasks = calibration::tasks_of(part, bench, bench::nominal_calibration(bench));
  const auto& points = points_of(BodyRole::leg, bench.calibration);
  const BodyOutline outline = outline_of(box_body({30.0, 30.0, 30.0}));
  std::vector<Eigen::Vector2d> lit;
  for (const Task& task : tasks) lit.push_back(lit_point(diagram_of(task, bench, &outline)));
  ASSERT_EQ(lit.size(), points.size());
  // From the front: the subject's right is on the left, up is up; one scale for all points.
  const auto flat = [&](std::size_t k) {
    return Eigen::Vector2d(-points[k].p_model_mm.z(), -points[k].p_model_mm.y());
  };
  const double scale = (lit[1] - lit[0]).norm() / (flat(1) - flat(0)).norm();
  EXPECT_GT(scale, 0.0);
  for (std::size_t k = 1; k < lit.size(); ++k)
    EXPECT_LT(((lit[k] - lit[0]) - scale * (flat(k) - flat(0))).norm(), 1e-9) << k;
  const auto n_plain = [&](const BodyOutline* of) {
    return std::ranges::count(diagram_of(tasks[0], bench, of).lines, DiagramInk::plain, &DiagramLine::ink);
  };
  EXPECT_GT(n_plain(&outline), n_plain(nullptr)) << "the model's outline";
}

const test::PlainKind plain({.name = "plain"}), cross({.name = "cross", .is_cross = true});

Task task_of(std::size_t n_dials, const TaskKind& kind = plain)
{
  Task task;
  task.kind = &kind;
  for (std::size_t k = 0; k < n_dials; ++k) task.dials.push_back({"d", "px", 10.0, 0.0, 1000.0, 0.25});
  return task;
}

std::vector<double> after(const Task& task, std::initializer_list<view::KeyPress> presses)
{
  Dials dials(task);
  for (const view::KeyPress& press : presses) dials.press(press);
  return {dials.values().begin(), dials.values().end()};
}

TEST(CalibrationDials, KeysChangeTheFirstAndTheSecond)
{
  const Task one = task_of(1), two = task_of(2), at = task_of(2, cross);
  using Values = std::vector<double>;
  EXPECT_EQ(after(two, {{view::Key::right}}), (Values{10.25, 10.0}));
  EXPECT_EQ(after(two, {{view::Key::left}, {view::Key::left}}), (Values{9.5, 10.0}));
  EXPECT_EQ(after(two, {{view::Key::up}}), (Values{10.0, 10.25}));
  EXPECT_EQ(after(two, {{view::Key::down, true}}), (Values{10.0, 7.5}));
  // A cross moves up when y decreases.
  EXPECT_EQ(after(at, {{view::Key::up}}), (Values{10.0, 9.75}));
  EXPECT_EQ(after(at, {{view::Key::down}}), (Values{10.0, 10.25}));
  EXPECT_EQ(after(one, {{view::Key::right, false, true}, {view::Key::up}, {view::Key::down}}), Values{35.0});
  EXPECT_EQ(after(one, {{view::Key::left, false, true}}), Values{0.0});
  EXPECT_EQ(after(task_of(0), {{view::Key::left}, {view::Key::up}}), Values{});
}

TEST(CalibrationDials, OfManyUpAndDownSelect)
{
  Dials dials(task_of(8));
  EXPECT_EQ(dials.selected(), 0u);
  dials.press({view::Key::down});
  dials.press({view::Key::right, true});
  EXPECT_EQ(dials.selected(), 1u);
  EXPECT_EQ(dials.values()[1], 12.5);
  dials.press({view::Key::up});
  dials.press({view::Key::up});
  EXPECT_EQ(dials.selected(), 7u);
  dials.press({view::Key::down});
  EXPECT_EQ(dials.selected(), 0u);
}

TEST(CalibrationDials, ManyStepsAccumulateNoRoundingError)
{
  Dials dials(task_of(1));
  for (int k = 0; k < 1000; ++k) dials.press({view::Key::right});
  for (int k = 0; k < 1000; ++k) dials.press({view::Key::left});
  EXPECT_EQ(dials.values()[0], 10.0);
}

TEST(CalibrationDials, ATurnOfThePotentiometerIsTwoHundredSteps)
{
  Dials dials(task_of(1));
  double time_s = 0.0;
  const auto hold = [&](int count) {
    for (int k = 0; k < 500; ++k) dials.turn(count, time_s += 0.01);
  };
  // The initial position has no effect.
  hold(200);
  EXPECT_EQ(dials.values()[0], 10.0);
  hold(200 + 1023 / 2);
  EXPECT_EQ(dials.values()[0], 10.0 + 100 * 0.25);
  // The potentiometer continues from the value set by a key.
  dials.press({view::Key::right});
  hold(200 + 1023 / 2);
  EXPECT_EQ(dials.values()[0], 35.25);
  hold(200);
  EXPECT_EQ(dials.values()[0], 10.25);
}

TEST(CalibrationDials, FollowThePointer)
{
  using Values = std::vector<double>;
  const auto dragged = [](const Task& task, const DialDrag& drag) {
    Dials dials(task);
    dials.drag(drag);  // without a press
    dials.begin_drag();
    dials.drag({{500.0, 500.0}, drag.is_second});
    dials.drag(drag);  // counts from the press
    return Values(dials.values().begin(), dials.values().end());
  };
  EXPECT_EQ(dragged(task_of(2, cross), {{3.1, -4.0}}), (Values{13.0, 6.0})) << "steps of a quarter";
  EXPECT_EQ(dragged(task_of(2, cross), {{10.0, 20.0}, false, true}), (Values{11.0, 12.0})) << "a tenth";
  Task line = task_of(1);
  EXPECT_EQ(dragged(line, {{7.0, 3.0}}), Values{17.0});
  line.is_row = true;
  EXPECT_EQ(dragged(line, {{7.0, 3.0}}), Values{13.0}) << "a row moves vertically";
  EXPECT_EQ(dragged(task_of(2), {{7.0, 3.0}}), (Values{17.0, 10.0}));
  EXPECT_EQ(dragged(task_of(2), {{7.0, 3.0}, true}), (Values{10.0, 17.0}));
  EXPECT_EQ(dragged(task_of(2, cross), {{0.0, 0.0}}), (Values{10.0, 10.0})) << "back at the press";
  Task size = task_of(1);
  size.dials[0].unit = "mm";
  EXPECT_EQ(dragged(size, {{8.0, 0.0}}), Values{12.0}) << "a step a pixel";
}

}  // namespace vrda::calibration::drawing_test
