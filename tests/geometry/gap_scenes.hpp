/// Bodies and poses for the tests of the directional gap, and a brute-force reference.
#pragma once

#include <random>
#include <vector>

#include "geometry/gap_query.hpp"

namespace vrda::test {

class GapRandom {
 public:
  explicit GapRandom(unsigned seed) : engine_(seed) {}
  double unit() { return distribution_(engine_); }
  /// Within `across_mm` of the axis, within 3 mm of `depth_mm`, any rotation.
  MovingPose pose(double across_mm, double depth_mm);
  Attitude attitude() { return {unit(), 0.2 * unit()}; }
  /// Unconnected random triangles.
  Mesh soup(int n_triangles, double size_mm);
  /// Every vertex scaled by a random factor of 1 +- `share`.
  Mesh dented(Mesh mesh, double share);
  /// The same surface with vertices and triangles renumbered and each triangle starting at another corner.
  Mesh renumbered(const Mesh& mesh);

 private:
  std::vector<Eigen::Index> permutation(Eigen::Index n);
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> distribution_{-1, 1};
};

struct GapBodies {
  Mesh reference, moving;
  double depth_mm = -25;  ///< height of the moving object close below the reference
};

/// Convex pair, dented pair with reflex edges, boxes, unconnected triangles, and the coarse generic knee.
std::vector<GapBodies> gap_bodies(GapRandom& random);

/// The bodies with an offset each, and a second component of the moving body without one.
GapBodies rounded(GapBodies bodies);

/// Brute force over every facing pair of triangles, with all their edges and vertices.
double dense_gap_mm(const GapBodies& bodies, const Attitude& attitude, const MovingPose& pose);

/// Travel and all features as one row, for bitwise comparison.
std::vector<double> bits_of(const geometry::GapResult& answer);

}  // namespace vrda::test
