#include "analysis/pose_path.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "core/trig.hpp"

namespace vrda::analysis {
namespace {

// Below this angle (rad) the next term of each series is below the rounding of a double.
constexpr double small_angle = 1e-4;

Eigen::Vector3d inverse_or_zero(const Eigen::Vector3d& v)
{
  Eigen::Vector3d inverse = Eigen::Vector3d::Zero();
  for (Eigen::Index k = 0; k < 3; ++k) {
    if (v(k) > 0.0) inverse(k) = 1.0 / v(k);
  }
  return inverse;
}

}  // namespace

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v)
{
  Eigen::Matrix3d K;
  K << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return K;
}

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& v)
{
  const double angle_sq = v.squaredNorm(), angle = std::sqrt(angle_sq);
  const SinCos turn = sin_cos(angle);
  const double first = angle < small_angle ? 1.0 - angle_sq / 6.0 : turn.sin / angle;
  const double half_sine = sine(0.5 * angle);
  const double second = angle < small_angle ? 0.5 - angle_sq / 24.0 : 2.0 * half_sine * half_sine / angle_sq;
  const Eigen::Matrix3d K = cross_matrix(v);
  return Eigen::Matrix3d::Identity() + first * K + second * (K * K);
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R)
{
  const Eigen::Vector3d skew(0.5 * (R(2, 1) - R(1, 2)), 0.5 * (R(0, 2) - R(2, 0)), 0.5 * (R(1, 0) - R(0, 1)));
  const double sine_of_angle = skew.norm();
  const double angle = arc_tangent2(sine_of_angle, 0.5 * (R.trace() - 1.0));
  return angle < small_angle ? Eigen::Vector3d(skew * (1.0 + angle * angle / 6.0))
                             : Eigen::Vector3d(skew * (angle / sine_of_angle));
}

NoiseScale noise_scale(const SolverFrame& frame, const MeasurementNoise& noise)
{
  // Column k: axis k of W in S. Reflection of a left joint changes signs of components only, which a standard
  // deviation does not have.
  Eigen::Matrix3d axes;
  SolverFrame right = frame;
  right.side = Side::right;
  if (frame.side == Side::left) right.delta.z() = -right.delta.z();
  for (Eigen::Index k = 0; k < 3; ++k)
    axes.row(k) = world_from_solver(right, Eigen::Vector3d::Unit(k)).transpose();
  return {axes * noise.rotation_rad.asDiagonal(), axes * noise.translation_mm.asDiagonal(),
          inverse_or_zero(noise.rotation_rad).asDiagonal() * axes.transpose(),
          inverse_or_zero(noise.translation_mm).asDiagonal() * axes.transpose()};
}

Pose displaced(const Pose& X_measured, const Vector6d& twist, const NoiseScale& scale)
{
  Pose X = Pose::Identity();
  X.linear() = rotation_of(scale.rotation * twist.head<3>()) * X_measured.linear();
  X.translation() = X_measured.translation() + scale.translation * twist.tail<3>();
  return X;
}

Eigen::Matrix3d turn_per_twist(const Vector6d& twist, const NoiseScale& scale)
{
  const Eigen::Matrix3d K = cross_matrix(scale.rotation * twist.head<3>());
  return (Eigen::Matrix3d::Identity() + 0.5 * K + K * K / 6.0) * scale.rotation;
}

}  // namespace vrda::analysis
