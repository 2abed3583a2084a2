// The display of each eye: the visible part of its window by scan lines and a ruler (thesis 8.1), the radial
// distortion of the optics from a real grid that is seen through it (thesis 8.2).
#include <algorithm>
#include <cmath>
#include <functional>

#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/virtual_bench.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::calibration {

// The visible part.

namespace {

bool is_first(Edge edge)
{
  return edge == Edge::left || edge == Edge::top;
}

double true_border_px(const Task& task, const VirtualTruth& truth)
{
  const view::ShownBox& edges = truth.edges_px[task.is_right ? 1 : 0];
  return (is_first(static_cast<Edge>(task.index)) ? edges.low_px : edges.high_px)[task.is_row ? 1 : 0];
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
    const view::ShownBox& edges = truth.edges_px[task.is_right ? 1 : 0];
    Points2d border = with_points_between(rectangle_points(edges.low_px, edges.high_px));
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
  const bool is_row = edge == Edge::top || edge == Edge::bottom, is_near = is_first(edge);
  const std::string eye = eye_text(is_right), side = name_of(edge), line = is_row ? "row" : "column";
  const double least = is_row ? window.y : window.x;
  const double most = least + (is_row ? window.height : window.width) - 1.0;
  // The window's border is hidden: the line starts a quarter of the window inside it, where it is seen.
  const double inside = std::floor(0.25 * (most - least));
  // Less than a third of an image is hidden at one side, or the display is unusable.
  const double third = (most - least) / 3.0;
  const Dial at = dial(line, "px", is_near ? least + inside : most - inside, least, most, 1.0);
  return {.kind = &scan_line,
          .name = eye + ", " + side + " edge, " + std::to_string(repeat + 1),
          .instruction = "Use only the " + eye + ". Move the line to the " + side +
                         " edge of the visible part:\nthe " + (is_near ? "first " : "last ") + line +
                         " of which at least half is visible. Approach from alternating sides.",
          .is_right = is_right,
          .is_row = is_row,
          .dials = {within(at, is_near ? least : std::ceil(most - third),
                           is_near ? std::floor(least + third) : most)},
          .index = static_cast<int>(edge)};
}

Task screen_task(const view::Viewport& window, bool is_right, bool is_height)
{
  // Start value for a typical pixel size.
  constexpr double usual_pixel_mm = 0.1, most_mm = 5000.0;
  const char* what = is_height ? "height" : "width";
  const double begin_mm = usual_pixel_mm * (is_height ? window.height : window.width);
  const Dial size = dial(what, "mm", begin_mm, 1.0, most_mm, dial_step_mm);
  return {.kind = &screen_size,
          .name = eye_text(is_right) + ", " + what,
          .instruction = "Measure with a ruler on the screen of the " + eye_text(is_right) + " the " + what +
                         "\nof the visible part, from edge to edge.",
          .is_right = is_right,
          // Pixels of 0.02 mm (head-mounted) to 1 mm (projected).
          .dials = {within(size, 0.2 * begin_mm, 10.0 * begin_mm)},
          .index = is_height ? 1 : 0};
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
      const view::ShownBox edges{
          {value_in(found, name + ".edge_left"), value_in(found, name + ".edge_top")},
          {value_in(found, name + ".edge_right"), value_in(found, name + ".edge_bottom")}};
      eye.visible = nearest_pixels(edges);
      eye.pixel_aspect = eye.distortion.pixel_aspect = value_in(found, name + ".pixel_aspect");
      eye.sight_px = 0.5 * (edges.low_px + edges.high_px);
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

/// Marks of an edge, for the eye of `task`.
std::vector<CalibrationMark> scans_of(Edge edge, const Task& task, const std::vector<Task>& tasks,
                                      const CalibrationRecord& record)
{
  std::vector<CalibrationMark> scans;
  for (const Task& t : tasks) {
    if (t.kind != &scan_line || t.is_right != task.is_right || t.index != static_cast<int>(edge)) continue;
    if (const CalibrationMark* mark = find_mark(record, t.name)) scans.push_back(*mark);
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
  const bool is_crossed =
      std::ranges::any_of(scans_of(opposite, last, tasks, record), [&](const CalibrationMark& other) {
        return is_first(edge) ? at_px >= other.rows[0][0] : at_px <= other.rows[0][0];
      });
  if (!is_crossed) return;
  std::vector<std::string> rejected;
  for (const Edge each : {opposite, edge})
    for (const CalibrationMark& scan : scans_of(each, last, tasks, record)) rejected.push_back(scan.task);
  throw PartRefusal({path, bench::name_of(CalibrationPart::viewport),
                     "crossed edges of the " + eye_text(last.is_right) + ": " + name_of(edge) + " beyond " +
                         name_of(opposite),
                     "left before right and top before bottom; scan both edges again"},
                    std::move(rejected));
}

const Part& viewport_part = viewport_object;

// The distortion.

namespace {

/// Nodes of the grid, relative to its centre: columns to the right, rows up; from the lowest row.
std::vector<Eigen::Vector2d> nodes_of(const CalibrationSettings& settings)
{
  return grid_nodes(settings.grid_columns, settings.grid_rows);
}

/// The lines of the grid between their outer nodes: columns, then rows.
std::vector<std::array<Eigen::Vector2d, 2>> grid_lines(const CalibrationSettings& settings)
{
  const double x = 0.5 * (settings.grid_columns - 1), y = 0.5 * (settings.grid_rows - 1);
  std::vector<std::array<Eigen::Vector2d, 2>> lines;
  lines.reserve(static_cast<std::size_t>(settings.grid_columns) +
                static_cast<std::size_t>(settings.grid_rows));
  for (int k = 0; k < settings.grid_columns; ++k)
    lines.push_back({Eigen::Vector2d(k - x, -y), Eigen::Vector2d(k - x, y)});
  for (int k = 0; k < settings.grid_rows; ++k)
    lines.push_back({Eigen::Vector2d(-x, k - y), Eigen::Vector2d(x, k - y)});
  return lines;
}

Eigen::Vector2d drawn_node_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector2d& node)
{
  const view::Eye& eye = view::side_of(truth.calibration.eyes, is_right);
  return view::drawn_px(eye.distortion, shown_px(truth.grids[is_right ? 1 : 0], eye.pixel_aspect, node));
}

/// Lines of the physical grid as seen by the eye.
DrawnLines physical_grid(const Task& task, const BenchFile& bench, const VirtualTruth& truth)
{
  const double aspect = view::side_of(truth.calibration.eyes, task.is_right).pixel_aspect;
  const GridPose& grid = truth.grids[task.is_right ? 1 : 0];
  DrawnLines lines;
  for (const auto& [from, to] : grid_lines(bench.calibration))
    lines.push_back(real_outline(task.is_right, {shown_px(grid, aspect, from), shown_px(grid, aspect, to)}));
  return lines;
}

/// Sketches the grid's lines, bent by `bend` at the corners. Returns the distance of its nodes.
double sketch_grid(Sketch& sketch, const CalibrationSettings& settings, DiagramInk ink, double bend)
{
  using Point = Eigen::Vector2d;
  const int columns = settings.grid_columns, rows = settings.grid_rows;
  const double spacing = std::min(0.8 / (columns - 1), 0.5 / (rows - 1));
  const Point half = 0.5 * spacing * Point(columns - 1, rows - 1);
  for (const auto& [from, to] : grid_lines(settings)) {
    constexpr int n = 12;
    Points2d points;
    for (int k = 0; k <= n; ++k) {
      const Point p = spacing * (from + (to - from) * k / n);
      const double r_sq = p.squaredNorm() / half.squaredNorm();
      points.emplace_back(Point(0.5, 0.3) + (1.0 - bend * r_sq) * p);
    }
    sketch.line(ink, std::move(points));
  }
  return spacing;
}

struct GridNode final : TaskKind {
  using TaskKind::TaskKind;

  DrawnLines draw(const Task& task, std::span<const double> values, const Calibration& found) const override
  {
    constexpr double arm_px = 8.0;
    const Eigen::Vector2d at(values[0], values[1]);
    DrawnLines lines;
    Pen pen(view::side_of(found.eyes, task.is_right), task.is_right, lines);
    for (const Eigen::Vector2d& arm : {Eigen::Vector2d(arm_px, 0.0), Eigen::Vector2d(0.0, arm_px)})
      pen.draw({at - arm, at + arm});
    return lines;
  }

  void sketch(Sketch& sketch, const Task& task, const BenchFile& bench) const override
  {
    using Point = Eigen::Vector2d;
    const double spacing = sketch_grid(sketch, bench.calibration, DiagramInk::real, 0.0);
    const Point node = Point(0.5, 0.3) + spacing * Point(task.node.x(), -task.node.y());
    for (const Point& arm : {Point(0.03, 0.0), Point(0.0, 0.03)})
      sketch.line(DiagramInk::lit, {node - arm, node + arm});
    sketch.circle(DiagramInk::lit, node, 0.02);
  }

  std::vector<double> aligned_values(const TaskContext& context) const override
  {
    const Eigen::Vector2d at =
        drawn_node_px(context.truth, context.task.is_right, context.task.node) + alignment_off_px(context);
    return {at.x(), at.y()};
  }

  /// The grid, darker, and a ring about the node.
  DrawnLines outlines(const Task& task, const BenchFile& bench, const VirtualTruth& truth) const override
  {
    constexpr double radius_px = 6.0;
    DrawnLines lines = physical_grid(task, bench, truth);
    for (DrawnLine& line : lines) line.colour = {0.45F, 0.34F, 0.14F};
    const double aspect = view::side_of(truth.calibration.eyes, task.is_right).pixel_aspect;
    const Eigen::Vector2d at = shown_px(truth.grids[task.is_right ? 1 : 0], aspect, task.node);
    lines.push_back(real_outline(task.is_right, ring(at, radius_px)));
    return lines;
  }
};

/// Of the dials, of which the turn is in degrees.
GridValues grid_values(std::span<const double> dials)
{
  GridValues values = GridValues::Map(dials.data());
  values[7] = rad_from_deg(values[7]);
  return values;
}

/// A drawn grid as the operator adjusts it; its row is GridValues, px as displayed, centre as drawn.
struct WholeGrid final : TaskKind {
  using TaskKind::TaskKind;

  DrawnLines draw(const Task& task, std::span<const double> values, const Calibration& found) const override
  {
    view::Eye dialled = view::side_of(found.eyes, task.is_right);
    const GridValues v = grid_values(values);
    dialled.distortion = distortion_of(dialled, v.head<4>(), dialled.pixel_aspect);
    DrawnLines lines;
    Pen pen(dialled, task.is_right, lines);
    const Eigen::Vector2d corner = 0.5 * (task.node - Eigen::Vector2d::Ones());
    const auto shown = [&](double column, double row) {
      return shown_px(grid_of(v.tail<4>()), dialled.pixel_aspect, Eigen::Vector2d(column, row));
    };
    for (double x = -corner.x(); x <= corner.x(); x += 1.0)
      pen.draw_shown(shown(x, -corner.y()), shown(x, corner.y()));
    for (double y = -corner.y(); y <= corner.y(); y += 1.0)
      pen.draw_shown(shown(-corner.x(), y), shown(corner.x(), y));
    return lines;
  }

  void sketch(Sketch& sketch, const Task&, const BenchFile& bench) const override
  {
    sketch_grid(sketch, bench.calibration, DiagramInk::real, 0.0);
    sketch_grid(sketch, bench.calibration, DiagramInk::lit, 0.08);
  }

  std::vector<double> mark_row(const Task&, std::span<const double> values, const Calibration&) const override
  {
    const GridValues row = grid_values(values);
    return {row.begin(), row.end()};
  }

  /// Fits the eight parameters to all nodes, each with alignment noise: better than a person achieves.
  std::vector<double> aligned_values(const TaskContext& context) const override
  {
    std::vector<GridMark> marks;
    for (const Eigen::Vector2d& at : nodes_of(context.bench.calibration))
      marks.push_back(
          {at, drawn_node_px(context.truth, context.task.is_right, at) + alignment_off_px(context)});
    const view::Eye& drawing = view::side_of(context.found.eyes, context.task.is_right);
    constexpr double held = 1e-6;
    const DistortionFit fit =
        fit_distortion(marks, drawing, {drawing.pixel_aspect, held}, "grid", "virtual bench");
    const view::Distortion& d = fit.distortion;
    GridValues values;
    values << d.k1, d.k2, d.centre_px, fit.grid.origin_px, fit.grid.spacing_px,
        fit.grid.turn_rad / rad_from_deg(1.0);
    return {values.begin(), values.end()};
  }

  /// Of the nodes drawn by the dials from where the true grid needs them.
  Deviation deviation(const TaskContext& context, std::span<const double> values) const override
  {
    const view::Eye& eye = view::side_of(context.found.eyes, context.task.is_right);
    const GridValues v = grid_values(values);
    const view::Distortion dialled = distortion_of(eye, v.head<4>(), eye.pixel_aspect);
    const std::vector<Eigen::Vector2d> nodes = nodes_of(context.bench.calibration);
    double sum_sq = 0.0;
    for (const Eigen::Vector2d& at : nodes)
      sum_sq += (view::drawn_px(dialled, shown_px(grid_of(v.tail<4>()), eye.pixel_aspect, at)) -
                 drawn_node_px(context.truth, context.task.is_right, at))
                    .squaredNorm();
    return {std::sqrt(sum_sq / static_cast<double>(nodes.size())), "px"};
  }

  DrawnLines outlines(const Task& task, const BenchFile& bench, const VirtualTruth& truth) const override
  {
    return physical_grid(task, bench, truth);
  }
};

const GridNode grid_node(
    {.name = "node", .typical_s = 10.0, .thing = "cross", .n_numbers = 2, .is_cross = true});
const WholeGrid whole_grid({.name = "grid", .thing = "grid", .n_numbers = 8});

/// Start value of the spacing: the grid fills 70 % of the visible part.
double likely_spacing_px(const view::Eye& eye, const CalibrationSettings& settings)
{
  constexpr double share = 0.7;
  return share * std::min(eye.visible.width / (settings.grid_columns - 1.0),
                          eye.visible.height / (settings.grid_rows - 1.0));
}

/// Dials of a position in the eye's window, px of the frame buffer.
std::array<Dial, 2> position_dials(const view::Eye& eye, const std::string& name, const Eigen::Vector2d& px)
{
  const view::Viewport& w = eye.window;
  return {dial(name + "x", "px", px.x(), w.x, w.x + w.width, dial_step_px),
          dial(name + "y", "px", px.y(), w.y, w.y + w.height, dial_step_px)};
}

Task node_task(const view::Eye& eye, const CalibrationSettings& settings, bool is_right,
               const Eigen::Vector2d& node)
{
  const std::string place = short_decimal(node.x(), 1) + ", " + short_decimal(node.y(), 1);
  const Eigen::Vector2d up(1.0, -1.0);
  const auto [x, y] = position_dials(
      eye, "", view::middle_px(eye.visible) + likely_spacing_px(eye, settings) * node.cwiseProduct(up));
  return {.kind = &grid_node,
          .name = eye_text(is_right) + ", node " + place,
          .instruction = "Look at the grid with the " + eye_text(is_right) + ". Move the cross to node " +
                         place + "\n(columns to the right of the centre, rows above it).",
          .is_right = is_right,
          .dials = {x, y},
          .node = node};
}

Task grid_task(const view::Eye& eye, const CalibrationSettings& settings, bool is_right, int repeat)
{
  constexpr double most_k = 1.0, step_k = 0.001, step_deg = 0.02, step_spacing_px = 0.05;
  const auto centre = position_dials(eye, "centre ", view::middle_px(eye.visible));
  const auto grid = position_dials(eye, "grid ", view::middle_px(eye.visible));
  const double spacing_px = likely_spacing_px(eye, settings);
  return {.kind = &whole_grid,
          .name = eye_text(is_right) + ", grid " + std::to_string(repeat + 1),
          .instruction =
              "Use only the " + eye_text(is_right) +
              ". Adjust the drawn grid until it covers the real one:\nfirst position and spacing at the "
              "centre, then k1 for the edges, k2 for the corners.",
          .is_right = is_right,
          .dials = {dial("k1", "", 0.0, -most_k, most_k, step_k),
                    dial("k2", "", 0.0, -most_k, most_k, step_k), centre[0], centre[1], grid[0], grid[1],
                    dial("spacing", "px", spacing_px, 1.0, eye.window.width, step_spacing_px),
                    dial("turn", "deg", 0.0, -45.0, 45.0, step_deg)},
          .node = {settings.grid_columns, settings.grid_rows},
          .index = repeat};
}

struct DistortionPart final : EyePart {
  using EyePart::EyePart;

  std::vector<Task> tasks(const BenchFile& bench, const Calibration& calibration) const override
  {
    const CalibrationSettings& settings = bench.calibration;
    std::vector<Task> tasks;
    for (const bool is_right : {false, true}) {
      const view::Eye& eye = view::side_of(calibration.eyes, is_right);
      if (settings.is_grid_adjusted) {
        for (int repeat = 0; repeat < settings.grid_repeats; ++repeat)
          tasks.push_back(grid_task(eye, settings, is_right, repeat));
        continue;
      }
      std::vector<Eigen::Vector2d> nodes = nodes_of(settings);
      std::ranges::stable_sort(nodes, std::greater(), [](const Eigen::Vector2d& node) { return node.y(); });
      for (const Eigen::Vector2d& node : nodes) tasks.push_back(node_task(eye, settings, is_right, node));
    }
    return tasks;
  }

  void apply(view::EyePair& eyes, const Estimate& found) const override
  {
    for (const bool is_right : {false, true}) {
      view::Eye& eye = view::side_of(eyes, is_right);
      const std::string name = side_name(is_right);
      eye.distortion.k1 = value_in(found, name + ".k1");
      eye.distortion.k2 = value_in(found, name + ".k2");
      eye.distortion.centre_px = {value_in(found, name + ".centre_x"), value_in(found, name + ".centre_y")};
      eye.distortion.unit_px = 0.5 * eye.window.width;
      eye.pixel_aspect = eye.distortion.pixel_aspect = value_in(found, name + ".pixel_aspect");
    }
  }

  Estimate solve_eye(const PartInput& in, bool is_right) const override
  {
    const view::EyePair eyes = eyes_before(CalibrationPart::distortion, in);
    const view::Eye& eye = view::side_of(eyes, is_right);
    const std::string name = side_name(is_right), aspect = name + ".pixel_aspect";
    const Estimate& viewport = estimate_of(CalibrationPart::viewport, in);
    const AspectPrior prior{value_in(viewport, aspect),
                            std::sqrt(prior_covariance(viewport, {aspect})(0, 0))};
    const CalibrationSettings& settings = in.bench.calibration;
    std::vector<GridMark> nodes;
    AdjustedGrids grids{{}, settings.grid_columns, settings.grid_rows};
    const std::vector<MarkedTask> tasks = tasks_of_eye(CalibrationPart::distortion, in, is_right);
    for (const MarkedTask& t : tasks) {
      const std::vector<double>& v = t.mark->rows[0];
      if (t.task.kind == &grid_node) {
        nodes.push_back({t.task.node, {v[0], v[1]}});
      } else {
        grids.values.emplace_back(GridValues::Map(v.data()));
      }
    }
    return run_fit(names_of(tasks),
                   [&] {
                     return settings.is_grid_adjusted ? mean_distortion(grids, eye, prior, name, in.path)
                                                      : fit_distortion(nodes, eye, prior, name, in.path);
                   })
        .estimate;
  }
};

const DistortionPart distortion_object({.id = CalibrationPart::distortion,
                                        .group = Part::Group::eye,
                                        .below = {CalibrationPart::viewport}});

}  // namespace

const Part& distortion_part = distortion_object;

}  // namespace vrda::calibration
