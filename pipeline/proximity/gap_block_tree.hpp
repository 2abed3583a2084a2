/// What a mesh brings to directional gap queries before anybody asks: neighbours and first edges of its
/// faces, and trees of eight-lane blocks over its triangles, one triangle a lane at the bottom, for either
/// role in a query.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh.hpp"
#include "proximity/gap_blocks.hpp"

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

/// Children of a block: further blocks, or rows of triangles in a leaf. -1 for an absent lane. Blocks stand
/// in depth-first order, the root first.
struct Block {
  std::array<std::int32_t, block_lanes> child{};
  std::int32_t height = 0;   ///< levels below
  std::int32_t slot = 0;     ///< into the inner or the leaf bounds
  std::int32_t parent = -1;  ///< -1: the root
  std::int32_t lane = 0;     ///< of the parent
  bool is_leaf() const { return height == 0; }
};

struct ReferenceTree {
  std::vector<Block> blocks;
  std::vector<ReferenceInner> inner;
  std::vector<ReferenceLeaf> leaves;
};

struct MovingTree {
  std::vector<Block> blocks;
  std::vector<MovingInner> inner;
  std::vector<MovingLeaf> leaves;
};

/// Over every triangle of the surface.
ReferenceTree reference_tree(const GapSurface& surface);

/// Over the triangles listed.
MovingTree moving_tree(const GapSurface& surface, const std::vector<std::int32_t>& triangles);

}  // namespace vrda
