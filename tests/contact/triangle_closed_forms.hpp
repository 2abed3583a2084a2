/// Separation and closest points of two triangles in closed form: the oracle of Bullet's measurements.
#pragma once

#include "geometry/placement.hpp"

namespace vrda::test {

struct ClosestPoints {
  double distance_mm = 0.0;
  Eigen::Vector3d p_reference_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_moving_mm = Eigen::Vector3d::Zero();
};

/// Largest separation over the axes of the separating-axis theorem (both normals, cross products of edges,
/// in-plane edge normals): positive when the triangles are disjoint, negative when they overlap by at least
/// as much on every axis. Accurate to rounding.
double separation_mm(const geometry::Corners& a, const geometry::Corners& b);

/// Closest points of two disjoint triangles over all corners, edges and faces; accurate to rounding. Where
/// they are not unique (parallel edges or faces) the result is an end of the common segment.
ClosestPoints closest_points(const geometry::Corners& reference, const geometry::Corners& moving);

}  // namespace vrda::test
