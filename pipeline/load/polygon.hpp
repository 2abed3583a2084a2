/// Polygons cut into triangles.
#pragma once

#include <array>
#include <vector>

#include "core/mesh.hpp"

namespace vrda {

/// Ear clipping in the polygon's best-fit plane (Newell's normal): concave polygons come out covered once
/// and not beyond their outline, windings kept. `corners_mm` are the corners in order; the result holds
/// positions in it. A polygon that crosses itself is clipped as far as it goes and cut into a fan then;
/// one without area gives nothing. Cost: cube of the number of corners at worst.
std::vector<std::array<std::int32_t, 3>> triangulated(const Points& corners_mm);

}  // namespace vrda
