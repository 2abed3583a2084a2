// The eyes: field of view and depth of each from rectangles of known sizes at known depths (thesis 8.3), and
// their pose on the table or on the head's body from crosses aligned with a tracked marker (thesis 8.5).
#include <algorithm>
#include <cmath>

#include "bench/rigid_body.hpp"
#include "calibration/eyes_fit.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/virtual_bench.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::calibration {

// Rectangles.

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
  using TaskKind::TaskKind;

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

const RectangleLines rectangle_lines(
    {.name = "rectangle", .typical_s = 30.0, .thing = "lines", .n_numbers = 4, .has_two_lines = true});

Task sides_task(const Calibration& calibration, const CalibrationSettings& settings, bool is_right,
                std::size_t rectangle, int repeat)
{
  const view::Eye& eye = view::side_of(calibration.eyes, is_right);
  const CalibrationRectangle& r = settings.rectangles[rectangle];
  // Start value for a nominal eye at a nominal position.
  const view::Eye usual;
  const double half_px =
      0.5 * r.width_mm * usual.distance_px / std::max(100.0, calibration.image_distance_mm + r.depth_mm);
  const view::ShownBox box = view::shown_box(eye);
  const auto side = [&](const char* name, double x) {
    return dial(name, "px", std::clamp(x, box.low_px.x(), box.high_px.x()), box.low_px.x(), box.high_px.x(),
                dial_step_px);
  };
  return {.kind = &rectangle_lines,
          .name = eye_text(is_right) + ", rectangle " + std::to_string(rectangle + 1) + ", " +
                  std::to_string(repeat + 1),
          .instruction = "Place the rectangle " + bench::text(r.width_mm, 1, "mm") + " wide " +
                         bench::text(r.depth_mm, 1, "mm") + " behind the plane of the first one.\nWith the " +
                         eye_text(is_right) +
                         ", align one line with each vertical side: Left and Right move the left line, Up "
                         "and Down the right one.",
          .is_right = is_right,
          .dials = {side("left side", eye.sight_px.x() - half_px),
                    side("right side", eye.sight_px.x() + half_px)},
          .index = static_cast<int>(rectangle)};
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
           short_decimal(2.0 * sd.x(), 1) + " px, depth +-" + short_decimal(2.0 * sd.y(), 1) +
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

// Crosses on a tracked marker.

namespace {

/// The marker at its position `index`, visible to both eyes; the head moves between positions.
BenchPoses bullseye_poses(const BenchFile& bench, const VirtualTruth& truth, int index)
{
  RandomSequence draws = draws_of_hand(truth, 0, index);
  const Eigen::Vector3d place = requested_marker_position(index).cast<double>();
  const double depth_mm = 750.0 + 200.0 * place.z() + 40.0 * (draws.uniform() - 0.5);
  const view::Eye& eye = truth.calibration.eyes.left;
  const Eigen::Vector2d tangent =
      Eigen::Vector2d(0.25 * eye.visible.width, 0.3 * eye.visible.height) / eye.distance_px;
  const Eigen::Vector3d p_eyes_mm(place.x() * tangent.x() * depth_mm, place.y() * tangent.y() * depth_mm,
                                  -depth_mm);
  Pose X_eyes_moved = Pose::Identity();
  double stage_mm = 0.0;
  if (bench.head == HeadKind::stage) {
    stage_mm = 60.0 + 160.0 * draws.uniform();
  } else {
    X_eyes_moved.linear() = bench::rotation_of(even_vector(draws, rad_from_deg(8.0)));
    X_eyes_moved.translation() = even_vector(draws, 40.0);
  }
  BenchPoses poses = resting_poses(truth, stage_mm, X_eyes_moved);
  poses.X_tracker_tool.translation() = poses.X_tracker_eyes * (p_eyes_mm + even_vector(draws, 10.0));
  return poses;
}

/// The marker in the frame of the eyes.
Eigen::Vector3d marker_eyes_mm(const Task& task, const BenchFile& bench, const VirtualTruth& truth)
{
  const BenchPoses poses = bullseye_poses(bench, truth, task.index);
  return poses.X_tracker_eyes.inverse() * poses.X_tracker_tool.translation();
}

struct Bullseye final : TaskKind {
  using TaskKind::TaskKind;

  /// Rings and a cross with an open centre, which does not hide the marker.
  DrawnLines draw(const Task& task, std::span<const double> values, const Calibration& found) const override
  {
    const Eigen::Vector2d at(values[0], values[1]);
    DrawnLines lines;
    Pen pen(view::side_of(found.eyes, task.is_right), task.is_right, lines);
    constexpr double open_px = 2.0, arm_px = 16.0;
    for (const Eigen::Vector2d& direction :
         {Eigen::Vector2d(1, 0), Eigen::Vector2d(-1, 0), Eigen::Vector2d(0, 1), Eigen::Vector2d(0, -1)})
      pen.draw_shown(at + open_px * direction, at + arm_px * direction);
    for (const double radius_px : {6.0, 12.0}) {
      const Points2d points = ring(at, radius_px, 48);
      for (std::size_t k = 1; k < points.size(); ++k) pen.draw_shown(points[k - 1], points[k]);
    }
    return lines;
  }

  /// The marker's requested position in front of the eyes, from above and, for the height, from the side.
  void sketch(Sketch& sketch, const Task& task, const BenchFile&) const override
  {
    using enum DiagramInk;
    using Point = Eigen::Vector2d;
    const Eigen::Vector3d at = requested_marker_position(task.index).cast<double>();
    sketch.label({0.12, 0.0}, "from above");
    sketch.label({0.62, 0.0}, "from the side");
    sketch.eyes(0.25, 0.03, task.is_right ? plain : lit, task.is_right ? lit : plain);
    sketch.box(plain, {0.07, 0.1}, {0.43, 0.42});
    const Point above(0.25 + 0.15 * at.x(), 0.26 - 0.13 * at.z());
    sketch.circle(real, above, 0.015);
    sketch.circle(lit, above, 0.03);
    sketch.circle(plain, {0.55, 0.3}, 0.025);
    sketch.box(plain, {0.62, 0.12}, {0.95, 0.48});
    const Point beside(0.785 + 0.13 * at.z(), 0.3 - 0.14 * at.y());
    sketch.circle(real, beside, 0.015);
    sketch.circle(lit, beside, 0.03);
  }

  /// {x_px, y_px} of the cross as drawn.
  std::vector<double> mark_row(const Task& task, std::span<const double> values,
                               const Calibration& calibration) const override
  {
    const view::Distortion& drawing = view::side_of(calibration.eyes, task.is_right).distortion;
    const Eigen::Vector2d drawn = view::drawn_px(drawing, Eigen::Vector2d(values[0], values[1]));
    return {drawn.x(), drawn.y()};
  }

  /// Where the eye sees the cross on the marker, plus an offset in the frame buffer.
  std::vector<double> aligned_values(const TaskContext& context) const override
  {
    const view::Eye& eye = view::side_of(context.truth.calibration.eyes, context.task.is_right);
    const Eigen::Vector2d seen_px =
        view::shown_px(eye, marker_eyes_mm(context.task, context.bench, context.truth));
    const Eigen::Vector2d wanted_px = view::drawn_px(eye.distortion, seen_px) + alignment_off_px(context);
    const view::Eye& drawing = view::side_of(context.found.eyes, context.task.is_right);
    const Eigen::Vector2d value = view::shown_px(drawing.distortion, wanted_px);
    return {value.x(), value.y()};
  }

  DrawnLines outlines(const Task& task, const BenchFile& bench, const VirtualTruth& truth) const override
  {
    constexpr double radius_mm = 4.0;  // of the marker
    const Eigen::Vector3d p_eyes_mm = marker_eyes_mm(task, bench, truth);
    const view::Eye& eye = view::side_of(truth.calibration.eyes, task.is_right);
    const double radius_px = eye.distance_px * radius_mm / (eye.position_head_mm.z() - p_eyes_mm.z());
    return {real_outline(task.is_right, ring(view::shown_px(eye, p_eyes_mm), radius_px))};
  }

  BenchPoses poses(const TaskContext& context, double) const override
  {
    return bullseye_poses(context.bench, context.truth, context.task.index);
  }
};

const Bullseye bullseye({.name = "bull's-eye",
                         .typical_s = 20.0,
                         .thing = "cross",
                         .samples = TaskKind::Samples::position,
                         .n_numbers = 3,
                         .is_cross = true,
                         .uses_stage = true});

std::string place_text(int index)
{
  static constexpr std::array<const char*, 3> across{"to the left", "in the middle", "to the right"};
  static constexpr std::array<const char*, 3> up{"low", "at eye level", "high"};
  static constexpr std::array<const char*, 3> depth{"near", "half way", "far"};
  const Eigen::Vector3i place = requested_marker_position(index);
  const auto word = [](const auto& words, int k) {
    return std::string(words[static_cast<std::size_t>(k + 1)]);
  };
  return word(depth, place.z()) + ", " + word(across, place.x()) + ", " + word(up, place.y());
}

/// Adds the table's covariance to the pose of the eyes on the table. Bull's-eyes determine the eyes in the
/// tracker frame, so a table error (translation b, rotation a, tracker axes) becomes, with R of
/// X_tracker_table and t of X_table_eyes, the rotation -R^T a and the translation -R^T b - (R^T a) x t. mm
/// and degrees.
void add_table_error(Estimate& eyes, const Pose& X_table_eyes, const Pose& X_tracker_table,
                     const Estimate& table)
{
  const Eigen::Matrix3d R_t = X_tracker_table.linear().transpose();
  Matrix6 A = Matrix6::Zero();
  A.topLeftCorner<3, 3>() = -R_t;
  A.topRightCorner<3, 3>() = rad_from_deg(1.0) * cross_matrix(X_table_eyes.translation()) * R_t;
  A.bottomRightCorner<3, 3>() = -R_t;
  eyes.covariance.topLeftCorner<6, 6>() +=
      A * prior_covariance(table, bench::pose_number_names("table")) * A.transpose();
}

EyesPrior eyes_prior(const PartInput& in)
{
  const CalibrationSettings& settings = in.bench.calibration;
  EyesPrior prior;
  prior.eyes = eyes_before(CalibrationPart::bullseye, in);
  prior.eyepoint_covariance =
      prior_covariance(estimate_of(CalibrationPart::eyepoints, in),
                       {"left.distance", "left.depth", "right.distance", "right.depth"});
  prior.ipd_sd_mm = std::sqrt(prior_covariance(estimate_of(CalibrationPart::ipd, in), {"ipd"})(0, 0));
  prior.sight_sd_px = settings.sight_sd_px;
  prior.height_difference_sd_mm = settings.eye_height_sd_mm;
  const Estimate& distortion = estimate_of(CalibrationPart::distortion, in);
  for (const bool is_right : {false, true}) {
    const std::size_t k = is_right ? 1 : 0;
    prior.distortion_covariance[k] = prior_covariance(distortion, distortion_names(is_right));
    prior.eyepoint_distortion_jacobian[k] = solve_eye_rectangles(in, is_right).fit.distortion_jacobian;
  }
  return prior;
}

BullseyeMark bullseye_of(const MarkedTask& t, const Pose& X_carrier_seen, bool is_on_stage)
{
  const std::vector<double>& cross = t.mark->rows[0];
  const MeanPosition mean = mean_position(places_of(t.task, *t.mark));
  BullseyeMark mark;
  mark.is_right = t.task.is_right;
  mark.drawn_px = {cross[0], cross[1]};
  mark.p_carrier_mm =
      X_carrier_seen * mean.p_mm - (is_on_stage ? 1.0 : 0.0) * cross[2] * Eigen::Vector3d::UnitX();
  mark.p_sd_mm = mean.sd_mm / std::sqrt(static_cast<double>(t.mark->rows.size() - 1));
  return mark;
}

/// `id`: bullseye, with the eyes on a stage of the table, or head, with the eyes on a tracked body.
struct EyesPart final : Part {
  constexpr explicit EyesPart(CalibrationPart id)
      : Part({.id = id,
              .is_tracking = id == CalibrationPart::bullseye,
              .bench_key = "board.stage_mm_per_count",
              .is_made_of_them = id == CalibrationPart::bullseye}),
        is_head_(id == CalibrationPart::head)
  {
  }

  bool applies_to(const BenchFile& bench) const override
  {
    return (bench.head == HeadKind::stage) != is_head_;
  }
  bool uses_rectangles(const BenchFile&) const override { return true; }

  std::vector<CalibrationPart> below(const BenchFile&) const override
  {
    using enum CalibrationPart;
    if (is_head_) return {eyepoints, ipd};
    return {rails, stop, eyepoints, ipd};
  }

  std::optional<std::vector<double>> made_with(const PartInput& in) const override
  {
    if (is_head_ || !has_stage(in.bench)) return std::vector<double>();
    return std::vector<double>{in.bench.stage_mm_per_count};
  }

  std::vector<Task> tasks(const BenchFile& bench, const Calibration& calibration) const override
  {
    std::vector<Task> tasks;
    for (int place = 0; place < bench.calibration.bullseyes; ++place) {
      for (const bool is_right : {false, true}) tasks.push_back(task_of(bench, calibration, place, is_right));
    }
    return tasks;
  }

  void solve(const PartInput& in, Calibration& c) const override
  {
    const Pose X_tracker_table =
        is_head_ ? Pose::Identity() : pose_in(estimate_of(CalibrationPart::rails, in), "table");
    std::vector<BullseyeMark> marks;
    const std::vector<MarkedTask> tasks = marked_tasks(id(), in);
    for (const MarkedTask& t : tasks) marks.push_back(bullseye_of(t, X_tracker_table.inverse(), !is_head_));
    const EyesPrior prior = eyes_prior(in);
    EyesFit fit = run_fit(names_of(tasks), [&] {
      return fit_eyes(marks, prior, initial_eye_pose(marks, prior.eyes), is_head_ ? "head" : "eyes", in.path);
    });
    if (!is_head_)
      add_table_error(fit.estimate, fit.X_carrier_eyes, X_tracker_table,
                      estimate_of(CalibrationPart::rails, in));
    c.records.at(id()).estimate = fit.estimate;
    c.eyes = fit.eyes;
    (is_head_ ? c.X_headbody_eyes : c.X_table_eyes) = bench::pose_parameters_of(fit.X_carrier_eyes);
  }

 private:
  Task task_of(const BenchFile& bench, const Calibration& calibration, int place, bool is_right) const
  {
    const view::Eye& eye = view::side_of(calibration.eyes, is_right);
    const view::ShownBox box = view::shown_box(eye);
    return {.kind = &bullseye,
            .name = eye_text(is_right) + ", place " + std::to_string(place + 1),
            .instruction = "Put the marker " + place_text(place) +
                           (is_head_ ? " and change the orientation of the head."
                                     : "; the stage may be at any position.") +
                           "\nWith the " + eye_text(is_right) +
                           ", align the cross with it and press Enter. Keep still until sampling is done.",
            .is_right = is_right,
            .dials = {dial("x", "px", eye.sight_px.x(), box.low_px.x(), box.high_px.x(), dial_step_px),
                      dial("y", "px", eye.sight_px.y(), box.low_px.y(), box.high_px.y(), dial_step_px)},
            .n_samples = bench.calibration.hold_samples,
            .tool = bench.calibration.marker,
            .body = is_head_ ? std::optional(BodyRole::head) : std::nullopt,
            .index = place};
  }

  bool is_head_;
};

const EyesPart bullseye_object(CalibrationPart::bullseye);
const EyesPart head_object(CalibrationPart::head);

}  // namespace

Eigen::Vector3i requested_marker_position(int index)
{
  // The first four span all directions; corners come before the middles.
  static constexpr std::array<std::array<int, 3>, 27> places{
      {{-1, -1, -1}, {1, 1, -1},  {1, -1, 1},  {-1, 1, 1}, {0, 0, 0},  {1, -1, -1}, {-1, 1, -1},
       {-1, -1, 1},  {1, 1, 1},   {0, 0, -1},  {0, 0, 1},  {-1, 0, 0}, {1, 0, 0},   {0, -1, 0},
       {0, 1, 0},    {-1, 0, -1}, {1, 0, 1},   {-1, 0, 1}, {1, 0, -1}, {0, -1, -1}, {0, 1, 1},
       {0, -1, 1},   {0, 1, -1},  {-1, -1, 0}, {1, 1, 0},  {-1, 1, 0}, {1, -1, 0}}};
  const std::array<int, 3>& place = places[static_cast<std::size_t>(index) % places.size()];
  return {place[0], place[1], place[2]};
}

const Part &bullseye_part = bullseye_object, &head_part = head_object;

}  // namespace vrda::calibration
