/// Ways round an ellipsoid within a plane: close to the shortest one, and where the search for it starts.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <limits>

#include "core/trig.hpp"

namespace vrda {

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
