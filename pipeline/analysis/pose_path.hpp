/// Rotation vectors, and a sequence of poses as the measurement plus a twist a frame in units of the
/// measurement's noise.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "model/frames.hpp"

namespace vrda::analysis {

using Vector6d = Eigen::Matrix<double, 6, 1>;  ///< rotations, then translations
using Matrix6d = Eigen::Matrix<double, 6, 6>;

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v);
/// The rotation by |v| (rad) about v.
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& v);
/// Inverse of rotation_of for rotations below pi - 1e-6.
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& R);

/// Standard deviations of the errors of a measured pose: a small rotation about the canonical axes of the
/// reference, and the displacement along them of the moving object's point that lies at the rotation centre
/// in the zero pose. Errors of different frames and axes are independent. 0: exact, the coordinate is kept.
struct MeasurementNoise {
  Eigen::Vector3d rotation_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d translation_mm = Eigen::Vector3d::Zero();
};

/// Maps between twists in S and in units of the noise, whose norm is the Mahalanobis distance.
struct NoiseScale {
  Eigen::Matrix3d rotation, translation;                  ///< S from units of the noise
  Eigen::Matrix3d inverse_rotation, inverse_translation;  ///< zero rows for exact coordinates
};
NoiseScale noise_scale(const SolverFrame& frame, const MeasurementNoise& noise);

/// X (moving to reference, S at zero attitude) displaced by `twist`, in units of the noise: the rotation is
/// multiplied from the left, the translation of the origin added.
Pose displaced(const Pose& X_measured, const Vector6d& twist, const NoiseScale& scale);

/// d(left rotation of the displaced pose) / d(rotation part of the twist), S from units of the noise.
/// Expansion of the left Jacobian of SO(3); the error is the third power of the angle / 24.
Eigen::Matrix3d turn_per_twist(const Vector6d& twist, const NoiseScale& scale);

}  // namespace vrda::analysis
