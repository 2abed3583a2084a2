// Pose of the eyes on the table (bullseye) or on the head's body (head), from crosses aligned with a tracked
// marker (thesis 8.5).
#include <array>
#include <cmath>

#include "bench/rigid_body.hpp"
#include "calibration/bench_poses.hpp"
#include "calibration/drawing.hpp"
#include "calibration/eyepoint_fit.hpp"
#include "calibration/eyes_fit.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
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
    constexpr int n = 48;
    for (const double radius_px : {6.0, 12.0}) {
      const auto on_ring = [&](int k) {
        const double angle = 2.0 * pi * k / n;
        return Eigen::Vector2d(at + radius_px * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
      };
      for (int k = 0; k < n; ++k) pen.draw_shown(on_ring(k), on_ring(k + 1));
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
  A.topRightCorner<3, 3>() = rad_from_deg(1.0) * bench::cross_matrix(X_table_eyes.translation()) * R_t;
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
    Task task;
    task.kind = &bullseye;
    task.is_right = is_right;
    task.index = place;
    task.tool = bench.calibration.marker;
    task.n_samples = bench.calibration.hold_samples;
    if (is_head_) task.body = BodyRole::head;
    task.name = eye_text(is_right) + ", place " + std::to_string(place + 1);
    task.instruction =
        "Put the marker " + place_text(place) +
        (is_head_ ? " and change the orientation of the head." : "; the stage may be at any position.") +
        "\nWith the " + eye_text(is_right) +
        ", align the cross with it and press Enter. Keep still until sampling is done.";
    task.dials = {dial("x", "px", eye.sight_px.x(), box.low_px.x(), box.high_px.x(), dial_step_px),
                  dial("y", "px", eye.sight_px.y(), box.low_px.y(), box.high_px.y(), dial_step_px)};
    return task;
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

const Part& bullseye_part = bullseye_object;
const Part& head_part = head_object;

}  // namespace vrda::calibration
