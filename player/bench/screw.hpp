/// Rigid motions as screws: the tangent space in which motions are averaged, scaled and extrapolated.
#pragma once

#include "model/mesh.hpp"

namespace vrda::bench {

/// A constant twist over unit time: the velocity of point p is turn.cross(p) + shift.
struct Screw {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
};
Screw scaled(const Screw& screw, double factor);

/// The matrix of the cross product: cross_matrix(v) * w = v x w.
Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);

/// Exponential map.
Pose pose_of(const Screw& screw);
/// Logarithm, with a rotation of at most pi; for exactly pi one of the two solutions.
Screw screw_of(const Pose& pose);

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& turn_rad);
/// Rotation vector of length up to pi. `R` must be a rotation to rounding.
Eigen::Vector3d turn_of(const Eigen::Matrix3d& R);

/// Interpolates along the screw from `X_start` to `X_end`, at fraction `s`.
Pose between(const Pose& X_start, const Pose& X_end, double s);

/// A pose and its time.
struct TimedPose {
  double time_s = 0.0;
  Pose X = Pose::Identity();
};

/// Rotation about the fixed axes x, then y, then z, followed by a translation.
struct PoseParameters {
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
};
Pose pose_of(const PoseParameters& numbers);
PoseParameters pose_parameters_of(const Pose& pose);

}  // namespace vrda::bench
