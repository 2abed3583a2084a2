/// Where the surface of a mesh ends.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh.hpp"

namespace vrda::audit {

/// Edges of one triangle only, per triangle: bit k is the edge from its corner k to the next.
std::vector<std::int8_t> boundary_edges(const Mesh& mesh);

/// Whether a point on triangle `t` is within `resolution_mm` of one of its boundary edges. `border`:
/// boundary_edges(mesh). False for a triangle outside the mesh.
bool is_at_border(const Mesh& mesh, const std::vector<std::int8_t>& border, std::int32_t t,
                  const Eigen::Vector3d& p_mm, double resolution_mm);

}  // namespace vrda::audit
