/// Fewer triangles within a known distance.
#pragma once

#include <optional>

#include "model/mesh.hpp"

namespace vrda::geometry {

struct SimplifiedMesh {
  Mesh mesh;                ///< some of the given vertices; with normals
  double largest_mm = 0.0;  ///< from the given surface, measured at some 20,000 of its vertices
};

/// At most some `n_wanted` triangles, as far as the surface stays within `largest_mm`; absent where no copy
/// with fewer triangles does. Borders stay. Offsets and overlaps of triangles are not kept.
std::optional<SimplifiedMesh> simplified(const Mesh& mesh, Eigen::Index n_wanted, double largest_mm);

}  // namespace vrda::geometry
