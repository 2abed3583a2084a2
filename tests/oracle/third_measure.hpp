/// Who is right when two collision answers differ: every pair of triangles by the textbook, in 80-bit
/// arithmetic.
#pragma once

#include "proximity/placed.hpp"

namespace vrda::test {

/// By the textbook's cases, over pairs that our trees offer.
bool textbook_collides(const TreeMesh& reference, const TreeMesh& moving, const MovingPose& pose);

struct ThirdMeasure {
  bool is_overlapping = false;
  /// Distance of the nearest pair, or depth of the deepest; infinite when nothing comes within a micrometre.
  long double from_touch_mm = 0.0L;
};

/// Over every pair of triangles, without any tree. Cost: seconds for a real knee.
ThirdMeasure third_measure(const Mesh& reference, const Mesh& moving, const MovingPose& pose);

}  // namespace vrda::test
