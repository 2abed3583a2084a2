/// Levels of detail: the same vertices with fewer triangles, for drawing only.
#pragma once

#include <cstdint>
#include <vector>

#include "core/draw_mesh.hpp"

namespace vrda {

struct DetailLevel {
  std::vector<std::uint32_t> triangles;  ///< three indices of the mesh's vertices each
  double error_mm = 0.0;                 ///< how far its surface may lie from the mesh's
};

using MeshLevels = std::vector<DetailLevel>;

/// `mesh` in an order that suits graphics hardware, then coarser levels, each with clearly fewer triangles
/// and a larger error than the one before.
MeshLevels levels_of(const DrawMesh& mesh);

/// Whether nothing of the inside can be seen from outside: vertices at one place taken as one, every edge has
/// as many triangles one way as the other, and the triangles enclose a positive volume.
bool is_closed(const DrawMesh& mesh);

}  // namespace vrda
