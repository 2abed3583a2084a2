#include "calibration/pivot_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "settings/settings_text.hpp"
#include "tracking/fit_refusal.hpp"

namespace vrda {
namespace {

constexpr std::size_t least_poses = 20;
constexpr double least_spread_rad = rad_from_deg(10.0);
constexpr double most_rms_mm = 2.0;

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix36 = Eigen::Matrix<double, 3, 6>;

/// How far directions of the probe swing from their mean: of a cone, its half angle.
double spread_of(std::span<const Pose> X_tracker_probe)
{
  Eigen::Matrix3d mean = Eigen::Matrix3d::Zero();
  for (const Pose& X : X_tracker_probe) mean += X.linear();
  mean /= static_cast<double>(X_tracker_probe.size());
  // The mean of (R_i - mean)^T (R_i - mean): with v on both sides the mean square way of v's tip.
  const Eigen::Matrix3d swing = Eigen::Matrix3d::Identity() - mean.transpose() * mean;
  const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(swing).eigenvalues()(0);
  return std::asin(std::sqrt(std::clamp(least, 0.0, 1.0)));
}

/// Of tip and pivot: R tip + t - pivot.
Matrix36 row_of(const Pose& X)
{
  Matrix36 row;
  row << X.linear(), -Eigen::Matrix3d::Identity();
  return row;
}

/// What noise that is the same in the probe's axes at every pose does to tip and pivot. Not simply the
/// residuals' mean square: a turn of the probe moves the tip across the shaft, never along it.
Matrix6 covariance_of(std::span<const Pose> X_tracker_probe, const Vector6& found, const Matrix6& inverse)
{
  Eigen::Matrix3d noise_probe = Eigen::Matrix3d::Zero();
  for (const Pose& X : X_tracker_probe) {
    const Eigen::Vector3d left_probe = X.linear().transpose() * (row_of(X) * found + X.translation());
    noise_probe += left_probe * left_probe.transpose();
  }
  noise_probe /= static_cast<double>(X_tracker_probe.size()) - 2.0;  // six numbers of three coordinates
  Matrix6 sum = Matrix6::Zero();
  for (const Pose& X : X_tracker_probe) {
    const Matrix36 in_probe = X.linear().transpose() * row_of(X);
    sum += in_probe.transpose() * noise_probe * in_probe;
  }
  return inverse * sum * inverse;
}

}  // namespace

PivotFit fit_pivot(std::span<const Pose> X_tracker_probe, const std::string& file)
{
  const std::size_t n = X_tracker_probe.size();
  if (n < least_poses) {
    throw FitRefusal({file, "probe", std::to_string(n) + " poses", std::to_string(least_poses) + " or more"});
  }
  PivotFit fit;
  fit.spread_rad = spread_of(X_tracker_probe);
  if (!(fit.spread_rad >= least_spread_rad)) {
    throw FitRefusal(
        {file, "probe",
         "swings of " + rounded_text(deg_from_rad(fit.spread_rad), 1) +
             " deg (rms) about the axis that the probe turned about least",
         rounded_text(deg_from_rad(least_spread_rad), 0) +
             " deg or more: rest the tip and tilt the probe to all sides, by 40 deg from one to the other"});
  }
  Matrix6 N = Matrix6::Zero();
  Vector6 b = Vector6::Zero();
  for (const Pose& X : X_tracker_probe) {
    N += row_of(X).transpose() * row_of(X);
    b -= row_of(X).transpose() * X.translation();
  }
  const Matrix6 inverse = N.ldlt().solve(Matrix6::Identity());
  const Vector6 found = inverse * b;
  fit.tip_probe_mm = found.head<3>();
  fit.pivot_tracker_mm = found.tail<3>();
  std::vector<double> left_mm;
  for (const Pose& X : X_tracker_probe) left_mm.push_back((row_of(X) * found + X.translation()).norm());

  Estimate& estimate = fit.estimate;
  estimate.names = {"probe.tip_x", "probe.tip_y", "probe.tip_z"};
  estimate.units = {"mm", "mm", "mm"};
  estimate.values = fit.tip_probe_mm;
  estimate.covariance = covariance_of(X_tracker_probe, found, inverse).topLeftCorner<3, 3>();
  estimate.dof = static_cast<double>(n) - 2.0;
  set_residuals(estimate, left_mm, "mm");
  if (!(estimate.residual_rms <= most_rms_mm)) {
    throw FitRefusal({file, "probe",
                      "a tip that moves by " + rounded_text(estimate.residual_rms, 2) + " mm (rms)",
                      rounded_text(most_rms_mm, 0) + " mm at most: it slipped; rest it in a hole and again"});
  }
  estimate.remarks.push_back(
      "the probe swung by " + rounded_text(deg_from_rad(fit.spread_rad), 0) +
      " deg (rms) about the axis it turned about least; " + rounded_text(deg_from_rad(least_spread_rad), 0) +
      " are wanted; its tip stayed within " + rounded_text(estimate.residual_rms, 2) + " mm (rms)");
  return fit;
}

}  // namespace vrda
