/// The shortest way between two points round a wrapping surface, in the surface's own frame.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace vrda {

struct WrapPath {
  bool is_wrapped = false;  ///< false: the straight line is free, or the wrap does not act; the rest is empty
  double length_mm = 0.0;
  /// Unit, along the last free segment from the surface to the end: the derivative of the length over the
  /// end.
  Eigen::Vector3d arrival = Eigen::Vector3d::Zero();
  /// Second derivatives of the length over the end, 1/mm. The free segment rolls on the surface, so it bends
  /// by one over its own length in the plane of the surface's normal; across that plane, neighbouring ways
  /// part as geodesics do.
  Eigen::Matrix3d bending = Eigen::Matrix3d::Zero();
  /// Where the way comes to the surface, its unit direction there, and how long it stays.
  Eigen::Vector3d touch_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d departure = Eigen::Vector3d::Zero();
  double arc_mm = 0.0;
};

/// Round a cylinder along Z, on the shorter side: a helix between two tangents, in closed form. Does not act
/// when a point lies inside the endless cylinder, nor when the way would leave the surface beyond the same
/// end of it as it arrived there.
WrapPath cylinder_path(const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm, double radius_mm,
                       double half_length_mm);

/// Round an ellipsoid: a geodesic between two tangents, the shortest of those found from planes all round the
/// straight line. Does not act when a point lies inside. Length exact to 1e-8 mm of tens, for half-axes up to
/// five to one; of flatter ones the shortest way may be missed, at worst for one within a plane.
WrapPath ellipsoid_path(const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm,
                        const Eigen::Vector3d& half_axes_mm);

/// The point of a way round a cylinder or an ellipsoid, `along_mm` on from where it came to the surface; to
/// 1e-8 mm.
Eigen::Vector3d cylinder_point_mm(const WrapPath& path, double along_mm, double radius_mm);
Eigen::Vector3d ellipsoid_point_mm(const WrapPath& path, double along_mm,
                                   const Eigen::Vector3d& half_axes_mm);

}  // namespace vrda
