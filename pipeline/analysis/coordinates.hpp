/// The six numbers of a pose that are scored, and the pose of six numbers (schemas/clinical.md).
#pragma once

#include <array>
#include <optional>

#include "model/clinical.hpp"

namespace vrda::analysis {

/// The translations of the coordinates.
enum class Translations {
  rotation_centre,  ///< of the rotation centre along the Grood-Suntay axes: anterior, proximal, lateral
  mesh_origin,      ///< of the moving meshes' origin along the reference's axes: ant, prox, lat of an export
};

/// What the numbers of a pose depend on.
struct Convention {
  Side side = Side::right;
  Eigen::Vector3d rotation_centre_mm = Eigen::Vector3d::Zero();  ///< canonical, joint's own side
  Translations translations = Translations::rotation_centre;
  /// Unit, canonical, joint's own side: the axes are turned by the shortest rotation from this direction to
  /// +Y, as for a Delta of this direction. Empty: the joint's own axes.
  std::optional<Eigen::Vector3d> long_axis = std::nullopt;
};

/// flexion, varus, internal rotation (rad), anterior, proximal, lateral (mm); signs of core/clinical.hpp.
using Coordinates = std::array<double, 6>;
inline constexpr std::size_t n_scored = 6, n_angles = 3;
/// Indices of Coordinates.
inline constexpr std::size_t at_flexion = 0, at_varus = 1, at_internal = 2;

struct CoordinateName {
  const char* name;
  const char* unit;  ///< outside the program
};
inline constexpr std::array<CoordinateName, n_scored> coordinate_names{{{"flexion", "degree"},
                                                                        {"varus", "degree"},
                                                                        {"internal", "degree"},
                                                                        {"anterior", "mm"},
                                                                        {"proximal", "mm"},
                                                                        {"lateral", "mm"}}};

Coordinates coordinates_of(const Pose& X_reference_moving, const Convention& convention);

/// The convention of the same joint reflected to a right one. Coordinates do not change.
Convention right_sided(Convention convention);

/// The pose X_reference_moving with these coordinates, of the joint reflected to a right one if it is left.
Pose right_sided_pose(const Coordinates& value, const Convention& convention);

/// A rigid transform of canonical coordinates, reflected in the sagittal plane.
Pose reflected(const Pose& X);

}  // namespace vrda::analysis
