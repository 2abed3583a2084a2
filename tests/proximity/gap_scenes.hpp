/// Bodies and poses for the tests of the directional gap, and its dense oracle.
#pragma once

#include <random>
#include <vector>

#include "proximity/gap_query.hpp"

namespace vrda::test {

class GapRandom {
 public:
  explicit GapRandom(unsigned seed) : engine_(seed) {}
  double unit() { return distribution_(engine_); }
  /// Within `across_mm` of the axis, about 3 mm around `depth_mm`, turned at will.
  MovingPose pose(double across_mm, double depth_mm);
  Attitude attitude() { return {unit(), 0.2 * unit()}; }
  /// Loose triangles of any slope.
  Mesh soup(int n_triangles, double size_mm);
  /// Every vertex moved in or out by up to `share` of its distance from the origin.
  Mesh dented(Mesh mesh, double share);
  /// The same surface with vertices and triangles renumbered and each triangle begun at another corner.
  Mesh renumbered(const Mesh& mesh);

 private:
  std::vector<Eigen::Index> permutation(Eigen::Index n);
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> distribution_{-1, 1};
};

struct GapBodies {
  Mesh reference, moving;
  double depth_mm = -25;  ///< where the moving one stands below the reference, about to touch
};

/// Convex on convex, a dented pair with reflex edges, flats on flats, soups, and the generic knee, coarse.
std::vector<GapBodies> gap_bodies(GapRandom& random);

/// Every pair of triangles, all their edges and vertices, facing pairs only.
double dense_gap_mm(const GapBodies& bodies, const Attitude& attitude, const MovingPose& pose);

/// Travel and all features as one row of bits.
std::vector<double> bits_of(const GapAnswer& answer);

}  // namespace vrda::test
