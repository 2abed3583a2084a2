// Field of view and depth of each eye, from rectangles of known sizes at known depths (thesis 8.3).
#include <algorithm>
#include <cmath>

#include "bench/rigid_body.hpp"
#include "calibration/drawing.hpp"
#include "calibration/eyepoint_fit.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/truth.hpp"
#include "show/session.hpp"

namespace vrda::calibration {
namespace {

/// Vertical sides of a rectangle, parallel to the table's Y: x and z on the table.
struct RectangleSides {
  double left_table_mm = 0.0, right_table_mm = 0.0, z_table_mm = 0.0;
};

/// Sides of rectangle `index`, in front of the head with its stage at the stop.
RectangleSides rectangle_sides(const BenchFile& bench, const VirtualTruth& truth, std::size_t index)
{
  check(index < bench.calibration.rectangles.size(), "rectangle index out of range");
  const CalibrationRectangle& rectangle = bench.calibration.rectangles[index];
  // Placed by hand, some millimetres off centre.
  constexpr std::uint64_t first = 1000;
  constexpr double off_sd_mm = 5.0;
  const double x_mm =
      truth.calibration.X_table_eyes.shift_mm.x() +
      off_sd_mm * RandomSequence(truth.seed, bench::RandomPurpose::virtual_bench, first + index).normal();
  return {x_mm - 0.5 * rectangle.width_mm, x_mm + 0.5 * rectangle.width_mm,
          truth.reference_plane_table_mm - rectangle.depth_mm};
}

/// Where a point of the table is seen with the stage at its stop; undistorted px.
Eigen::Vector2d seen_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector3d& p_table_mm)
{
  const Eigen::Vector3d p_eyes_mm = bench::pose_of(truth.calibration.X_table_eyes).inverse() * p_table_mm;
  return view::shown_px(view::side_of(truth.calibration.eyes, is_right), p_eyes_mm);
}

/// The point of a side seen at the height `row_px`.
Eigen::Vector2d side_at_row(const VirtualTruth& truth, bool is_right, const Eigen::Vector2d& side_table_mm,
                            double row_px)
{
  // The row is a ratio of two linear functions of the height. One secant step is exact if the line is
  // parallel to the screen; two more correct the remaining error.
  const auto seen = [&](double y_mm) -> Eigen::Vector2d {
    return seen_px(truth, is_right, {side_table_mm.x(), y_mm, side_table_mm.y()});
  };
  double before_mm = truth.calibration.X_table_eyes.shift_mm.y(), y_mm = before_mm + 10.0;
  double before_px = seen(before_mm).y();
  constexpr int most_steps = 8;
  for (int step = 0; step < most_steps; ++step) {
    const double at_px = seen(y_mm).y();
    if (at_px == before_px || at_px == row_px) break;
    const double next_mm = y_mm + (row_px - at_px) * (y_mm - before_mm) / (at_px - before_px);
    before_mm = y_mm;
    before_px = at_px;
    y_mm = next_mm;
  }
  return seen(y_mm);
}

/// The x of a vertical line, drawn through the pre-distortion of `drawing`, at which the eye sees it on the
/// side at x, z of the table, plus an offset of `off_px` in the frame buffer. Undistorted px of `drawing`.
double side_value(const view::Eye& drawing, const VirtualTruth& truth, bool is_right,
                  const Eigen::Vector2d& side_table_mm, double off_px)
{
  const double row_px = drawing.sight_px.y();
  const view::Distortion& optics = view::side_of(truth.calibration.eyes, is_right).distortion;
  const auto drawn = [&](double value) -> Eigen::Vector2d {
    return view::drawn_px(drawing.distortion, {value, row_px});
  };
  const auto ahead = [&](double value) {
    const Eigen::Vector2d at = view::shown_px(optics, drawn(value));
    return at.x() - side_at_row(truth, is_right, side_table_mm, at.y()).x();
  };
  constexpr double apart_px = 1.0, resolution_px = 1e-10;
  constexpr int most_steps = 30;
  double value = side_at_row(truth, is_right, side_table_mm, row_px).x();
  for (int step = 0; step < most_steps; ++step) {
    const double off = ahead(value);
    if (std::abs(off) < resolution_px) break;
    value -= 2.0 * apart_px * off / (ahead(value + apart_px) - ahead(value - apart_px));
  }
  const double wanted_px = drawn(value).x() + off_px;
  for (int step = 0; step < most_steps && std::abs(drawn(value).x() - wanted_px) > resolution_px; ++step) {
    const double slope = (drawn(value + apart_px).x() - drawn(value - apart_px).x()) / (2.0 * apart_px);
    value -= (drawn(value).x() - wanted_px) / slope;
  }
  return value;
}

struct RectangleLines final : TaskKind {
  RectangleLines()
      : TaskKind(
            {.name = "rectangle", .typical_s = 30.0, .thing = "lines", .n_numbers = 4, .has_two_lines = true})
  {
  }

  DrawnLines draw(const Task& task, std::span<const double> values, const Calibration& found) const override
  {
    const view::Eye& eye = view::side_of(found.eyes, task.is_right);
    DrawnLines lines;
    Pen pen(eye, task.is_right, lines);
    const view::ShownBox box = view::shown_box(eye);
    for (const double side : values) pen.draw_shown({side, box.low_px.y()}, {side, box.high_px.y()});
    return lines;
  }

  /// From above: eyes, and the rectangles behind each other.
  void sketch(Sketch& sketch, const Task& task, const BenchFile& bench) const override
  {
    using enum DiagramInk;
    using Point = Eigen::Vector2d;
    const CalibrationSettings& settings = bench.calibration;
    double deepest = 1.0, widest = 1.0;
    for (const auto& r : settings.rectangles) {
      deepest = std::max(deepest, r.depth_mm);
      widest = std::max(widest, r.width_mm);
    }
    const Point eye(task.is_right ? 0.55 : 0.45, 0.56);
    sketch.eyes(0.5, 0.05, task.is_right ? plain : lit, task.is_right ? lit : plain);
    for (std::size_t k = 0; k < settings.rectangles.size(); ++k) {
      const auto& r = settings.rectangles[k];
      const double y = 0.34 - 0.28 * r.depth_mm / deepest, half = 0.3 * r.width_mm / widest;
      const bool is_it = static_cast<int>(k) == task.index;
      sketch.line(is_it ? real : plain, {{0.5 - half, y}, {0.5 + half, y}});
      if (!is_it) continue;
      sketch.line(lit, {eye, {0.5 - half, y}});
      sketch.line(lit, {eye, {0.5 + half, y}});
    }
  }

  /// {x, y of the left line, x, y of the right one}, as drawn: one point determines a line, its intersection
  /// with the height of the optical axis.
  std::vector<double> mark_row(const Task& task, std::span<const double> values,
                               const Calibration& calibration) const override
  {
    const view::Eye& eye = view::side_of(calibration.eyes, task.is_right);
    std::vector<double> row;
    for (const double x : values) {
      const Eigen::Vector2d drawn = view::drawn_px(eye.distortion, Eigen::Vector2d(x, eye.sight_px.y()));
      row.insert(row.end(), {drawn.x(), drawn.y()});
    }
    return row;
  }

  std::vector<double> aligned_values(const TaskContext& context) const override
  {
    const RectangleSides sides =
        rectangle_sides(context.bench, context.truth, static_cast<std::size_t>(context.task.index));
    const view::Eye& drawing = view::side_of(context.found.eyes, context.task.is_right);
    std::vector<double> values;
    for (const double x_mm : {sides.left_table_mm, sides.right_table_mm}) {
      values.push_back(side_value(drawing, context.truth, context.task.is_right, {x_mm, sides.z_table_mm},
                                  context.noise.alignment_px * context.draws.normal()));
    }
    return values;
  }

  DrawnLines outlines(const Task& task, const BenchFile& bench, const VirtualTruth& truth) const override
  {
    const RectangleSides sides = rectangle_sides(bench, truth, static_cast<std::size_t>(task.index));
    const double middle_mm = truth.calibration.X_table_eyes.shift_mm.y();
    // The height is two thirds of the width.
    const double half_mm = (sides.right_table_mm - sides.left_table_mm) / 3.0;
    Points2d points;
    for (const Eigen::Vector2d& corner :
         rectangle_points({sides.left_table_mm, -half_mm}, {sides.right_table_mm, half_mm}))
      points.push_back(seen_px(truth, task.is_right, {corner.x(), middle_mm + corner.y(), sides.z_table_mm}));
    return {real_outline(task.is_right, std::move(points))};
  }
};

const RectangleLines rectangle_lines;

Task sides_task(const Calibration& calibration, const CalibrationSettings& settings, bool is_right,
                std::size_t rectangle, int repeat)
{
  const view::Eye& eye = view::side_of(calibration.eyes, is_right);
  const CalibrationRectangle& r = settings.rectangles[rectangle];
  Task task;
  task.kind = &rectangle_lines;
  task.is_right = is_right;
  task.index = static_cast<int>(rectangle);
  task.name =
      eye_text(is_right) + ", rectangle " + std::to_string(rectangle + 1) + ", " + std::to_string(repeat + 1);
  task.instruction = "Place the rectangle " + show::rounded_text(r.width_mm, 1) + " mm wide " +
                     show::rounded_text(r.depth_mm, 1) + " mm behind the plane of the first one.\nWith the " +
                     eye_text(is_right) +
                     ", align one line with each vertical side: Left and Right move the left line, Up and "
                     "Down the right one.";
  // Start value for a nominal eye at a nominal position.
  const view::Eye usual;
  const double half_px =
      0.5 * r.width_mm * usual.distance_px / std::max(100.0, calibration.image_distance_mm + r.depth_mm);
  const view::ShownBox box = view::shown_box(eye);
  const auto side = [&](const char* name, double x) {
    return dial(name, "px", std::clamp(x, box.low_px.x(), box.high_px.x()), box.low_px.x(), box.high_px.x(),
                dial_step_px);
  };
  task.dials = {side("left side", eye.sight_px.x() - half_px),
                side("right side", eye.sight_px.x() + half_px)};
  return task;
}

struct EyepointsPart final : EyePart {
  using EyePart::EyePart;

  std::optional<std::vector<double>> made_with(const PartInput& in) const override
  {
    std::vector<double> numbers;
    for (const CalibrationRectangle& r : in.bench.calibration.rectangles)
      numbers.insert(numbers.end(), {r.width_mm, r.depth_mm});
    return numbers;
  }

  std::vector<Task> tasks(const BenchFile& bench, const Calibration& calibration) const override
  {
    const CalibrationSettings& settings = bench.calibration;
    std::vector<Task> tasks;
    for (const bool is_right : {false, true}) {
      for (int repeat = 0; repeat < settings.rectangle_repeats; ++repeat) {
        for (std::size_t k = 0; k < settings.rectangles.size(); ++k)
          tasks.push_back(sides_task(calibration, settings, is_right, k, repeat));
      }
    }
    return tasks;
  }

  /// Expected accuracy.
  std::string introduction(const BenchFile& bench, const Calibration& calibration) const override
  {
    constexpr double usual_noise_px = 0.5;  // of aligning a line
    const Eyepoint usual{view::Eye().distance_px, calibration.image_distance_mm};
    const CalibrationSettings& settings = bench.calibration;
    std::vector<RectangleMark> marks;
    for (int repeat = 0; repeat < settings.rectangle_repeats; ++repeat) {
      for (const CalibrationRectangle& r : settings.rectangles) marks.push_back({r.width_mm, r.depth_mm});
    }
    const Eigen::Vector2d sd = expected_eyepoint_sd(marks, usual, usual_noise_px);
    return "Expected accuracy with these rectangles and half a pixel of noise: distance about +-" +
           show::rounded_text(2.0 * sd.x(), 1) + " px, depth +-" + show::rounded_text(2.0 * sd.y(), 1) +
           " mm. A larger range of depths improves it.";
  }

  void apply(view::EyePair& eyes, const Estimate& found) const override
  {
    eyes.left.distance_px = value_in(found, "left.distance");
    eyes.right.distance_px = value_in(found, "right.distance");
    // The origin of the head frame stays at the midpoint; the eye with the larger depth is further back.
    const double apart_mm = value_in(found, "left.depth") - value_in(found, "right.depth");
    eyes.left.position_head_mm.z() = 0.5 * apart_mm;
    eyes.right.position_head_mm.z() = -0.5 * apart_mm;
  }

  Estimate solve_eye(const PartInput& in, bool is_right) const override
  {
    return solve_eye_rectangles(in, is_right).fit.estimate;
  }
};

const EyepointsPart eyepoints_object({.id = CalibrationPart::eyepoints,
                                      .group = Part::Group::eye,
                                      .bench_key = "calibration.rectangles",
                                      .below = {CalibrationPart::distortion}});

}  // namespace

EyeRectangles solve_eye_rectangles(const PartInput& in, bool is_right)
{
  const CalibrationSettings& settings = in.bench.calibration;
  EyeRectangles found;
  const view::EyePair eyes = eyes_before(CalibrationPart::eyepoints, in);
  found.eye = view::side_of(eyes, is_right);
  const std::vector<MarkedTask> tasks = tasks_of_eye(CalibrationPart::eyepoints, in, is_right);
  for (const MarkedTask& t : tasks) {
    const CalibrationRectangle& r = settings.rectangles[static_cast<std::size_t>(t.task.index)];
    const std::vector<double>& v = t.mark->rows[0];
    found.marks.push_back({r.width_mm, r.depth_mm, {v[0], v[1]}, {v[2], v[3]}});
  }
  EyepointOptions options;
  options.alignment_sd_rad = settings.alignment_sd_rad;
  options.distortion_covariance =
      prior_covariance(estimate_of(CalibrationPart::distortion, in), distortion_names(is_right));
  found.fit = run_fit(names_of(tasks), [&] {
    return fit_eyepoint(found.marks, found.eye, options, side_name(is_right), in.path);
  });
  return found;
}

const Part& eyepoints_part = eyepoints_object;

}  // namespace vrda::calibration
