/// Heights of meshes over a grid in the plane across Y, and the vertical distance of two meshes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "model/mesh.hpp"

namespace vrda::test {

enum class Facing { up, down };

/// Highest point of the faces directed up (lowest of those directed down) over each node of a 140 mm square
/// grid.
struct Envelope {
  static constexpr int n = 281;
  static constexpr double step_mm = 0.5;
  std::vector<double> y_mm;  ///< [n * n], quiet NaN where there is no face
};

inline double node_of(double mm)
{
  return mm / Envelope::step_mm + 0.5 * (Envelope::n - 1);
}

/// Adds one face directed up (sign 1) or down (sign -1).
inline void include_face(Envelope& result, const std::array<Eigen::Vector3d, 3>& face, double sign)
{
  const auto& [a, b, c] = face;
  const Eigen::Vector3d normal = (b - a).cross(c - a);
  if (sign * normal.y() <= 1e-9) return;
  const auto side = [&](const Eigen::Vector3d& u, const Eigen::Vector3d& v, double x, double z) {
    return sign * ((v.z() - u.z()) * (x - u.x()) - (v.x() - u.x()) * (z - u.z()));
  };
  const double i_end = node_of(std::max({a.x(), b.x(), c.x()}));
  const double k_end = node_of(std::max({a.z(), b.z(), c.z()}));
  for (double i = std::ceil(node_of(std::min({a.x(), b.x(), c.x()}))); i <= i_end; i += 1.0) {
    for (double k = std::ceil(node_of(std::min({a.z(), b.z(), c.z()}))); k <= k_end; k += 1.0) {
      const double x = (i - 0.5 * (Envelope::n - 1)) * Envelope::step_mm;
      const double z = (k - 0.5 * (Envelope::n - 1)) * Envelope::step_mm;
      if (side(a, b, x, z) < 0.0 || side(b, c, x, z) < 0.0 || side(c, a, x, z) < 0.0) continue;
      const double y = a.y() - (normal.x() * (x - a.x()) + normal.z() * (z - a.z())) / normal.y();
      double& held = result.y_mm[static_cast<std::size_t>(i) * Envelope::n + static_cast<std::size_t>(k)];
      held = std::isnan(held) || sign * y > sign * held ? y : held;
    }
  }
}

inline Envelope envelope(const Mesh& mesh, Facing facing)
{
  Envelope result;
  result.y_mm.assign(std::size_t{Envelope::n} * Envelope::n, std::numeric_limits<double>::quiet_NaN());
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    include_face(result, corners(mesh, t), facing == Facing::up ? 1.0 : -1.0);
  }
  return result;
}

/// Smallest height from `lower` up to `upper` over common nodes; infinite without any.
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
