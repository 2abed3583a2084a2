/// Heights of meshes over a grid of the plane across Y: where two meshes stand above each other.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/mesh.hpp"

namespace vrda::test {

enum class Facing { up, down };

/// Highest point of the faces looking up (lowest of those looking down) over each node of a 140 mm square
/// grid.
struct Envelope {
  static constexpr int n = 281;
  static constexpr double step_mm = 0.5;
  std::vector<double> y_mm;  ///< [n * n], quiet NaN where nothing is
};

inline Envelope envelope(const Mesh& mesh, Facing facing)
{
  const double sign = facing == Facing::up ? 1.0 : -1.0;
  Envelope result;
  result.y_mm.assign(Envelope::n * Envelope::n, std::numeric_limits<double>::quiet_NaN());
  const auto node = [](double mm) { return mm / Envelope::step_mm + 0.5 * (Envelope::n - 1); };
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    const Eigen::Vector3d normal = (b - a).cross(c - a);
    if (sign * normal.y() <= 1e-9) continue;
    const int i_end = static_cast<int>(std::floor(node(std::max({a.x(), b.x(), c.x()}))));
    const int k_end = static_cast<int>(std::floor(node(std::max({a.z(), b.z(), c.z()}))));
    for (int i = static_cast<int>(std::ceil(node(std::min({a.x(), b.x(), c.x()})))); i <= i_end; ++i) {
      for (int k = static_cast<int>(std::ceil(node(std::min({a.z(), b.z(), c.z()})))); k <= k_end; ++k) {
        const Eigen::Vector3d p((i - 0.5 * (Envelope::n - 1)) * Envelope::step_mm, 0.0,
                                (k - 0.5 * (Envelope::n - 1)) * Envelope::step_mm);
        const auto side = [&](const Eigen::Vector3d& u, const Eigen::Vector3d& v) {
          return sign * ((v.z() - u.z()) * (p.x() - u.x()) - (v.x() - u.x()) * (p.z() - u.z()));
        };
        if (side(a, b) < 0.0 || side(b, c) < 0.0 || side(c, a) < 0.0) continue;
        const double y = a.y() - (normal.x() * (p.x() - a.x()) + normal.z() * (p.z() - a.z())) / normal.y();
        double& held = result.y_mm[static_cast<std::size_t>(i * Envelope::n + k)];
        held = std::isnan(held) || sign * y > sign * held ? y : held;
      }
    }
  }
  return result;
}

/// Smallest height from `lower` up to `upper` where both are; infinite where they never share a node.
inline double smallest_height_mm(const Envelope& upper, const Envelope& lower)
{
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t node = 0; node < upper.y_mm.size(); ++node) {
    const double height = upper.y_mm[node] - lower.y_mm[node];
    smallest = height < smallest ? height : smallest;  // false for NaN
  }
  return smallest;
}

}  // namespace vrda::test
