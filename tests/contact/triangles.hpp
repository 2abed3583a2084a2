/// Seeded random triangles about the origin, and points beside a triangle.
#pragma once

#include <algorithm>
#include <cmath>
#include <random>

#include "geometry/placement.hpp"

namespace vrda::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double unit() { return distribution_(engine_); }
  geometry::Corners triangle(double size_mm, double flatness)
  {
    geometry::Corners t;
    for (Eigen::Vector3d& p : t) p << size_mm * unit(), size_mm * flatness * unit(), size_mm * unit();
    return t;
  }

 private:
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> distribution_{-1.0, 1.0};
};

/// Distance of a point from the triangle's plane or beyond its edges; not positive inside it.
inline double outside_mm(const geometry::Corners& t, const Eigen::Vector3d& p)
{
  const Eigen::Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
  double most = std::abs(n.dot(p - t[0]));
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d along = (t[(k + 1) % 3] - t[k]).normalized();
    most = std::max(most, -n.dot(along.cross(p - t[k])));
  }
  return most;
}

}  // namespace vrda::test
