/// Precomputed data of a mesh for directional gap queries: neighbours of its faces across flat or reflex
/// edges, and trees of eight-lane blocks over its triangles (one triangle a lane in a leaf) for either role.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "model/mesh.hpp"
#include "geometry/gap_blocks.hpp"

namespace vrda::geometry {

/// An edge can touch first if it is convex by more than rounding, a boundary, or not shared by exactly two
/// consistently wound faces. Across a flat or reflex edge between two included faces the height difference is
/// concave: it is never smaller on the edge than around it.
struct GapSurface {
  Mesh mesh;
  std::vector<std::int32_t> triangles;  ///< rows included, ascending
  /// [n_triangles of mesh] face across the edge from corner i to the next, where that edge is flat or reflex;
  /// -1 where it can touch first.
  std::vector<std::array<std::int32_t, 3>> neighbours;
  Points face_normals;  ///< [n_triangles, 3] unit; zero for a degenerate face
};

/// The surface consists of the listed faces: an edge to any other face is a boundary.
GapSurface gap_surface(const Mesh& mesh, std::vector<std::int32_t> triangles);

/// Bit i: the edge from corner i of `triangle` can touch first if only faces with `counts[row]` are included.
unsigned first_contact_edges(const GapSurface& surface, std::int32_t triangle,
                             const std::vector<bool>& counts);

/// Children of a block: blocks, or rows of triangles in a leaf; -1 for an unused lane. Blocks are in
/// depth-first order, the root first.
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

/// Over the listed triangles.
MovingTree moving_tree(const GapSurface& surface, const std::vector<std::int32_t>& triangles);

}  // namespace vrda::geometry
