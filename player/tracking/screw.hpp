/// Rigid motions as screws: the tangent in which motions are averaged, scaled and carried on.
#pragma once

#include "core/mesh.hpp"

namespace vrda {

/// A motion whose twist is constant for a time of 1: the point p moves at turn.cross(p) + shift.
struct Screw {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
};
Screw scaled(const Screw& screw, double factor);

/// Where it leads (exponential map).
Pose pose_of(const Screw& screw);
/// The screw that leads there (logarithm), turning by pi at most; of a turn of exactly pi one of the two.
Screw screw_of(const Pose& pose);

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& turn_rad);
/// Rotation vector of length up to pi. `R` must be a rotation to rounding.
Eigen::Vector3d turn_of(const Eigen::Matrix3d& R);

/// `X_start` and the share `s` of the screw that leads to `X_end`.
Pose between(const Pose& X_start, const Pose& X_end, double s);

/// Where something stood, and when.
struct TimedPose {
  double time_s = 0.0;
  Pose X = Pose::Identity();
};

/// Turned about the fixed axes x, then y, then z, then shifted.
struct SixNumbers {
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
};
Pose pose_of(const SixNumbers& numbers);
SixNumbers six_numbers_of(const Pose& pose);

}  // namespace vrda
