/// Bounding-volume tree over the triangles of one mesh, in the mesh's own frame.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh.hpp"

namespace vrda {

/// Axis-aligned boxes, median split, nodes in depth-first order (a child's index exceeds its parent's).
class BoxTree {
 public:
  struct Node {
    std::array<double, 3> min_mm{};
    std::array<double, 3> max_mm{};
    std::int32_t first = 0;  ///< leaf: first entry of order(); inner: right child (left is the next node)
    std::int32_t count = 0;  ///< leaf: triangles; inner: 0
    bool is_leaf() const { return count > 0; }
  };

  BoxTree() = default;
  /// Only the triangles listed; an empty list gives an empty tree.
  BoxTree(const Mesh& mesh, const std::vector<std::int32_t>& triangles);
  explicit BoxTree(const Mesh& mesh);

  /// The boxes again, for the same triangles over other vertices (a turned copy of the mesh).
  void refit(const Mesh& mesh);

  bool is_empty() const { return nodes_.empty(); }
  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<std::int32_t>& order() const { return order_; }

 private:
  void build(const Mesh& mesh);

  std::vector<Node> nodes_;
  std::vector<std::int32_t> order_;  // triangle rows, leaf by leaf
};

}  // namespace vrda
