#include "calibration/statistics.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <exception>
#include <optional>
#include <string_view>
#include <thread>

#include "bench/rigid_body.hpp"
#include "bench/simulation.hpp"
#include "calibration/bench_poses.hpp"
#include "calibration/functional_fit.hpp"
#include "calibration/marks.hpp"
#include "calibration/operator.hpp"
#include "calibration/parts.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

struct NumberResult {
  std::string part, name, unit;
  double error = 0.0, half_width = 0.0;
};

struct BenchResult {
  bool was_refused = false;
  std::vector<NumberResult> numbers;
  std::vector<TargetError> before, after;
  std::optional<JointError> joint;
  std::exception_ptr failure;
};

/// Rounds to 10 mm and whole degrees.
bench::PoseParameters tape_rounded(const bench::PoseParameters& six)
{
  constexpr double step_mm = 10.0, step_rad = rad_from_deg(1.0);
  return {(six.shift_mm / step_mm).array().round() * step_mm,
          (six.turn_rad / step_rad).array().round() * step_rad};
}

void add_numbers(const Calibration& found, const VirtualTruth& truth, BenchResult& result)
{
  for (const auto& [part, record] : found.records) {
    if (!record.estimate) continue;
    const bench::Estimate& estimate = *record.estimate;
    const Eigen::VectorXd errors = errors_of(estimate, truth);
    for (Eigen::Index k = 0; k < errors.size(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      result.numbers.push_back({bench::name_of(part), estimate.names[i], estimate.units[i], errors[k],
                                bench::half_width_95(estimate, k)});
    }
  }
}

/// A part with everything that it depends on, in the order of execution.
std::vector<CalibrationPart> with_dependencies(CalibrationPart part, const BenchFile& bench)
{
  std::vector<CalibrationPart> parts;
  for (const CalibrationPart below : calibration::dependencies_of(part, bench)) {
    for (const CalibrationPart each : with_dependencies(below, bench)) {
      if (std::ranges::find(parts, each) == parts.end()) parts.push_back(each);
    }
  }
  parts.push_back(part);
  return parts;
}

BenchResult result_of(const BenchFile& bench, const VirtualRun& run, std::uint64_t seed)
{
  const VirtualNoise& noise = run.noise;
  VirtualTruth truth = virtual_truth(bench, seed);
  if (run.joint) truth.joint = virtual_joint(truth, *run.joint, noise);
  calibration::CalibrationSessionOptions options;
  options.joint = run.joint;
  options.parts = run.joint ? with_dependencies(CalibrationPart::functional, bench)
                            : calibration::parts_of_step("all", bench);
  options.date = "2000-01-01";
  options.path = "virtual bench " + std::to_string(seed);
  CalibrationSession session(bench, bench::nominal_calibration(bench), options);
  VirtualOperator hand(bench, truth, noise);
  while (session.task() != nullptr) hand.do_task(session);
  BenchResult result;
  result.was_refused = hand.n_refusals() > 0;
  add_numbers(session.calibration(), truth, result);
  if (run.joint) {
    result.joint = joint_error(session.calibration(), truth);
    return result;
  }
  result.before = target_errors(uncalibrated(bench, truth), bench, truth, noise);
  result.after = target_errors(session.calibration(), bench, truth, noise);
  return result;
}

void add_bench(const BenchResult& result, VirtualStatistics& statistics)
{
  ++statistics.n_benches;
  if (result.was_refused) ++statistics.n_refused;
  for (const NumberResult& number : result.numbers) {
    const auto is_same = [&](const NumberStatistics& s) {
      return s.part == number.part && s.name == number.name;
    };
    auto at = std::ranges::find_if(statistics.numbers, is_same);
    if (at == statistics.numbers.end())
      at = statistics.numbers.insert(at, NumberStatistics{number.part, number.name, number.unit});
    ++at->n;
    if (std::abs(number.error) <= number.half_width) ++at->n_within;
    // Sums; divided at the end.
    at->rms_error += number.error * number.error;
    at->mean_half_width += number.half_width;
  }
  if (result.joint) statistics.joints.push_back(*result.joint);
  statistics.before.insert(statistics.before.end(), result.before.begin(), result.before.end());
  statistics.after.insert(statistics.after.end(), result.after.begin(), result.after.end());
}

}  // namespace

Calibration uncalibrated(const BenchFile& bench, const VirtualTruth& truth)
{
  Calibration calibration = truth.calibration;
  const Calibration nominal = bench::nominal_calibration(bench);
  calibration.eyes = nominal.eyes;
  calibration.X_table_eyes = tape_rounded(truth.calibration.X_table_eyes);
  calibration.X_headbody_eyes = tape_rounded(truth.calibration.X_headbody_eyes);
  return calibration;
}

JointError joint_error(const Calibration& found, const VirtualTruth& truth)
{
  check(truth.joint.has_value(), "the error at the joint needs the joint");
  const Eigen::Vector3d& centre_mm = truth.joint->curve.centre_mm;
  const auto pose_of = [](CalibrationPart part, const Calibration& c, const char* name) {
    return calibration::pose_in(*c.records.at(part).estimate, name);
  };
  JointError error;
  for (const CalibrationPart part : {CalibrationPart::femur, CalibrationPart::tibia}) {
    const BodyRole role = calibration::role_of(part);
    const char* name = bench::name_of(part);
    const Pose X_true = bench::pose_of(truth.calibration.X_body_model[static_cast<std::size_t>(role)]);
    error.by_landmarks_mm = std::hypot(
        error.by_landmarks_mm,
        std::sqrt(0.5) * calibration::joint_error_mm(pose_of(part, found, name), X_true, centre_mm));
    error.functional_mm = std::hypot(
        error.functional_mm,
        std::sqrt(0.5) * calibration::joint_error_mm(pose_of(CalibrationPart::functional, found, name),
                                                     X_true, centre_mm));
  }
  return error;
}

VirtualStatistics virtual_statistics(const BenchFile& bench, const VirtualRun& run)
{
  std::vector<BenchResult> results(static_cast<std::size_t>(std::max(0, run.n_benches)));
  std::atomic<std::size_t> next = 0;
  const auto work = [&] {
    for (std::size_t k = next++; k < results.size(); k = next++) {
      try {
        results[k] = result_of(bench, run, run.first_seed + k);
      } catch (...) {
        results[k].failure = std::current_exception();
      }
    }
  };
  std::vector<std::thread> threads;
  for (int k = 1; k < run.n_threads; ++k) threads.emplace_back(work);
  work();
  for (std::thread& thread : threads) thread.join();
  VirtualStatistics statistics;
  for (const BenchResult& result : results) {
    if (result.failure) std::rethrow_exception(result.failure);
    add_bench(result, statistics);
  }
  for (NumberStatistics& number : statistics.numbers) {
    number.rms_error = std::sqrt(number.rms_error / number.n);
    number.mean_half_width /= number.n;
  }
  return statistics;
}

namespace {

double true_number_of_eye(const VirtualTruth& truth, bool is_right, std::string_view name)
{
  const view::Eye& eye = view::side_of(truth.calibration.eyes, is_right);
  const VirtualTruth::Edges& edges = truth.edges_px[is_right ? 1 : 0];
  if (name == "edge_left") return edges.left;
  if (name == "edge_right") return edges.right;
  if (name == "edge_top") return edges.top;
  if (name == "edge_bottom") return edges.bottom;
  if (name == "pixel_aspect") return eye.pixel_aspect;
  if (name == "k1") return eye.distortion.k1;
  if (name == "k2") return eye.distortion.k2;
  if (name == "centre_x") return eye.distortion.centre_px.x();
  if (name == "centre_y") return eye.distortion.centre_px.y();
  if (name == "sight_x") return eye.sight_px.x();
  if (name == "sight_y") return eye.sight_px.y();
  if (name == "distance") return eye.distance_px;
  check(name == "depth", "no true value for a parameter of an eye");
  return (bench::pose_of(truth.calibration.X_table_eyes) * eye.position_head_mm).z() -
         truth.reference_plane_table_mm;
}

double true_number(const VirtualTruth& truth, const std::string& name)
{
  const Calibration& c = truth.calibration;
  const Eigen::Vector3d apart_mm = c.eyes.right.position_head_mm - c.eyes.left.position_head_mm;
  if (name.starts_with("left.")) return true_number_of_eye(truth, false, std::string_view(name).substr(5));
  if (name.starts_with("right.")) return true_number_of_eye(truth, true, std::string_view(name).substr(6));
  if (name == "ipd") return apart_mm.x();
  if (name == "height_apart") return -apart_mm.y();
  if (name == "depth_apart") return -apart_mm.z();
  if (name == "subject.scale") return c.subject_scale;
  if (name == "probe.tip_x") return truth.tip_probe_mm.x();
  if (name == "probe.tip_y") return truth.tip_probe_mm.y();
  check(name == "probe.tip_z", "no true value for a parameter");
  return truth.tip_probe_mm.z();
}

/// nullptr if the name is not that of a pose.
const bench::PoseParameters* true_pose(const VirtualTruth& truth, const std::string& name)
{
  const Calibration& c = truth.calibration;
  if (name == "table") return &c.X_tracker_table;
  if (name == "eyes") return &c.X_table_eyes;
  if (name == "head") return &c.X_headbody_eyes;
  for (const BodyRole role : {BodyRole::leg, BodyRole::femur, BodyRole::tibia}) {
    if (name == bench::name_of(role)) return &c.X_body_model[static_cast<std::size_t>(role)];
  }
  return nullptr;
}

/// mm and degrees: translation error, and rotation error about the fixed axes.
Eigen::Matrix<double, 6, 1> pose_error(const Eigen::Matrix<double, 6, 1>& found,
                                       const bench::PoseParameters& truth)
{
  bench::PoseParameters six;
  six.shift_mm = found.head<3>();
  six.turn_rad = found.tail<3>() * rad_from_deg(1.0);
  const Eigen::Matrix3d R_wanted = bench::pose_of(truth).linear() * bench::pose_of(six).linear().transpose();
  Eigen::Matrix<double, 6, 1> error;
  error.head<3>() = six.shift_mm - truth.shift_mm;
  error.tail<3>() = -bench::turn_of(R_wanted) / rad_from_deg(1.0);
  return error;
}

/// Poses of the head and the leg's body at one time.
struct Moment {
  Pose X_tracker_eyes, X_tracker_body;
};

/// Poses found with a calibration, from tracker and encoder.
Moment found_moment(const Calibration& found, const BenchFile& bench, const BenchPoses& standing,
                    const Pose& X_tracker_body_seen, const Pose& X_tracker_headbody_seen)
{
  Moment moment;
  moment.X_tracker_body = X_tracker_body_seen;
  const double stage_mm = std::round(standing.stage_mm / bench.stage_mm_per_count) * bench.stage_mm_per_count;
  moment.X_tracker_eyes = bench.head == HeadKind::stage
                              ? X_tracker_eyes(found, stage_mm)
                              : X_tracker_headbody_seen * bench::pose_of(found.X_headbody_eyes);
  return moment;
}

/// Direction of what is seen at `px`, in the eye's axes.
Eigen::Vector3d ray(const view::Eye& eye, const Eigen::Vector2d& px)
{
  const Eigen::Vector2d off = (px - eye.sight_px) / eye.distance_px;
  return Eigen::Vector3d(off.x(), -off.y() * eye.pixel_aspect, -1.0).normalized();
}

TargetError error_for_eye(const view::Eye& found_eye, const Eigen::Vector3d& p_found_eyes_mm,
                          const view::Eye& true_eye, const Eigen::Vector3d& p_true_eyes_mm)
{
  const Eigen::Vector2d drawn = view::drawn_px(found_eye, p_found_eyes_mm);
  const Eigen::Vector3d seen = ray(true_eye, view::shown_px(true_eye.distortion, drawn));
  const Eigen::Vector3d wanted = p_true_eyes_mm - true_eye.position_head_mm;
  const double angle_rad =
      arc_tangent2(seen.cross(wanted.normalized()).norm(), seen.dot(wanted.normalized()));
  return {angle_rad * wanted.norm(), deg_from_rad(angle_rad) * 60.0};
}

}  // namespace

Eigen::VectorXd errors_of(const bench::Estimate& estimate, const VirtualTruth& truth)
{
  Eigen::VectorXd errors(estimate.values.size());
  Eigen::Index k = 0;
  while (k < errors.size()) {
    const std::string& name = estimate.names[static_cast<std::size_t>(k)];
    const std::size_t dot = name.find(".shift_x");
    const bench::PoseParameters* place =
        dot == std::string::npos ? nullptr : true_pose(truth, name.substr(0, dot));
    if (place) {
      errors.segment<6>(k) = pose_error(estimate.values.segment<6>(k), *place);
      k += 6;
    } else {
      errors[k] = estimate.values[k] - true_number(truth, name);
      ++k;
    }
  }
  return errors;
}

std::vector<TargetError> target_errors(const Calibration& found, const BenchFile& bench,
                                       const VirtualTruth& truth, const VirtualNoise& noise,
                                       std::uint64_t index)
{
  // Distinct from the indices of the procedure itself.
  constexpr std::uint64_t first = 1ULL << 32U;
  RandomSequence draws(truth.seed, bench::RandomPurpose::virtual_tracker, first + index);
  const BodyRole role = bench.leg == LegKind::rigid ? BodyRole::leg : BodyRole::femur;
  const auto model_of = [&](const Calibration& c) {
    return bench::pose_of(c.X_body_model[static_cast<std::size_t>(role)]);
  };
  const Calibration& real = truth.calibration;
  const Pose X_table_model =
      bench::pose_of(real.X_tracker_table).inverse() * X_tracker_body(truth, role) * model_of(real);
  BenchPoses standing = resting_poses(truth);
  if (bench.head == HeadKind::stage) {
    // Near the position from which the knee is straight ahead.
    constexpr double about_mm = 50.0;
    standing.stage_mm = X_table_model.translation().x() - real.X_table_eyes.shift_mm.x() +
                        about_mm * (2.0 * draws.uniform() - 1.0);
    standing.X_tracker_eyes = X_tracker_eyes(real, standing.stage_mm);
  }
  const Pose X_body_seen = measured(X_tracker_body(truth, role), noise, draws);
  const Pose X_headbody_seen = measured(standing.X_tracker_headbody, noise, draws);
  const Moment by_found = found_moment(found, bench, standing, X_body_seen, X_headbody_seen);
  const Pose X_model_table = X_table_model.inverse();
  std::vector<TargetError> errors;
  for (int k = 0; k < 20; ++k) {
    // The corners, and three more along each vertical edge.
    const int height = k / 4 - 2;
    const bool is_left = k % 2 == 0, is_behind = k / 2 % 2 == 0;
    const Eigen::Vector3d off_mm(is_left ? -80.0 : 80.0, 60.0 * height, is_behind ? -60.0 : 60.0);
    const Eigen::Vector3d p_leg_mm = X_model_table * (X_table_model.translation() + off_mm);
    const Eigen::Vector3d p_true_mm =
        standing.X_tracker_eyes.inverse() * X_tracker_body(truth, role) * model_of(real) * p_leg_mm;
    const Eigen::Vector3d p_found_mm = by_found.X_tracker_eyes.inverse() * by_found.X_tracker_body *
                                       model_of(found) *
                                       (found.subject_scale / real.subject_scale * p_leg_mm);
    for (const bool is_right : {false, true}) {
      errors.push_back(error_for_eye(view::side_of(found.eyes, is_right), p_found_mm,
                                     view::side_of(real.eyes, is_right), p_true_mm));
    }
  }
  return errors;
}

namespace {

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

}  // namespace

Pose X_tracker_eyes(const Calibration& calibration, double stage_mm)
{
  Pose X_table_eyes = bench::pose_of(calibration.X_table_eyes);
  X_table_eyes.translation() += stage_mm * calibration.stage_direction_table;
  return bench::pose_of(calibration.X_tracker_table) * X_table_eyes;
}

RectangleSides rectangle_sides(const BenchFile& bench, const VirtualTruth& truth, std::size_t index)
{
  check(index < bench.calibration.rectangles.size(), "rectangle index out of range");
  const bench::CalibrationRectangle& rectangle = bench.calibration.rectangles[index];
  // Placed by hand, some millimetres off centre.
  constexpr std::uint64_t first = 1000;
  constexpr double off_sd_mm = 5.0;
  const double x_mm =
      truth.calibration.X_table_eyes.shift_mm.x() +
      off_sd_mm * RandomSequence(truth.seed, bench::RandomPurpose::virtual_bench, first + index).normal();
  return {x_mm - 0.5 * rectangle.width_mm, x_mm + 0.5 * rectangle.width_mm,
          truth.reference_plane_table_mm - rectangle.depth_mm};
}

Eigen::Vector2d seen_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector3d& p_table_mm)
{
  const Eigen::Vector3d p_eyes_mm = bench::pose_of(truth.calibration.X_table_eyes).inverse() * p_table_mm;
  return view::shown_px(view::side_of(truth.calibration.eyes, is_right), p_eyes_mm);
}

double scan_reading(double border_px, bool is_last)
{
  return is_last ? std::floor(border_px - 0.5) : std::ceil(border_px - 0.5);
}

Eigen::Vector2d drawn_node_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector2d& node)
{
  const view::Eye& eye = view::side_of(truth.calibration.eyes, is_right);
  return view::drawn_px(eye.distortion,
                        calibration::shown_px(truth.grids[is_right ? 1 : 0], eye.pixel_aspect, node));
}

double side_value(const SideLine& line, const VirtualTruth& truth, bool is_right,
                  const Eigen::Vector2d& side_table_mm, double off_px)
{
  const view::Distortion& drawing = line.drawing.distortion;
  const view::Distortion& optics = view::side_of(truth.calibration.eyes, is_right).distortion;
  const auto drawn = [&](double value) -> Eigen::Vector2d {
    return view::drawn_px(drawing, {value, line.row_px});
  };
  const auto ahead = [&](double value) {
    const Eigen::Vector2d at = view::shown_px(optics, drawn(value));
    return at.x() - side_at_row(truth, is_right, side_table_mm, at.y()).x();
  };
  constexpr double apart_px = 1.0, resolution_px = 1e-10;
  constexpr int most_steps = 30;
  double value = side_at_row(truth, is_right, side_table_mm, line.row_px).x();
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

Eigen::Vector2d cross_value(const view::Eye& drawing, const VirtualTruth& truth, bool is_right,
                            const Eigen::Vector2d& seen_px, const Eigen::Vector2d& off_px)
{
  const view::Distortion& optics = view::side_of(truth.calibration.eyes, is_right).distortion;
  const Eigen::Vector2d wanted_px = view::drawn_px(optics, seen_px) + off_px;
  return view::shown_px(drawing.distortion, wanted_px);
}

namespace {

using Line = std::vector<Eigen::Vector2d>;

/// Largest distance of neighbouring points: straight lines appear curved.
constexpr double apart_px = 8.0;
constexpr std::array<float, 3> real_colour = {1.0F, 0.75F, 0.3F}, aside_colour = {0.45F, 0.34F, 0.14F};

/// Subdivides the line so that points are at most `apart_px` apart.
Line with_points_between(const Line& line)
{
  Line dense;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (k > 0) {
      const Eigen::Vector2d& from = line[k - 1];
      const Eigen::Vector2d way = line[k] - from;
      const int n = std::max(1, static_cast<int>(std::ceil(way.norm() / apart_px)));
      for (int i = 1; i < n; ++i) dense.emplace_back(from + way * i / n);
    }
    dense.push_back(line[k]);
  }
  return dense;
}

DrawnLine outline(bool is_right, Line points, double width_px = 1.5)
{
  DrawnLine line;
  line.is_right = is_right;
  line.points_px = std::move(points);
  line.width_px = width_px;
  line.colour = real_colour;
  return line;
}

std::vector<DrawnLine> visible_border(const Task& task, const VirtualTruth& truth)
{
  const VirtualTruth::Edges& e = truth.edges_px[task.is_right ? 1 : 0];
  Line border = with_points_between(
      {{e.left, e.top}, {e.right, e.top}, {e.right, e.bottom}, {e.left, e.bottom}, {e.left, e.top}});
  const view::Distortion& optics = view::side_of(truth.calibration.eyes, task.is_right).distortion;
  for (Eigen::Vector2d& point : border) point = view::shown_px(optics, point);
  return {outline(task.is_right, std::move(border))};
}

Line ring(const Eigen::Vector2d& middle_px, double radius_px)
{
  constexpr int n_points = 24;
  Line points;
  points.reserve(n_points + 1);
  for (int k = 0; k <= n_points; ++k) {
    const SinCos at = sin_cos(2.0 * pi * k / n_points);
    points.emplace_back(middle_px + radius_px * Eigen::Vector2d(at.cos, at.sin));
  }
  return points;
}

std::vector<DrawnLine> physical_grid(const Task& task, const BenchFile& bench, const VirtualTruth& truth)
{
  const double aspect = view::side_of(truth.calibration.eyes, task.is_right).pixel_aspect;
  const calibration::GridPose& grid = truth.grids[task.is_right ? 1 : 0];
  const double x = 0.5 * (bench.calibration.grid_columns - 1), y = 0.5 * (bench.calibration.grid_rows - 1);
  const auto at = [&](double column, double row) {
    return calibration::shown_px(grid, aspect, {column, row});
  };
  std::vector<DrawnLine> lines;
  const int n_lines = bench.calibration.grid_columns + bench.calibration.grid_rows + 1;
  lines.reserve(static_cast<std::size_t>(n_lines));
  for (int k = 0; k < bench.calibration.grid_columns; ++k)
    lines.push_back(outline(task.is_right, {at(k - x, -y), at(k - x, y)}));
  for (int k = 0; k < bench.calibration.grid_rows; ++k)
    lines.push_back(outline(task.is_right, {at(-x, k - y), at(x, k - y)}));
  if (task.kind == TaskKind::point) {
    for (DrawnLine& line : lines) line.colour = aside_colour;
    constexpr double radius_px = 6.0;
    lines.push_back(outline(task.is_right, ring(at(task.node.x(), task.node.y()), radius_px)));
  }
  return lines;
}

std::vector<DrawnLine> rectangle(const Task& task, const BenchFile& bench, const VirtualTruth& truth)
{
  const RectangleSides sides = rectangle_sides(bench, truth, static_cast<std::size_t>(task.index));
  const double middle_mm = truth.calibration.X_table_eyes.shift_mm.y();
  // The height is two thirds of the width.
  const double half_mm = (sides.right_table_mm - sides.left_table_mm) / 3.0;
  Line points;
  for (const Eigen::Vector2d& corner : {Eigen::Vector2d(sides.left_table_mm, -half_mm),
                                        {sides.right_table_mm, -half_mm},
                                        {sides.right_table_mm, half_mm},
                                        {sides.left_table_mm, half_mm},
                                        {sides.left_table_mm, -half_mm}})
    points.push_back(seen_px(truth, task.is_right, {corner.x(), middle_mm + corner.y(), sides.z_table_mm}));
  return {outline(task.is_right, std::move(points))};
}

std::vector<DrawnLine> marker(const Task& task, const BenchFile& bench, const VirtualTruth& truth)
{
  const BenchPoses standing = bullseye_poses(bench, truth, task.index);
  const Eigen::Vector3d p_eyes_mm = standing.X_tracker_eyes.inverse() * standing.X_tracker_tool.translation();
  const view::Eye& eye = view::side_of(truth.calibration.eyes, task.is_right);
  // Marker diameter: 8 mm.
  constexpr double radius_mm = 4.0;
  const double radius_px = eye.distance_px * radius_mm / (eye.position_head_mm.z() - p_eyes_mm.z());
  return {outline(task.is_right, ring(view::shown_px(eye, p_eyes_mm), radius_px))};
}

std::vector<DrawnLine> test_object(const VirtualTruth& truth)
{
  std::vector<DrawnLine> lines;
  constexpr double half_mm = 0.5 * calibration::test_frame_size_mm;
  const double z_mm = -truth.calibration.image_distance_mm;
  for (const bool is_right : {false, true}) {
    const view::Eye& eye = view::side_of(truth.calibration.eyes, is_right);
    const auto at = [&](double x, double y) { return view::shown_px(eye, Eigen::Vector3d(x, y, z_mm)); };
    lines.push_back(outline(is_right, {at(-half_mm, -half_mm), at(half_mm, -half_mm), at(half_mm, half_mm),
                                       at(-half_mm, half_mm), at(-half_mm, -half_mm)}));
  }
  return lines;
}

/// Polyline through the points of a scaled model, subdivided so that curvature is visible.
std::vector<Eigen::Vector3d> polyline_mm(const std::vector<CalibrationPoint>& points, double scale)
{
  constexpr int n_pieces = 16;
  std::vector<Eigen::Vector3d> way;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Eigen::Vector3d& to_mm = points[k].p_model_mm;
    const Eigen::Vector3d& from_mm = points[k == 0 ? 0 : k - 1].p_model_mm;
    const int n = k == 0 ? 1 : n_pieces;
    for (int i = 1; i <= n; ++i) way.emplace_back(scale * (from_mm + (to_mm - from_mm) * i / n));
  }
  return way;
}

std::vector<DrawnLine> leg(const BenchFile& bench, const VirtualTruth& truth)
{
  const Calibration& c = truth.calibration;
  const Pose X_eyes_tracker = resting_poses(truth).X_tracker_eyes.inverse();
  std::vector<DrawnLine> lines;
  for (const CalibrationPart part : calibration::parts_of(bench)) {
    if (!calibration::is_model_part(part)) continue;
    const BodyRole role = calibration::role_of(part);
    const Pose X_eyes_model = X_eyes_tracker * X_tracker_body(truth, role) *
                              bench::pose_of(c.X_body_model[static_cast<std::size_t>(role)]);
    for (const bool is_right : {false, true}) {
      Line line;
      for (const Eigen::Vector3d& p_mm :
           polyline_mm(calibration::points_of(part, bench.calibration), c.subject_scale))
        line.push_back(view::shown_px(view::side_of(c.eyes, is_right), Eigen::Vector3d(X_eyes_model * p_mm)));
      lines.push_back(outline(is_right, std::move(line)));
    }
  }
  return lines;
}

}  // namespace

std::vector<DrawnLine> drawn_model_lines(const ModelPlacement& placed, const BenchFile& bench,
                                         const VirtualTruth& truth)
{
  check(placed.values.size() == 6, "a pose has six dials");
  const Eigen::Vector3d turn_deg(placed.values[3], placed.values[4], placed.values[5]);
  const Pose X_body_model = bench::pose_of(bench::PoseParameters{
      {placed.values[0], placed.values[1], placed.values[2]}, turn_deg * rad_from_deg(1.0)});
  const Calibration& found = placed.found;
  const Pose X_tracker_head = bench.head == HeadKind::stage ? X_tracker_eyes(found, 0.0)
                                                            : resting_poses(truth).X_tracker_headbody *
                                                                  bench::pose_of(found.X_headbody_eyes);
  const Pose X_eyes_model =
      X_tracker_head.inverse() * X_tracker_body(truth, calibration::role_of(placed.part)) * X_body_model;
  std::vector<DrawnLine> lines;
  for (const bool is_right : {false, true}) {
    DrawnLine& line = lines.emplace_back();
    line.is_right = is_right;
    line.width_px = 1.5;
    const view::Eye& eye = view::side_of(found.eyes, is_right);
    for (const Eigen::Vector3d& p_mm :
         polyline_mm(calibration::points_of(placed.part, bench.calibration), found.subject_scale)) {
      const Eigen::Vector3d p_eyes_mm = X_eyes_model * p_mm;
      // Points next to or behind the head are not drawn.
      constexpr double nearest_mm = 50.0;
      if (eye.position_head_mm.z() - p_eyes_mm.z() > nearest_mm)
        line.points_px.push_back(view::drawn_px(eye, p_eyes_mm));
    }
    if (line.points_px.size() < 2) lines.pop_back();
  }
  return lines;
}

std::vector<DrawnLine> physical_outlines(const Task& task, const BenchFile& bench, const VirtualTruth& truth)
{
  switch (task.kind) {
    case TaskKind::scan_line:
      return visible_border(task, truth);
    case TaskKind::point:
    case TaskKind::grid:
      return physical_grid(task, bench, truth);
    case TaskKind::rectangle_sides:
      return rectangle(task, bench, truth);
    case TaskKind::bullseye:
      return marker(task, bench, truth);
    case TaskKind::depth_check:
      return test_object(truth);
    case TaskKind::model_pose:
      return leg(bench, truth);
    case TaskKind::number:
    case TaskKind::sweep:
    case TaskKind::bend:
    case TaskKind::hold:
    case TaskKind::stop:
      break;
  }
  return {};
}

std::vector<DrawnLine> seen_lines(std::span<const DrawnLine> drawn, const VirtualTruth& truth)
{
  std::vector<DrawnLine> seen;
  for (const DrawnLine& line : drawn) {
    const view::Distortion& optics = view::side_of(truth.calibration.eyes, line.is_right).distortion;
    const VirtualTruth::Edges& edges = truth.edges_px[line.is_right ? 1 : 0];
    for (Line& piece : calibration::pieces_within(with_points_between(line.points_px),
                                                  {{edges.left, edges.top}, {edges.right, edges.bottom}})) {
      for (Eigen::Vector2d& point : piece) point = view::shown_px(optics, point);
      DrawnLine& part = seen.emplace_back(line);
      part.points_px = std::move(piece);
      part.is_smooth = true;  // a scan line's whole pixels are bent by the optics like the edge
    }
  }
  return seen;
}

}  // namespace vrda::calibration
