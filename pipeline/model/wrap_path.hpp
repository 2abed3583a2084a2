/// The shortest path between two points around a wrapping surface, in the surface's own frame.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>

#include "core/trig.hpp"

namespace vrda::inline model {

struct WrapPath {
  bool is_wrapped = false;  ///< false: the path is straight; the other members are unset
  double length_mm = 0.0;
  /// Unit, along the last free segment from the surface to the end: derivative of the length over the end.
  Eigen::Vector3d end_direction = Eigen::Vector3d::Zero();
  /// Second derivatives of the length over the end, 1/mm. The free segment rolls on the surface: in the plane
  /// of the surface normal the value is 1 / its length; across that plane it follows the divergence of
  /// neighbouring geodesics.
  Eigen::Matrix3d bending = Eigen::Matrix3d::Zero();
  /// First point on the surface, unit direction there, and length of the arc on the surface.
  Eigen::Vector3d touch_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d start_direction = Eigen::Vector3d::Zero();
  double arc_mm = 0.0;
};

/// Around a cylinder along Z, on the shorter side: a helix between two tangents, in closed form. Not wrapped
/// when a point is inside the infinite cylinder, or when both ends of the arc are beyond the same end of the
/// cylinder.
WrapPath cylinder_path(const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm, double radius_mm,
                       double half_length_mm);

/// Around an ellipsoid: a geodesic between two tangents, the shortest found from initial planes around the
/// straight line. Not wrapped when a point is inside. The length is accurate to 1e-8 mm for lengths of tens
/// of mm and half-axes up to 5 : 1; for flatter shapes the result may be a longer geodesic or a planar path.
WrapPath ellipsoid_path(const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm,
                        const Eigen::Vector3d& half_axes_mm);

/// The point on a cylinder or an ellipsoid at arc length `along_mm` from the first tangent point; to 1e-8 mm.
Eigen::Vector3d cylinder_point_mm(const WrapPath& path, double along_mm, double radius_mm);
Eigen::Vector3d ellipsoid_point_mm(const WrapPath& path, double along_mm,
                                   const Eigen::Vector3d& half_axes_mm);

/// A point of a geodesic with its Jacobi field. Positions are scaled to the unit sphere: q = p / half-axes.
struct GeodesicState {
  Eigen::Vector3d q = Eigen::Vector3d::Zero();
  Eigen::Vector3d q_slope = Eigen::Vector3d::Zero();  ///< derivative over the length, 1/mm
  double width = 0.0;                                 ///< Jacobi field: distance of a neighbouring geodesic
  double width_slope = 0.0;
};

/// Integrates the geodesic by `length_mm`, backwards if negative. With q scaled and Joachimsthal's invariant
/// C the equation is q'' = -C w^-2 q / a^2 with w = sum of q^2 / a^2; the width follows Jacobi's equation.
/// `step_rad` is the largest angle a step; the method is of fifth order.
GeodesicState integrate_geodesic(const GeodesicState& from, double length_mm,
                                 const Eigen::Vector3d& half_axes_mm, double step_rad);

/// Two points outside an ellipsoid, scaled so that it is the unit sphere (q = p / half-axes), and the
/// straight line between them.
struct WrapProblem {
  Eigen::Vector3d half_axes_mm = Eigen::Vector3d::Ones();
  Eigen::Vector3d start, end;  ///< scaled
  Eigen::Vector3d along;       ///< unit, from start to end
  Eigen::Vector3d outward;     ///< unit, from the centre to the line's nearest point
  Eigen::Vector3d sideways;    ///< unit, completing the axes
  double depth = 0.0;          ///< distance of the line from the centre, below 1

  Eigen::Vector3d mm(const Eigen::Vector3d& q) const { return half_axes_mm.cwiseProduct(q); }
};

/// Computes `along` and the members after it. False when the straight line misses the ellipsoid.
bool set_straight_line(WrapProblem& scene);

/// A unit vector perpendicular to a unit vector; deterministic.
Eigen::Vector3d any_perpendicular(const Eigen::Vector3d& unit);

/// A planar path: tangent, arc, tangent.
struct PlanarPath {
  double length_mm = std::numeric_limits<double>::infinity();
  Eigen::Vector3d touch = Eigen::Vector3d::Zero();  ///< scaled
  Eigen::Vector3d leave = Eigen::Vector3d::Zero();
  double arc_mm = 0.0;  ///< by chords, one percent too short
};

/// The path in the half-plane bounded by the straight line, rotated by `tilt` from `outward` to `sideways`.
PlanarPath planar_path(const WrapProblem& scene, const SinCos& tilt);

}  // namespace vrda::inline model
