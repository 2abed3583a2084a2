// A tracked body's marker positions from frames in which the markers were seen.
#include "bench/rigid_body.hpp"

#include <Eigen/SVD>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "core/units.hpp"
#include "model/coordinates.hpp"

namespace vrda::bench {
namespace {

/// Current estimate of the shape; markers not yet known are excluded.
struct Shape {
  RigidBody body;
  std::vector<bool> is_known;
};

/// The markers of a frame that are known in the shape.
MarkerRow known_part(const Shape& shape, const MarkerRow& frame)
{
  MarkerRow part = frame;
  for (std::size_t k = 0; k < part.size(); ++k) {
    if (!shape.is_known[k]) part[k].reset();
  }
  return part;
}

/// Disables outlier rejection while the shape is estimated.
FitOptions options_without_outliers(const BodyOptions& options)
{
  FitOptions fit;
  fit.least_spread_mm = options.least_spread_mm;
  fit.outlier_mm = std::numeric_limits<double>::infinity();
  return fit;
}

int n_seen(const MarkerRow& row)
{
  return static_cast<int>(std::ranges::count_if(row, [](const auto& p) { return p.has_value(); }));
}

RigidBody body_of(const MarkerRow& row)
{
  RigidBody body;
  body.markers_mm = Points::Zero(static_cast<Eigen::Index>(row.size()), 3);
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (row[k]) body.markers_mm.row(static_cast<Eigen::Index>(k)) = row[k]->transpose();
  }
  return body;
}

std::string text_of(const MarkerCloud& cloud)
{
  return std::to_string(cloud.n) + " markers, second singular value " + short_decimal(cloud.spread_mm(1), 3) +
         " mm";
}

void require_frames(const std::vector<MarkerRow>& frames, const std::string& file)
{
  if (frames.empty()) throw FitError({file, "frames", "none", "one or more"});
  const std::size_t n = frames.front().size();
  if (n < 3 || n > static_cast<std::size_t>(max_markers)) {
    throw FitError({file, "markers", std::to_string(n), "3 to " + std::to_string(max_markers)});
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string field = "frame " + std::to_string(i + 1);
    if (frames[i].size() != n) {
      throw FitError({file, field, std::to_string(frames[i].size()) + " markers", std::to_string(n)});
    }
    for (const auto& marker : frames[i]) {
      if (marker && !(marker->cwiseAbs().maxCoeff<Eigen::PropagateNaN>() < farthest_mm)) {
        throw FitError({file, field, "a coordinate not finite or above 1 km", "mm"});
      }
    }
  }
}

/// The frame with the most visible markers among those that are not collinear; the first of equals.
Shape first_shape(const std::vector<MarkerRow>& frames, const std::string& file, const BodyOptions& options)
{
  const MarkerRow* best = nullptr;
  MarkerCloud widest;
  for (const MarkerRow& frame : frames) {
    const MarkerCloud cloud = cloud_of(body_of(frame), frame);
    if (cloud.n >= 3 && (widest.n < 3 || cloud.spread_mm(1) > widest.spread_mm(1))) widest = cloud;
    if (cloud.n < 3 || cloud.spread_mm(1) < options.least_spread_mm) continue;
    if (!best || cloud.n > n_seen(*best)) best = &frame;
  }
  if (!best && widest.n < 3) {
    throw FitError({file, "markers", "no frame with three visible markers", "three or more in a frame"});
  }
  if (!best) {
    throw FitError(
        {file, "markers", "collinear: at best " + text_of(widest),
         "a second singular value of " + short_decimal(options.least_spread_mm, 3) + " mm or more"});
  }
  Shape shape{body_of(*best), {}};
  for (const auto& marker : *best) shape.is_known.push_back(marker.has_value());
  return shape;
}

std::vector<PoseFit> fits_of(const std::vector<MarkerRow>& frames, const Shape& shape,
                             const FitOptions& options)
{
  std::vector<PoseFit> fits;
  fits.reserve(frames.size());
  for (const MarkerRow& frame : frames)
    fits.push_back(fit_pose(shape.body, known_part(shape, frame), options));
  return fits;
}

/// Mean position of each marker over the fitted frames.
Shape mean_shape(const std::vector<MarkerRow>& frames, const std::vector<PoseFit>& fits, const Shape& before)
{
  Shape shape = before;
  for (std::size_t k = 0; k < shape.is_known.size(); ++k) {
    Eigen::Vector3d sum_mm = Eigen::Vector3d::Zero();
    int n = 0;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (!frames[i][k] || fits[i].status != FitStatus::fitted) continue;
      sum_mm += fits[i].X_tracker_body.inverse() * *frames[i][k];
      ++n;
    }
    if (n == 0) continue;
    shape.body.markers_mm.row(static_cast<Eigen::Index>(k)) = sum_mm.transpose() / n;
    shape.is_known[k] = true;
  }
  return shape;
}

double largest_step_mm(const Shape& before, const Shape& after)
{
  double largest = 0.0;
  for (Eigen::Index k = 0; k < after.body.markers_mm.rows(); ++k) {
    if (before.is_known[static_cast<std::size_t>(k)] != after.is_known[static_cast<std::size_t>(k)])
      return std::numeric_limits<double>::infinity();
    largest = std::max(largest, (after.body.markers_mm.row(k) - before.body.markers_mm.row(k)).norm());
  }
  return largest;
}

void require_all_known(const Shape& shape, const std::vector<MarkerRow>& frames, const std::string& file)
{
  for (std::size_t k = 0; k < shape.is_known.size(); ++k) {
    if (shape.is_known[k]) continue;
    const auto n = std::ranges::count_if(frames, [&](const MarkerRow& f) { return f[k].has_value(); });
    throw FitError({file, "marker " + std::to_string(k + 1),
                    "seen in " + std::to_string(n) + " frames, never with three known, not collinear",
                    "a frame that shows it with three known markers"},
                   {k});
  }
}

/// X first to second marker, Y towards the first that is at least half as far from that line as the furthest.
Pose own_frame(const RigidBody& body, const std::string& file)
{
  const Points& p = body.markers_mm;
  const Eigen::Vector3d first = p.row(0).transpose();
  const Eigen::Vector3d along = p.row(1).transpose() - first;
  // If two markers coincide, noise would determine the axis.
  if (along.norm() < least_spread_mm) {
    throw FitError({file, "markers 1 and 2", short_decimal(along.norm(), 3) + " mm apart",
                    short_decimal(least_spread_mm, 3) + " mm or more, or given coordinates of the markers"},
                   {0, 1});
  }
  const Eigen::Vector3d x = along.normalized();
  std::vector<Eigen::Vector3d> across;
  double furthest_mm = 0.0;
  for (Eigen::Index k = 0; k < p.rows(); ++k) {
    const Eigen::Vector3d from_first = p.row(k).transpose() - first;
    across.emplace_back(from_first - x.dot(from_first) * x);
    furthest_mm = std::max(furthest_mm, across.back().norm());
  }
  const auto third =
      std::ranges::find_if(across, [&](const Eigen::Vector3d& v) { return v.norm() >= 0.5 * furthest_mm; });
  Pose X_shape_body = Pose::Identity();
  const Eigen::Vector3d y = third->normalized();
  X_shape_body.linear() << x, y, x.cross(y);
  X_shape_body.translation() = p.colwise().mean().transpose();
  return X_shape_body;
}

/// Transforms the shape to the requested frame; returns the RMS distance from given coordinates.
double move_to_frame(RigidBody& body, const std::string& file, const BodyOptions& options)
{
  Pose X_body_shape = Pose::Identity();
  double wanted_rms_mm = 0.0;
  if (options.given_mm.empty()) {
    X_body_shape = own_frame(body, file).inverse();
  } else {
    if (options.given_mm.size() != static_cast<std::size_t>(body.markers_mm.rows())) {
      throw FitError({file, "coordinates wanted",
                      "of " + std::to_string(options.given_mm.size()) + " markers",
                      "an entry for each of " + std::to_string(body.markers_mm.rows())});
    }
    const PoseFit fit = fit_pose(body, options.given_mm, options_without_outliers(options));
    if (fit.status != FitStatus::fitted) {
      throw FitError({file, "coordinates wanted", text_of(fit.cloud), "three or more, not collinear"});
    }
    X_body_shape = fit.X_tracker_body;
    wanted_rms_mm = fit.residual_rms_mm;
  }
  for (Eigen::Index k = 0; k < body.markers_mm.rows(); ++k) {
    const Eigen::Vector3d p_shape = body.markers_mm.row(k).transpose();
    body.markers_mm.row(k) = (X_body_shape * p_shape).transpose();
  }
  return wanted_rms_mm;
}

void add_residuals(BuiltBody& built, const std::vector<MarkerRow>& frames, const std::vector<PoseFit>& fits)
{
  built.markers.resize(frames.front().size());
  std::vector<double> sum_sq_mm2(built.markers.size(), 0.0);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const bool is_used = fits[i].status == FitStatus::fitted;
    (is_used ? built.n_frames : built.n_refused) += 1;
    if (!is_used) continue;
    for (std::size_t k = 0; k < built.markers.size(); ++k) {
      if (!frames[i][k]) continue;
      const Eigen::Vector3d p_body = built.body.markers_mm.row(static_cast<Eigen::Index>(k)).transpose();
      sum_sq_mm2[k] += (*frames[i][k] - fits[i].X_tracker_body * p_body).squaredNorm();
      ++built.markers[k].n_frames;
    }
  }
  double all_sq_mm2 = 0.0;
  int n_all = 0;
  for (std::size_t k = 0; k < built.markers.size(); ++k) {
    BuiltMarker& marker = built.markers[k];
    marker.residual_rms_mm = std::sqrt(sum_sq_mm2[k] / marker.n_frames);
    all_sq_mm2 += sum_sq_mm2[k];
    n_all += marker.n_frames;
  }
  built.residual_rms_mm = std::sqrt(all_sq_mm2 / n_all);
}

}  // namespace

BuiltBody build_body(const std::vector<MarkerRow>& frames, const std::string& file,
                     const BodyOptions& options)
{
  require_frames(frames, file);
  const FitOptions fit = options_without_outliers(options);
  Shape shape = first_shape(frames, file, options);
  BuiltBody built;
  for (int iteration = 0; iteration < options.most_iterations; ++iteration) {
    const Shape next = mean_shape(frames, fits_of(frames, shape, fit), shape);
    const double step_mm = largest_step_mm(shape, next);
    shape = next;
    if (step_mm > options.tolerance_mm) continue;
    built.status = BuildStatus::converged;
    break;
  }
  require_all_known(shape, frames, file);
  built.body = shape.body;
  built.given_rms_mm = move_to_frame(built.body, file, options);
  add_residuals(built, frames, fits_of(frames, {built.body, shape.is_known}, fit));
  return built;
}

Pose X_femur_tibia(const LegBodies& bodies, const Pose& X_tracker_thigh, const Pose& X_tracker_shank)
{
  const Pose X_tracker_femur = X_tracker_thigh * bodies.X_thigh_femur;
  const Pose X_tracker_tibia = X_tracker_shank * bodies.X_shank_tibia;
  return X_tracker_femur.inverse() * X_tracker_tibia;
}

LegAngles leg_angles(const Pose& X_femur_tibia, const SolverFrame& frame)
{
  // S is a right knee whose Delta is +Y.
  const Pose X_solver = X_solver_reference_moving(frame, X_femur_tibia);
  const ClinicalCoordinates clinical = clinical_coordinates(X_solver, Side::right, Eigen::Vector3d::Zero());
  return {clinical.flexion_rad, clinical.varus_rad, clinical.internal_rotation_rad};
}

Attitude attitude_of(const LegAngles& angles)
{
  return {angles.flexion_rad, angles.varus_rad};
}

Pose X_femur_tibia(const LegAngles& angles, const SolverFrame& frame, const Eigen::Vector3d& translation_mm)
{
  return X_reference_moving(frame, attitude_of(angles), {translation_mm, angles.theta_rad});
}

namespace {

/// Below this angle two terms of a series are exact to rounding: the third is smaller by angle^4 / 100.
constexpr double small_angle_rad = 1e-4;
/// Below this angle differences of nearly equal terms lose more than three digits; the series does not.
constexpr double series_angle_rad = 0.1;

/// (1 - cos a) / a^2, without cancellation.
double half_square(double angle_rad)
{
  if (angle_rad < small_angle_rad) return 0.5 - angle_rad * angle_rad / 24.0;
  const double half = sine(0.5 * angle_rad) / angle_rad;
  return 2.0 * half * half;
}

/// (a - sin a) / a^3.
double cubic_rest(double angle_rad)
{
  const double square = angle_rad * angle_rad;
  if (angle_rad < series_angle_rad) {
    return (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0 * (1.0 - square / 110.0)))) /
           6.0;
  }
  return (angle_rad - sine(angle_rad)) / (square * angle_rad);
}

/// (1 - (a / 2) cot(a / 2)) / a^2, for a up to pi.
double inverse_rest(double angle_rad)
{
  const double square = angle_rad * angle_rad;
  if (angle_rad < series_angle_rad)
    return (1.0 + square / 60.0 * (1.0 + square / 42.0 * (1.0 + square / 40.0))) / 12.0;
  const SinCos half = sin_cos(0.5 * angle_rad);
  return (1.0 - 0.5 * angle_rad * half.cos / half.sin) / square;
}

}  // namespace

Screw scaled(const Screw& screw, double factor)
{
  return {factor * screw.turn_rad, factor * screw.shift_mm};
}

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& turn_rad)
{
  const double angle_rad = turn_rad.norm();
  const Eigen::Matrix3d W = cross_matrix(turn_rad);
  const double by_sine =
      angle_rad < small_angle_rad ? 1.0 - angle_rad * angle_rad / 6.0 : sine(angle_rad) / angle_rad;
  return Eigen::Matrix3d::Identity() + by_sine * W + half_square(angle_rad) * (W * W);
}

Eigen::Vector3d turn_of(const Eigen::Matrix3d& R)
{
  // By the quaternion: no cancellation at any angle.
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double sin_half = q.vec().norm();
  if (sin_half < small_angle_rad) return q.vec() * (2.0 + sin_half * sin_half / 3.0);
  return q.vec() * (2.0 * arc_tangent2(sin_half, q.w()) / sin_half);
}

Pose pose_of(const Screw& screw)
{
  const double angle_rad = screw.turn_rad.norm();
  const Eigen::Matrix3d W = cross_matrix(screw.turn_rad);
  Pose X = Pose::Identity();
  X.linear() = rotation_of(screw.turn_rad);
  X.translation() = screw.shift_mm + half_square(angle_rad) * (W * screw.shift_mm) +
                    cubic_rest(angle_rad) * (W * (W * screw.shift_mm));
  return X;
}

Screw screw_of(const Pose& pose)
{
  Screw screw;
  screw.turn_rad = turn_of(pose.linear());
  const Eigen::Matrix3d W = cross_matrix(screw.turn_rad);
  const Eigen::Vector3d t = pose.translation();
  screw.shift_mm = t - 0.5 * (W * t) + inverse_rest(screw.turn_rad.norm()) * (W * (W * t));
  return screw;
}

Pose moved(const Pose& X, const Eigen::Matrix<double, 6, 1>& by)
{
  Pose result = X;
  result.translation() += by.head<3>();
  result.linear() = rotation_of(by.tail<3>()) * X.linear();
  return result;
}

double rms_of(std::span<const double> values)
{
  double sum_sq = 0.0;
  for (const double value : values) sum_sq += value * value;
  return values.empty() ? 0.0 : std::sqrt(sum_sq / static_cast<double>(values.size()));
}

Pose between(const Pose& X_start, const Pose& X_end, double s)
{
  const Pose X_between = pose_of(scaled(screw_of(X_start.inverse() * X_end), s));
  return X_start * X_between;
}

PoseParameters pose_parameters_of(std::span<const double> numbers)
{
  check(numbers.size() == 6, "a pose has six numbers");
  return {Eigen::Vector3d::Map(numbers.data()), Eigen::Vector3d::Map(&numbers[3]) * rad_from_deg(1.0)};
}

Pose pose_of(const PoseParameters& numbers)
{
  Pose pose = Pose::Identity();
  pose.linear() =
      rotation_z(numbers.turn_rad.z()) * rotation_y(numbers.turn_rad.y()) * rotation_x(numbers.turn_rad.x());
  pose.translation() = numbers.shift_mm;
  return pose;
}

PoseParameters pose_parameters_of(const Pose& pose)
{
  const Eigen::Matrix3d R = pose.linear();
  PoseParameters six;
  six.shift_mm = pose.translation();
  const double cos_y = std::sqrt(R(0, 0) * R(0, 0) + R(1, 0) * R(1, 0));
  six.turn_rad.y() = arc_tangent2(-R(2, 0), cos_y);
  // At gimbal lock only the sum or difference of the other two angles is defined: x takes all of it.
  constexpr double straight = 1e-12;
  if (cos_y < straight) {
    six.turn_rad.x() = arc_tangent2(-R(1, 2), R(1, 1));
  } else {
    six.turn_rad.x() = arc_tangent2(R(2, 1), R(2, 2));
    six.turn_rad.z() = arc_tangent2(R(1, 0), R(0, 0));
  }
  return six;
}

namespace {

using Mask = std::uint64_t;

constexpr Mask bit_of(Eigen::Index k)
{
  return Mask{1} << static_cast<unsigned>(k);
}

Mask mask_of(const RigidBody& body, MarkerSpan seen)
{
  check(body.markers_mm.rows() <= max_markers, "at most 64 markers per body");
  check(static_cast<std::size_t>(body.markers_mm.rows()) == seen.size(), "one entry per marker");
  Mask mask = 0;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (seen[k] && seen[k]->cwiseAbs().maxCoeff<Eigen::PropagateNaN>() < farthest_mm)
      mask |= bit_of(static_cast<Eigen::Index>(k));
  }
  return mask;
}

/// Calls `use(k)` for each marker in the mask, in order of labels.
template <typename Use>
void for_each(Mask mask, Use use)
{
  for (; mask != 0; mask &= mask - 1) use(std::countr_zero(mask));
}

MarkerCloud cloud_of(const RigidBody& body, Mask mask)
{
  MarkerCloud cloud;
  cloud.n = std::popcount(mask);
  if (cloud.n == 0) return cloud;
  for_each(mask, [&](int k) { cloud.centre_mm += body.markers_mm.row(k).transpose(); });
  cloud.centre_mm /= cloud.n;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for_each(mask, [&](int k) {
    const Eigen::Vector3d from_centre = body.markers_mm.row(k).transpose() - cloud.centre_mm;
    scatter += from_centre * from_centre.transpose();
  });
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(scatter, Eigen::ComputeFullU);
  cloud.axes = svd.matrixU();
  cloud.spread_mm = svd.singularValues().cwiseSqrt();
  return cloud;
}

/// Least-squares rigid transform from the selected markers of the body to the seen positions.
Pose nearest_pose(const RigidBody& body, MarkerSpan seen, Mask mask, const Eigen::Vector3d& centre_body_mm)
{
  Eigen::Vector3d centre_tracker_mm = Eigen::Vector3d::Zero();
  for_each(mask, [&](int k) { centre_tracker_mm += *seen[static_cast<std::size_t>(k)]; });
  centre_tracker_mm /= std::popcount(mask);
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  for_each(mask, [&](int k) {
    const Eigen::Vector3d p_body = body.markers_mm.row(k).transpose() - centre_body_mm;
    H += (*seen[static_cast<std::size_t>(k)] - centre_tracker_mm) * p_body.transpose();
  });
  Pose X = Pose::Identity();
  X.linear() = nearest_rotation(H);
  X.translation() = centre_tracker_mm - X.linear() * centre_body_mm;
  return X;
}

struct Residuals {
  double sum_sq_mm2 = 0.0, largest_sq_mm2 = 0.0;
};

Residuals residuals_of(const RigidBody& body, MarkerSpan seen, Mask mask, const Pose& X_tracker_body)
{
  Residuals residuals;
  for_each(mask, [&](int k) {
    const Eigen::Vector3d p_body = body.markers_mm.row(k).transpose();
    const double sq_mm2 = (*seen[static_cast<std::size_t>(k)] - X_tracker_body * p_body).squaredNorm();
    residuals.sum_sq_mm2 += sq_mm2;
    residuals.largest_sq_mm2 = std::max(residuals.largest_sq_mm2, sq_mm2);
  });
  return residuals;
}

/// Fit of the selected markers without dropping any.
PoseFit fit_of(const RigidBody& body, MarkerSpan seen, Mask mask, const FitOptions& options)
{
  PoseFit fit;
  fit.used = mask;
  fit.cloud = cloud_of(body, mask);
  if (fit.cloud.n < 3) return fit;
  fit.status = FitStatus::collinear;
  if (!(fit.cloud.spread_mm(1) >= options.least_spread_mm)) return fit;
  fit.X_tracker_body = nearest_pose(body, seen, mask, fit.cloud.centre_mm);
  const Residuals residuals = residuals_of(body, seen, mask, fit.X_tracker_body);
  fit.residual_rms_mm = std::sqrt(residuals.sum_sq_mm2 / fit.cloud.n);
  const bool has_outlier = residuals.largest_sq_mm2 > options.outlier_mm * options.outlier_mm;
  fit.status = has_outlier ? FitStatus::residual_too_large : FitStatus::fitted;
  return fit;
}

/// Least number of markers after dropping. Three always fit too well to reject a fourth: one may be
/// anywhere on a circle about the other two.
constexpr int least_agreeing = 4;

/// The best of the fits with one or two of the used markers dropped.
PoseFit fit_dropping(int n_dropped, const RigidBody& body, MarkerSpan seen, const PoseFit& whole,
                     const FitOptions& options)
{
  PoseFit best = whole;
  const auto consider = [&](Mask mask) {
    PoseFit fit = fit_of(body, seen, mask, options);
    const bool is_better = best.status != FitStatus::fitted || fit.residual_rms_mm < best.residual_rms_mm;
    if (fit.status != FitStatus::fitted || !is_better) return;
    fit.n_outliers = n_dropped;
    best = fit;
  };
  for_each(whole.used, [&](int k) {
    const Mask one_less = whole.used & ~bit_of(k);
    if (n_dropped == 1) return consider(one_less);
    // Only larger labels for the second, so that each pair is tried once.
    for_each(one_less & ~(bit_of(k) - 1), [&](int l) { consider(one_less & ~bit_of(l)); });
  });
  return best;
}

}  // namespace

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& H)
{
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(H, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // The last sign prevents a reflection for planar or noisy markers.
  const double sign = svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0;
  return svd.matrixU() * Eigen::Vector3d(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose();
}

const char* name_of(FitStatus status)
{
  return std::array{"fitted", "too_few_markers", "collinear", "residual_too_large"}.at(
      static_cast<std::size_t>(status));
}

MarkerCloud cloud_of(const RigidBody& body, MarkerSpan seen)
{
  return cloud_of(body, mask_of(body, seen));
}

PoseFit fit_pose(const RigidBody& body, MarkerSpan seen, const FitOptions& options)
{
  const PoseFit whole = fit_of(body, seen, mask_of(body, seen), options);
  PoseFit fit = whole;
  for (int n_dropped = 1; n_dropped <= max_outliers; ++n_dropped) {
    if (fit.status != FitStatus::residual_too_large || whole.cloud.n - n_dropped < least_agreeing) break;
    fit = fit_dropping(n_dropped, body, seen, whole, options);
  }
  return fit;
}

PoseError expected_error(const MarkerCloud& cloud, double noise_mm)
{
  check(cloud.n >= 3 && cloud.spread_mm(1) > 0.0, "collinear markers have no error estimate");
  // Information on a rotation about axis i: the sum of squared distances from it, the other two spreads.
  const Eigen::Vector3d square = cloud.spread_mm.cwiseAbs2();
  PoseError error;
  for (int i = 0; i < 3; ++i) error.turn_rad(i) = noise_mm / std::sqrt(square.sum() - square(i));
  error.centre_mm = noise_mm * std::sqrt(3.0 / cloud.n);
  return error;
}

double target_error_mm(const MarkerCloud& cloud, double noise_mm, const Eigen::Vector3d& p_body_mm)
{
  const PoseError error = expected_error(cloud, noise_mm);
  const Eigen::Vector3d along_sq_mm2 = (cloud.axes.transpose() * (p_body_mm - cloud.centre_mm)).cwiseAbs2();
  double sum_sq_mm2 = error.centre_mm * error.centre_mm;
  for (int i = 0; i < 3; ++i)
    sum_sq_mm2 += error.turn_rad(i) * error.turn_rad(i) * (along_sq_mm2.sum() - along_sq_mm2(i));
  return std::sqrt(sum_sq_mm2);
}

double noise_mm(const PoseFit& fit)
{
  check(fit.cloud.n >= 3, "noise_mm needs a fitted pose");
  return fit.residual_rms_mm * std::sqrt(fit.cloud.n / (3.0 * fit.cloud.n - 6.0));
}

namespace {

using FixedRow = std::array<std::optional<Eigen::Vector3d>, max_markers>;

/// Moves each marker back along `velocity` from its firing time to the frame's time.
FixedRow at_frame_time(MarkerSpan seen, const Screw& velocity, double interval_s)
{
  FixedRow row;
  for (std::size_t k = 0; k < seen.size(); ++k) {
    if (seen[k]) row[k] = pose_of(scaled(velocity, -interval_s * static_cast<double>(k))) * *seen[k];
  }
  return row;
}

/// First-order bound on how far a marker of the cloud moves between the two poses.
double step_mm(const MarkerCloud& cloud, const Pose& X_from, const Pose& X_to)
{
  const double turn = (X_to.linear() - X_from.linear()).norm();
  return (X_to * cloud.centre_mm - X_from * cloud.centre_mm).norm() + turn * cloud.spread_mm(0);
}

}  // namespace

FiredFit fit_fired(const RigidBody& body, MarkerSpan seen, double time_s,
                   const std::optional<BodyMotion>& before, const Firing& firing)
{
  check(seen.size() <= max_markers, "at most 64 markers per body");
  FiredFit result;
  const double gap_s = before ? time_s - before->pose.time_s : 0.0;
  const double all_fired_s = firing.interval_s * static_cast<double>(seen.size());
  if (gap_s <= 0.0 || gap_s < all_fired_s || gap_s > firing.longest_gap_s) {
    result.fit = fit_pose(body, seen, firing.fit);
    return result;
  }
  // The pose error is the velocity error times the mean delay; the next velocity error is the pose error
  // over the gap. Each iteration reduces it by the ratio of delay to gap, at most a half since all markers
  // fire within the gap. 40 iterations reduce a millimetre below a picometre; usually few are needed.
  constexpr int most_rounds = 40;
  constexpr double resolution_mm = 1e-9;
  result.velocity = before->velocity;
  for (int round = 0; round < most_rounds; ++round) {
    const FixedRow row = at_frame_time(seen, result.velocity, firing.interval_s);
    const PoseFit fit = fit_pose(body, {row.data(), seen.size()}, firing.fit);
    const bool is_fitted = fit.status == FitStatus::fitted;
    const bool is_settled =
        round > 0 && step_mm(fit.cloud, result.fit.X_tracker_body, fit.X_tracker_body) < resolution_mm;
    result.fit = fit;
    result.is_corrected = is_fitted;
    if (!is_fitted) result.velocity = {};
    if (!is_fitted || is_settled) break;
    result.velocity = scaled(screw_of(fit.X_tracker_body * before->pose.X.inverse()), 1.0 / gap_s);
  }
  return result;
}

}  // namespace vrda::bench
