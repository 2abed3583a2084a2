/// Distance of two triangles by the standard cases (vertex-face, edge-edge, edge through face); an oracle.
#pragma once

#include <Eigen/Core>
#include <array>

namespace vrda::test {

/// 0 if they share a point.
double triangle_distance_mm(const std::array<Eigen::Vector3d, 3>& a, const std::array<Eigen::Vector3d, 3>& b);

/// The same in 80-bit arithmetic: 1e-17 mm for coordinates of 100 mm.
long double fine_triangle_distance_mm(const std::array<Eigen::Vector3d, 3>& a,
                                      const std::array<Eigen::Vector3d, 3>& b);

/// The shortest translation that separates two triangles that share a point, in 80-bit arithmetic: along a
/// normal, a cross product of two edges, or an edge's normal within its plane.
long double fine_triangle_depth_mm(const std::array<Eigen::Vector3d, 3>& a,
                                   const std::array<Eigen::Vector3d, 3>& b);

}  // namespace vrda::test
