/// What a tracker calls a rotation, made one.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace vrda {

/// Largest entry of R^T R - I, and of |q|^2 - 1, that passes as rounding: matrices written with three
/// decimals (each entry off by 5e-4, a column's length and products by 2 sqrt(3) of that) do, a scale of 0.1
/// % does not.
constexpr double most_rotation_error = 1.8e-3;

/// The rotation nearest to the matrix, nothing where it is farther from one than that, mirrored or not
/// finite.
std::optional<Eigen::Matrix3d> nearest_rotation(const Eigen::Matrix3d& matrix);

/// The quaternion (w, x, y, z) made of unit length, nothing likewise.
std::optional<Eigen::Quaterniond> unit_quaternion(const Eigen::Vector4d& wxyz);

}  // namespace vrda
