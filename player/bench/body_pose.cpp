#include "bench/body_pose.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/error.hpp"

namespace vrda::bench {
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
