// The visible part of each eye's window: its edges by scan lines, its size with a ruler (thesis 8.1).
#include <algorithm>
#include <array>
#include <cmath>

#include "calibration/drawing.hpp"
#include "calibration/eyepoint_fit.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/truth.hpp"

namespace vrda::calibration {
namespace {

bool is_first(Edge edge)
{
  return edge == Edge::left || edge == Edge::top;
}

double true_border_px(const Task& task, const VirtualTruth& truth)
{
  const VirtualTruth::Edges& e = truth.edges_px[task.is_right ? 1 : 0];
  return std::array{e.left, e.right, e.top, e.bottom}.at(static_cast<std::size_t>(task.index));
}

struct ScanLine final : TaskKind {
  using TaskKind::TaskKind;

  /// A line one pixel wide over the eye's window.
  DrawnLines draw(const Task& task, std::span<const double> values, const Calibration& found) const override
  {
    const view::Viewport& w = view::side_of(found.eyes, task.is_right).window;
    const double middle = values[0] + 0.5;  // pixel centre
    DrawnLine line{task.is_right, {{middle, w.y}, {middle, w.y + w.height}}, 1.0, false};
    if (task.is_row) line.points_px = {{w.x, middle}, {w.x + w.width, middle}};
    return {line};
  }

  void sketch(Sketch& sketch, const Task& task, const BenchFile&) const override
  {
    using Point = Eigen::Vector2d;
    using enum DiagramInk;
    const Point low(0.1, 0.03), high(0.9, 0.57), seen_low(0.22, 0.09), seen_high(0.78, 0.51);
    sketch.box(plain, low, high);
    sketch.box(real, seen_low, seen_high);
    const auto edge = static_cast<Edge>(task.index);
    const bool is_near = is_first(edge);
    constexpr double off = 0.09;
    if (!task.is_row) {
      const double border = is_near ? seen_low.x() : seen_high.x(), at = border + (is_near ? off : -off);
      sketch.line(lit, {{at, low.y()}, {at, high.y()}});
      sketch.arrow(lit, {at, 0.3}, {border, 0.3});
    } else {
      const double border = is_near ? seen_low.y() : seen_high.y(), at = border + (is_near ? off : -off);
      sketch.line(lit, {{low.x(), at}, {high.x(), at}});
      sketch.arrow(lit, {0.5, at}, {0.5, border});
    }
  }

  /// The first (left, top) or last (right, bottom) column or row of which at least half is visible.
  std::vector<double> aligned_values(const TaskContext& context) const override
  {
    const double border_px =
        true_border_px(context.task, context.truth) + context.noise.alignment_px * context.draws.normal();
    const bool is_near = is_first(static_cast<Edge>(context.task.index));
    return {is_near ? std::ceil(border_px - 0.5) : std::floor(border_px - 0.5)};
  }

  /// A reading names the first visible column or row, or the last one, whose far side is the border.
  Deviation deviation(const TaskContext& context, std::span<const double> values) const override
  {
    const double side_px = values[0] + (is_first(static_cast<Edge>(context.task.index)) ? 0.0 : 1.0);
    return {std::abs(side_px - true_border_px(context.task, context.truth)), "px"};
  }

  DrawnLines outlines(const Task& task, const BenchFile&, const VirtualTruth& truth) const override
  {
    const VirtualTruth::Edges& e = truth.edges_px[task.is_right ? 1 : 0];
    Points2d border = with_points_between(rectangle_points({e.left, e.top}, {e.right, e.bottom}));
    const view::Distortion& optics = view::side_of(truth.calibration.eyes, task.is_right).distortion;
    for (Eigen::Vector2d& point : border) point = view::shown_px(optics, point);
    return {real_outline(task.is_right, std::move(border))};
  }
};

/// Width (index 0) or height (1) of the visible part.
struct ScreenSize final : TaskKind {
  using TaskKind::TaskKind;

  void sketch(Sketch& sketch, const Task& task, const BenchFile&) const override
  {
    using Point = Eigen::Vector2d;
    const bool is_height = task.index == 1;
    sketch.box(DiagramInk::real, {0.2, 0.1}, {0.8, 0.5});
    sketch.arrow(DiagramInk::lit, {0.5, 0.3}, is_height ? Point(0.5, 0.1) : Point(0.2, 0.3));
    sketch.arrow(DiagramInk::lit, {0.5, 0.3}, is_height ? Point(0.5, 0.5) : Point(0.8, 0.3));
  }

  std::vector<double> aligned_values(const TaskContext& context) const override
  {
    return {context.truth.screen_mm[context.task.is_right ? 1 : 0][context.task.index] +
            context.noise.ruler_mm * context.draws.normal()};
  }
};

const ScanLine scan_line({.name = "scan line", .typical_s = 10.0, .thing = "line", .is_reading = true});
const ScreenSize screen_size(
    {.name = "screen size", .typical_s = 20.0, .is_reading = true, .is_seen = false});

Task scan_task(const view::Viewport& window, bool is_right, Edge edge, int repeat)
{
  Task task;
  task.kind = &scan_line;
  task.is_right = is_right;
  const bool is_column = edge == Edge::left || edge == Edge::right;
  task.is_row = !is_column;
  task.index = static_cast<int>(edge);
  const std::string side = name_of(edge);
  task.name = eye_text(is_right) + ", " + side + " edge, " + std::to_string(repeat + 1);
  const bool is_near = is_first(edge);
  const double least = is_column ? window.x : window.y;
  const double most = least + (is_column ? window.width : window.height) - 1.0;
  task.instruction = "Use only the " + eye_text(is_right) + ". Move the line to the " + side +
                     " edge of the visible part:\nthe " + (is_near ? "first" : "last") +
                     (is_column ? " column" : " row") +
                     " of which at least half is visible. Approach from alternating sides.";
  // The window's border is hidden: the line starts a quarter of the window inside it, where it is seen.
  const double inside = std::floor(0.25 * (most - least));
  // Less than a third of an image is hidden at one side, or the display is unusable.
  const double third = (most - least) / 3.0;
  task.dials = {within(
      dial(is_column ? "column" : "row", "px", is_near ? least + inside : most - inside, least, most, 1.0),
      is_near ? least : std::ceil(most - third), is_near ? std::floor(least + third) : most)};
  return task;
}

Task screen_task(const view::Viewport& window, bool is_right, bool is_height)
{
  // Start value for a typical pixel size.
  constexpr double usual_pixel_mm = 0.1, most_mm = 5000.0;
  Task task;
  task.kind = &screen_size;
  task.is_right = is_right;
  task.index = is_height ? 1 : 0;
  const char* what = is_height ? "height" : "width";
  task.name = eye_text(is_right) + ", " + what;
  task.instruction = "Measure with a ruler on the screen of the " + eye_text(is_right) + " the " + what +
                     "\nof the visible part, from edge to edge.";
  const double begin_mm = usual_pixel_mm * (is_height ? window.height : window.width);
  // Pixels of 0.02 mm (head-mounted) to 1 mm (projected).
  task.dials = {
      within(dial(what, "mm", begin_mm, 1.0, most_mm, dial_step_mm), 0.2 * begin_mm, 10.0 * begin_mm)};
  return task;
}

struct ViewportPart final : EyePart {
  using EyePart::EyePart;

  std::vector<Task> tasks(const BenchFile& bench, const Calibration&) const override
  {
    std::vector<Task> tasks;
    for (const bool is_right : {false, true}) {
      const view::Viewport& window = view::side_of(bench.display.windows, is_right);
      for (int repeat = 0; repeat < bench.calibration.edge_repeats; ++repeat) {
        for (std::size_t edge = 0; edge < n_edges; ++edge)
          tasks.push_back(scan_task(window, is_right, static_cast<Edge>(edge), repeat));
      }
      for (const bool is_height : {false, true}) tasks.push_back(screen_task(window, is_right, is_height));
    }
    return tasks;
  }

  void apply(view::EyePair& eyes, const Estimate& found) const override
  {
    for (const bool is_right : {false, true}) {
      view::Eye& eye = view::side_of(eyes, is_right);
      const std::string name = side_name(is_right);
      const Eigen::Vector2d low(value_in(found, name + ".edge_left"), value_in(found, name + ".edge_top")),
          high(value_in(found, name + ".edge_right"), value_in(found, name + ".edge_bottom"));
      const auto whole = [](double x) { return static_cast<int>(std::lround(x)); };
      eye.visible = {whole(low.x()), whole(low.y()), whole(high.x()) - whole(low.x()),
                     whole(high.y()) - whole(low.y())};
      eye.pixel_aspect = eye.distortion.pixel_aspect = value_in(found, name + ".pixel_aspect");
      eye.sight_px = 0.5 * (low + high);
      if (eye.distortion.k1 == 0.0 && eye.distortion.k2 == 0.0) eye.distortion.centre_px = eye.sight_px;
    }
  }

  /// Resets an old distortion that folds within the new visible part.
  void solve(const PartInput& in, Calibration& c) const override
  {
    EyePart::solve(in, c);
    for (view::Eye* eye : {&c.eyes.left, &c.eyes.right}) {
      if (view::usability_error(*eye, "", "")) eye->distortion.k1 = eye->distortion.k2 = 0.0;
    }
  }

  Estimate solve_eye(const PartInput& in, bool is_right) const override
  {
    ViewportMarks marks;
    marks.screen_sd_mm = in.bench.calibration.screen_sd_mm;
    // In the order of the fit: edge by edge, then the sizes.
    std::vector<std::string> names;
    const std::vector<MarkedTask> tasks = tasks_of_eye(id(), in, is_right);
    for (int edge = 0; edge < static_cast<int>(n_edges); ++edge) {
      for (const MarkedTask& t : tasks) {
        if (t.task.kind != &scan_line || t.task.index != edge) continue;
        names.push_back(t.task.name);
        marks.line_px[static_cast<std::size_t>(edge)].push_back(t.mark->rows[0][0]);
      }
    }
    for (const MarkedTask& t : tasks) {
      if (t.task.kind != &screen_size) continue;
      names.push_back(t.task.name);
      marks.screen_mm[t.task.index] = t.mark->rows[0][0];
    }
    const view::Viewport& window = view::side_of(in.bench.display.windows, is_right);
    return run_fit(names, [&] { return fit_viewport(marks, window, side_name(is_right), in.path); });
  }
};

struct ScannedLine {
  std::string task;
  double at_px = 0.0;
};

/// Marked scans of an edge, for the eye of `task`.
std::vector<ScannedLine> scans_of(Edge edge, const Task& task, const std::vector<Task>& tasks,
                                  const CalibrationRecord& record)
{
  std::vector<ScannedLine> scans;
  for (const Task& t : tasks) {
    if (t.kind != &scan_line || t.is_right != task.is_right || t.index != static_cast<int>(edge)) continue;
    if (const CalibrationMark* mark = find_mark(record, t.name)) scans.push_back({t.name, mark->rows[0][0]});
  }
  return scans;
}

const ViewportPart viewport_object({.id = CalibrationPart::viewport, .group = Part::Group::eye});

}  // namespace

void require_edge_order(const std::vector<Task>& tasks, const CalibrationRecord& record, std::size_t done,
                        const std::string& path)
{
  const Task& last = tasks[done];
  if (last.kind != &scan_line) return;
  const auto edge = static_cast<Edge>(last.index);
  const auto opposite = static_cast<Edge>(last.index ^ 1);  // left and right, top and bottom
  const double at_px = find_mark(record, last.name)->rows[0][0];
  const std::vector<ScannedLine> scans = scans_of(opposite, last, tasks, record);
  const bool is_crossed = std::ranges::any_of(scans, [&](const ScannedLine& other) {
    return is_first(edge) ? at_px >= other.at_px : at_px <= other.at_px;
  });
  if (!is_crossed) return;
  std::vector<std::string> rejected;
  for (const ScannedLine& scan : scans) rejected.push_back(scan.task);
  for (const ScannedLine& scan : scans_of(edge, last, tasks, record)) rejected.push_back(scan.task);
  throw PartRefusal({path, bench::name_of(CalibrationPart::viewport),
                     "crossed edges of the " + eye_text(last.is_right) + ": " + name_of(edge) + " beyond " +
                         name_of(opposite),
                     "left before right and top before bottom; scan both edges again"},
                    std::move(rejected));
}

const Part& viewport_part = viewport_object;

}  // namespace vrda::calibration
