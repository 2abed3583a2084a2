/// A hip-like pair: a ball on a neck pushed up into a deep socket. Origin: the socket's centre.
#pragma once

#include "shapes/shapes.hpp"

namespace vrda {

struct HipPlan {
  double resolution = 1.0;    ///< multiplies the edges along any line
  double radius_mm = 24.0;    ///< of the head
  double clearance_mm = 0.5;  ///< the socket's inner radius less the head's
  double wall_mm = 6.0;       ///< the socket's thickness
  double depth_mm = 2.0;      ///< how far the socket's rim reaches below its centre
  double neck_deg = 45.0;     ///< lean of the neck from straight down, towards the subject's right
};

/// Reference "socket", moving "head"; generated concentric, so nothing touches. Pushed up, the head rests
/// with its centre at (0, clearance, 0). Throws InputError when the socket's rim is too narrow for the head
/// to enter from below.
Shape hip(const HipPlan& plan);

}  // namespace vrda
