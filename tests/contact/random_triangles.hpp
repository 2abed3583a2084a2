/// Seeded random numbers and triangles about the origin.
#pragma once

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

}  // namespace vrda::test
