/// Distance of two triangles by the textbook cases (vertex-face, edge-edge, edge through face), as an oracle.
#pragma once

#include <Eigen/Core>
#include <array>

namespace vrda::test {

/// 0 when they share a point.
double triangle_distance_mm(const std::array<Eigen::Vector3d, 3>& a, const std::array<Eigen::Vector3d, 3>& b);

}  // namespace vrda::test
