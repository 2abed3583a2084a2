/// The six coordinates of a joint after Grood and Suntay (schemas/clinical.md) and their map to a pose.
#pragma once

#include <array>
#include <cstdint>

#include "model/mesh.hpp"

namespace vrda::inline model {

/// Rows of JointCoordinates.
enum class JointCoordinate : std::uint8_t { flexion, varus, internal, anterior, proximal, lateral };
inline constexpr std::size_t n_joint_coordinates = 6;
/// Names in jobs and files.
inline constexpr std::array<const char*, n_joint_coordinates> joint_coordinate_names{
    "flexion", "varus", "internal", "anterior", "proximal", "lateral"};

inline constexpr Eigen::Index row_of(JointCoordinate coordinate)
{
  return static_cast<Eigen::Index>(coordinate);
}
inline constexpr bool is_rotation(std::size_t coordinate)
{
  return coordinate < 3;
}

/// Three angles (rad) and three translations (mm). Signs are those of schemas/clinical.md for both sides.
using JointCoordinates = Eigen::Matrix<double, 6, 1>;

/// Where a coordinate comes from: a grid's axis, an input, or the equilibrium.
enum class CoordinateRole : std::int8_t { driven = 0, given = 1, free = 2 };
const char* name_of(CoordinateRole role);

/// Axes that belong to the coordinates, columns in the reference's frame (right side): anterior (floating),
/// proximal (of the moving object) and across both.
Eigen::Matrix3d floating_axes(const JointCoordinates& coordinates);

/// Translation of the rotation centre's moving point along floating_axes(), mm. Undefined at a varus of 90
/// degrees.
Eigen::Vector3d floating_translation_mm(const JointCoordinates& coordinates);

/// Pose of the moving object in the reference's frame: right side, both centred on the rotation centre. The
/// inverse of clinical_coordinates().
Pose joint_pose(const JointCoordinates& coordinates);

/// The coordinates of such a pose.
JointCoordinates joint_coordinates(const Pose& X_reference_moving);

}  // namespace vrda::inline model
