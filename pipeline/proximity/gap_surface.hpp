/// What a mesh brings to directional gap queries before anybody asks: its faces' neighbours, and which of its
/// edges can be the first to touch.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh.hpp"

namespace vrda {

/// Edges that can be the first to touch are those that stick out (convex by more than rounding), bound the
/// sheet, or are not shared by exactly two consistently wound faces. Along a flat or reflex edge between two
/// faces that both count, the height difference is concave: it is never smaller on the edge than all around.
struct GapSurface {
  Mesh mesh;
  std::vector<std::int32_t> triangles;  ///< rows that count, ascending
  /// [n_triangles of mesh] face across the edge from corner i to the next, where that edge is flat or reflex;
  /// -1 where it can touch first.
  std::vector<std::array<std::int32_t, 3>> neighbours;
  Points face_normals;  ///< [n_triangles, 3] unit; zero for a degenerate face
};

/// The faces listed alone are the surface: an edge to a face not listed bounds it.
GapSurface gap_surface(const Mesh& mesh, std::vector<std::int32_t> triangles);

/// Bit i: the edge from corner i of `triangle` can touch first, where only faces with `counts[row]` count.
unsigned touching_edges(const GapSurface& surface, std::int32_t triangle, const std::vector<bool>& counts);

}  // namespace vrda
