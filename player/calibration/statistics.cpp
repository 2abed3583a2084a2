#include "calibration/statistics.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <string_view>
#include <thread>

#include "calibration/marks.hpp"
#include "calibration/operator.hpp"
#include "calibration/parts.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::calibration {
namespace {

struct BenchResult {
  bool was_refused = false;
  std::vector<NumberStatistics> numbers;  ///< each of one estimate
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
    const Estimate& estimate = *record.estimate;
    const Eigen::VectorXd errors = errors_of(estimate, truth);
    for (Eigen::Index k = 0; k < errors.size(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      const double half_width = bench::half_width_95(estimate, k);
      result.numbers.push_back({bench::name_of(part), estimate.names[i], estimate.units[i], 1,
                                std::abs(errors[k]) <= half_width ? 1 : 0, errors[k] * errors[k],
                                half_width});
    }
  }
}

/// A part with everything that it depends on, in the order of execution.
std::vector<CalibrationPart> with_dependencies(CalibrationPart part, const BenchFile& bench)
{
  std::vector<CalibrationPart> parts;
  for (const CalibrationPart below : dependencies_of(part, bench)) {
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
  CalibrationSessionOptions options;
  options.joint = run.joint;
  options.parts =
      run.joint ? with_dependencies(CalibrationPart::functional, bench) : parts_of_step("all", bench);
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
  for (const NumberStatistics& number : result.numbers) {
    const auto is_same = [&](const NumberStatistics& s) {
      return s.part == number.part && s.name == number.name;
    };
    auto at = std::ranges::find_if(statistics.numbers, is_same);
    if (at == statistics.numbers.end()) {
      statistics.numbers.push_back(number);
      continue;
    }
    ++at->n;
    at->n_within += number.n_within;
    // Sums; divided at the end.
    at->rms_error += number.rms_error;
    at->mean_half_width += number.mean_half_width;
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
  JointError error;
  for (const CalibrationPart part : {CalibrationPart::femur, CalibrationPart::tibia}) {
    const Pose X_true = X_body_model(truth.calibration, role_of(part));
    const auto add = [&](CalibrationPart by, double& sum_mm) {
      const Pose X_found = pose_in(*found.records.at(by).estimate, bench::name_of(part));
      sum_mm = std::hypot(sum_mm, std::sqrt(0.5) * joint_error_mm(X_found, X_true, centre_mm));
    };
    add(part, error.by_landmarks_mm);
    add(CalibrationPart::functional, error.functional_mm);
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
  const view::ShownBox& edges = truth.edges_px[is_right ? 1 : 0];
  if (name == "edge_left") return edges.low_px.x();
  if (name == "edge_right") return edges.high_px.x();
  if (name == "edge_top") return edges.low_px.y();
  if (name == "edge_bottom") return edges.high_px.y();
  check(name == "depth", "no true value for a parameter of an eye");
  const view::Eye& eye = view::side_of(truth.calibration.eyes, is_right);
  return (bench::pose_of(truth.calibration.X_table_eyes) * eye.position_head_mm).z() -
         truth.reference_plane_table_mm;
}

/// Of the bench's parameters by their names, and of what only a calibration has.
double true_number(const VirtualTruth& truth, const bench::BenchValues& values, const std::string& name)
{
  const Calibration& c = truth.calibration;
  const Eigen::Vector3d apart_mm = c.eyes.right.position_head_mm - c.eyes.left.position_head_mm;
  if (const std::optional<std::size_t> parameter = bench::find_parameter(name))
    return bench::value_of(values, *parameter);
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
    if (name == bench::name_of(role)) return &c.X_body_model[role];
  }
  return nullptr;
}

/// mm and degrees: translation error, and rotation error about the fixed axes.
Eigen::Matrix<double, 6, 1> pose_error(std::span<const double> found, const bench::PoseParameters& truth)
{
  const bench::PoseParameters six = bench::pose_parameters_of(found);
  const Eigen::Matrix3d R_wanted = bench::pose_of(truth).linear() * bench::pose_of(six).linear().transpose();
  Eigen::Matrix<double, 6, 1> error;
  error.head<3>() = six.shift_mm - truth.shift_mm;
  error.tail<3>() = -bench::turn_of(R_wanted) / rad_from_deg(1.0);
  return error;
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

Eigen::VectorXd errors_of(const Estimate& estimate, const VirtualTruth& truth)
{
  Eigen::VectorXd errors(estimate.values.size());
  bench::BenchValues values;
  values.calibration = truth.calibration;
  Eigen::Index k = 0;
  while (k < errors.size()) {
    const std::string& name = estimate.names[static_cast<std::size_t>(k)];
    const std::size_t dot = name.find(".shift_x");
    const bench::PoseParameters* place =
        dot == std::string::npos ? nullptr : true_pose(truth, name.substr(0, dot));
    if (place) {
      errors.segment<6>(k) = pose_error({&estimate.values[k], 6}, *place);
      k += 6;
    } else {
      errors[k] = estimate.values[k] - true_number(truth, values, name);
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
  const Calibration& real = truth.calibration;
  const Pose X_table_model =
      bench::pose_of(real.X_tracker_table).inverse() * X_tracker_body(truth, role) * X_body_model(real, role);
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
  const double stage_mm = std::round(standing.stage_mm / bench.stage_mm_per_count) * bench.stage_mm_per_count;
  const Pose X_tracker_eyes_found = bench.head == HeadKind::stage
                                        ? X_tracker_eyes(found, stage_mm)
                                        : X_headbody_seen * bench::pose_of(found.X_headbody_eyes);
  const Pose X_model_table = X_table_model.inverse();
  std::vector<TargetError> errors;
  for (int k = 0; k < 20; ++k) {
    // The corners, and three more along each vertical edge.
    const int height = k / 4 - 2;
    const bool is_left = k % 2 == 0, is_behind = k / 2 % 2 == 0;
    const Eigen::Vector3d off_mm(is_left ? -80.0 : 80.0, 60.0 * height, is_behind ? -60.0 : 60.0);
    const Eigen::Vector3d p_leg_mm = X_model_table * (X_table_model.translation() + off_mm);
    const Eigen::Vector3d p_true_mm =
        standing.X_tracker_eyes.inverse() * X_tracker_body(truth, role) * X_body_model(real, role) * p_leg_mm;
    const Eigen::Vector3d p_found_mm = X_tracker_eyes_found.inverse() * X_body_seen *
                                       X_body_model(found, role) *
                                       (found.subject_scale / real.subject_scale * p_leg_mm);
    for (const bool is_right : {false, true}) {
      errors.push_back(error_for_eye(view::side_of(found.eyes, is_right), p_found_mm,
                                     view::side_of(real.eyes, is_right), p_true_mm));
    }
  }
  return errors;
}

}  // namespace vrda::calibration
