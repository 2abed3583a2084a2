// Radial distortion of the optics, from a real grid that is seen through the display (thesis 8.2).
#include <cmath>

#include "calibration/bench_poses.hpp"
#include "calibration/distortion_fit.hpp"
#include "calibration/drawing.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "core/units.hpp"
#include "show/session.hpp"

namespace vrda::calibration {
namespace {

/// Nodes of the grid, relative to its centre: columns to the right, rows up.
std::vector<Eigen::Vector2d> nodes_of(const CalibrationSettings& settings)
{
  std::vector<Eigen::Vector2d> nodes;
  for (int row = 0; row < settings.grid_rows; ++row) {
    for (int column = 0; column < settings.grid_columns; ++column)
      nodes.emplace_back(column - 0.5 * (settings.grid_columns - 1), row - 0.5 * (settings.grid_rows - 1));
  }
  return nodes;
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
  const int columns = bench.calibration.grid_columns, rows = bench.calibration.grid_rows;
  const double x = 0.5 * (columns - 1), y = 0.5 * (rows - 1);
  const auto at = [&](double column, double row) { return shown_px(grid, aspect, {column, row}); };
  DrawnLines lines;
  for (int k = 0; k < columns; ++k)
    lines.push_back(real_outline(task.is_right, {at(k - x, -y), at(k - x, y)}));
  for (int k = 0; k < rows; ++k) lines.push_back(real_outline(task.is_right, {at(-x, k - y), at(x, k - y)}));
  return lines;
}

/// Sketches the grid's lines, bent by `bend` at the corners. Returns the distance of its nodes.
double sketch_grid(Sketch& sketch, const CalibrationSettings& settings, DiagramInk ink, double bend)
{
  using Point = Eigen::Vector2d;
  const int columns = settings.grid_columns, rows = settings.grid_rows;
  const double spacing = std::min(0.8 / (columns - 1), 0.5 / (rows - 1));
  const Point half = 0.5 * spacing * Point(columns - 1, rows - 1);
  const auto add = [&](const Point& from, const Point& to) {
    constexpr int n = 12;
    Points2d points;
    for (int k = 0; k <= n; ++k) {
      const Point p = from + (to - from) * k / n;
      const double r_sq = p.squaredNorm() / half.squaredNorm();
      points.emplace_back(Point(0.5, 0.3) + (1.0 - bend * r_sq) * p);
    }
    sketch.line(ink, std::move(points));
  };
  for (int k = 0; k < columns; ++k)
    add({-half.x() + k * spacing, -half.y()}, {-half.x() + k * spacing, half.y()});
  for (int k = 0; k < rows; ++k)
    add({-half.x(), -half.y() + k * spacing}, {half.x(), -half.y() + k * spacing});
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

/// A drawn grid as the operator adjusts it; its row is {k1, k2, centre_x, centre_y, at_x, at_y, spacing,
/// turn_rad}, px as displayed, centre as drawn. The dial of the turn is in degrees.
GridValues grid_values(std::span<const double> v, double turn_rad)
{
  return {v[0], v[1], {v[2], v[3]}, {{v[4], v[5]}, v[6], turn_rad}};
}

/// The eye with the distortion of a grid.
view::Eye with_distortion(view::Eye eye, const GridValues& grid)
{
  eye.distortion.k1 = grid.k1;
  eye.distortion.k2 = grid.k2;
  eye.distortion.centre_px = grid.centre_px;
  return eye;
}

struct WholeGrid final : TaskKind {
  using TaskKind::TaskKind;

  DrawnLines draw(const Task& task, std::span<const double> values, const Calibration& found) const override
  {
    const view::Eye& eye = view::side_of(found.eyes, task.is_right);
    const GridValues v = grid_values(values, rad_from_deg(values[7]));
    const view::Eye dialled = with_distortion(eye, v);
    DrawnLines lines;
    Pen pen(dialled, task.is_right, lines);
    const Eigen::Vector2d corner = 0.5 * (task.node - Eigen::Vector2d::Ones());
    const auto shown = [&](double column, double row) {
      return shown_px(v.grid, eye.pixel_aspect, Eigen::Vector2d(column, row));
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
    std::vector<double> row(values.begin(), values.end());
    row.back() = rad_from_deg(row.back());
    return row;
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
    return {d.k1,
            d.k2,
            d.centre_px.x(),
            d.centre_px.y(),
            fit.grid.origin_px.x(),
            fit.grid.origin_px.y(),
            fit.grid.spacing_px,
            fit.grid.turn_rad / rad_from_deg(1.0)};
  }

  /// Of the nodes drawn by the dials from where the true grid needs them.
  Deviation deviation(const TaskContext& context, std::span<const double> values) const override
  {
    const view::Eye& eye = view::side_of(context.found.eyes, context.task.is_right);
    const GridValues v = grid_values(values, rad_from_deg(values[7]));
    const view::Distortion dialled = with_distortion(eye, v).distortion;
    const std::vector<Eigen::Vector2d> nodes = nodes_of(context.bench.calibration);
    double sum_sq = 0.0;
    for (const Eigen::Vector2d& at : nodes)
      sum_sq += (view::drawn_px(dialled, shown_px(v.grid, eye.pixel_aspect, at)) -
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

Task node_task(const view::Eye& eye, const CalibrationSettings& settings, bool is_right, int column, int row)
{
  Task task;
  task.kind = &grid_node;
  task.is_right = is_right;
  task.node = {column - 0.5 * (settings.grid_columns - 1), row - 0.5 * (settings.grid_rows - 1)};
  const std::string place =
      show::rounded_text(task.node.x(), 1) + ", " + show::rounded_text(task.node.y(), 1);
  task.name = eye_text(is_right) + ", node " + place;
  task.instruction = "Look at the grid with the " + eye_text(is_right) + ". Move the cross to node " + place +
                     "\n(columns to the right of the centre, rows above it).";
  const Eigen::Vector2d up(1.0, -1.0);
  const Eigen::Vector2d begin =
      view::middle_px(eye.visible) + likely_spacing_px(eye, settings) * task.node.cwiseProduct(up);
  const view::Viewport& w = eye.window;
  task.dials = {dial("x", "px", begin.x(), w.x, w.x + w.width, dial_step_px),
                dial("y", "px", begin.y(), w.y, w.y + w.height, dial_step_px)};
  return task;
}

Task grid_task(const view::Eye& eye, const CalibrationSettings& settings, bool is_right, int repeat)
{
  Task task;
  task.kind = &whole_grid;
  task.is_right = is_right;
  task.index = repeat;
  task.node = {settings.grid_columns, settings.grid_rows};
  task.name = eye_text(is_right) + ", grid " + std::to_string(repeat + 1);
  task.instruction =
      "Use only the " + eye_text(is_right) +
      ". Adjust the drawn grid until it covers the real one:\nfirst position and spacing at the centre, "
      "then k1 for the edges, k2 for the corners.";
  const Eigen::Vector2d middle = view::middle_px(eye.visible);
  constexpr double most_k = 1.0, step_k = 0.001, step_deg = 0.02, step_spacing_px = 0.05;
  const view::Viewport& w = eye.window;
  const auto across = [&](const char* name, double value) {
    return dial(name, "px", value, w.x, w.x + w.width, dial_step_px);
  };
  const auto down = [&](const char* name, double value) {
    return dial(name, "px", value, w.y, w.y + w.height, dial_step_px);
  };
  task.dials = {dial("k1", "", 0.0, -most_k, most_k, step_k),
                dial("k2", "", 0.0, -most_k, most_k, step_k),
                across("centre x", middle.x()),
                down("centre y", middle.y()),
                across("grid x", middle.x()),
                down("grid y", middle.y()),
                dial("spacing", "px", likely_spacing_px(eye, settings), 1.0, w.width, step_spacing_px),
                dial("turn", "deg", 0.0, -45.0, 45.0, step_deg)};
  return task;
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
      for (int row = settings.grid_rows - 1; row >= 0; --row) {
        for (int column = 0; column < settings.grid_columns; ++column)
          tasks.push_back(node_task(eye, settings, is_right, column, row));
      }
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
        grids.values.push_back(grid_values(v, v[7]));
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
