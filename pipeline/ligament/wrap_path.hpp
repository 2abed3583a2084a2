/// The shortest way between two points round a wrapping surface, in the surface's own frame.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>

#include "core/trig.hpp"

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

/// A point of a geodesic and of its neighbour. Places are scaled to the unit sphere: q = p / half-axes.
struct GeodesicState {
  Eigen::Vector3d q = Eigen::Vector3d::Zero();
  Eigen::Vector3d q_slope = Eigen::Vector3d::Zero();  ///< over the length, 1/mm
  double width = 0.0;                                 ///< distance of a neighbouring geodesic
  double width_slope = 0.0;
};

/// `length_mm` further along the geodesic, backwards where negative. With q scaled, Joachimsthal's invariant
/// C makes it q'' = -C w^-2 q / a^2 where w = sum of q^2 / a^2; the neighbour follows Jacobi's equation.
/// `step_rad` is the largest angle of that problem a step; the method is of fifth order.
GeodesicState advance(const GeodesicState& from, double length_mm, const Eigen::Vector3d& half_axes_mm,
                      double step_rad);

/// Two points outside an ellipsoid, scaled so that it is the unit sphere (q = p / half-axes), and the
/// straight line between them.
struct WrapScene {
  Eigen::Vector3d half_axes_mm = Eigen::Vector3d::Ones();
  Eigen::Vector3d start, end;  ///< scaled
  Eigen::Vector3d along;       ///< unit, from start to end
  Eigen::Vector3d outward;     ///< unit, from the centre to the line's nearest point
  Eigen::Vector3d sideways;    ///< unit, completing the axes
  double depth = 0.0;          ///< distance of the line from the centre, below 1

  Eigen::Vector3d mm(const Eigen::Vector3d& q) const { return half_axes_mm.cwiseProduct(q); }
};

/// Fills in `along` and what follows. False when the straight line is free of the ellipsoid.
bool set_line(WrapScene& scene);

/// A unit vector across a unit vector, the same for the same input.
Eigen::Vector3d any_across(const Eigen::Vector3d& unit);

/// Tangent, arc, tangent.
struct PlaneWay {
  double length_mm = std::numeric_limits<double>::infinity();
  Eigen::Vector3d touch = Eigen::Vector3d::Zero();  ///< scaled
  Eigen::Vector3d leave = Eigen::Vector3d::Zero();
  double arc_mm = 0.0;  ///< by chords, one percent short
};

/// In the half-plane that the straight line bounds, turned by `tilt` from `outward` towards `sideways`.
PlaneWay way_in_plane(const WrapScene& scene, const SinCos& tilt);

}  // namespace vrda
