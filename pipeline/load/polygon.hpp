/// Triangulation of polygons.
#pragma once

#include <array>
#include <vector>

#include "core/mesh.hpp"

namespace vrda::load {

/// Ear clipping in the best-fit plane of the polygon (Newell's normal). Concave polygons are covered exactly
/// once; the winding is kept. `corners_mm` are the corners in order; the result contains indices into it. If
/// no ear is left (self-intersecting polygon), the rest becomes a fan. Zero area gives no triangles. Cost:
/// cubic at worst.
std::vector<std::array<std::int32_t, 3>> triangulate(const Points& corners_mm);

}  // namespace vrda::load
