/// Decides between different collision answers: the standard test for every pair of triangles, in 80-bit
/// arithmetic.
#pragma once

#include "geometry/placement.hpp"

namespace vrda::test {

/// Standard triangle tests, over the pairs found by our trees.
bool textbook_collides(const geometry::TreeMesh& reference, const geometry::TreeMesh& moving,
                       const MovingPose& pose);

struct ThirdMeasure {
  bool is_overlapping = false;
  /// Distance of the nearest pair, or depth of the deepest; infinite if no pair is within a micrometre.
  long double from_touch_mm = 0.0L;
};

/// Over every pair of triangles, without a tree. Cost: seconds for a real knee.
ThirdMeasure reference_measure(const Mesh& reference, const Mesh& moving, const MovingPose& pose);

}  // namespace vrda::test
