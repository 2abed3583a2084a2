/// Trees of eight-lane blocks over the triangles of a surface, one triangle a lane at the bottom, for either
/// role in a directional gap query.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "proximity/gap_blocks.hpp"
#include "proximity/gap_kernel.hpp"
#include "proximity/gap_surface.hpp"

namespace vrda {

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
