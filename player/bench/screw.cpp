#include "bench/screw.hpp"

#include <cmath>

#include "model/frames.hpp"
#include "core/trig.hpp"

namespace vrda::bench {
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v)
{
  Eigen::Matrix3d W;
  W << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return W;
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

Pose between(const Pose& X_start, const Pose& X_end, double s)
{
  const Pose X_between = pose_of(scaled(screw_of(X_start.inverse() * X_end), s));
  return X_start * X_between;
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

}  // namespace vrda::bench
