/// A hip-like pair: a spherical head with a neck, pushed up into a deep socket. Origin: the socket's centre.
#pragma once

#include "geometry/shapes.hpp"

namespace vrda::geometry {

struct HipParameters {
  double resolution = 1.0;       ///< factor on the number of edges along a line
  double radius_mm = 24.0;       ///< of the head
  double clearance_mm = 0.5;     ///< inner radius of the socket minus radius of the head
  double wall_mm = 6.0;          ///< the socket's thickness
  double depth_mm = 2.0;         ///< distance of the socket's rim beyond its centre, towards the opening
  double neck_deg = 45.0;        ///< angle of the neck from -Y, towards the subject's right
  double neck_ratio = 2.0;       ///< radius of the head over that of the neck
  double inclination_deg = 0.0;  ///< angle of the socket's opening from -Y, towards the subject's right
  double anteversion_deg = 0.0;  ///< then of the opening towards anterior
};

/// Reference "socket", moving "head"; generated concentric without contact. Pushed up, the head is in
/// equilibrium with its centre at (0, clearance, 0). The neck meets the rim where its axis is
/// 90 degrees - asin(1 / neck_ratio) from that of the opening, for a depth of 0 and no wall. Throws
/// InputError when the socket's rim is too narrow for the head to enter, or too shallow.
Shape hip(const HipParameters& plan);

}  // namespace vrda::geometry
