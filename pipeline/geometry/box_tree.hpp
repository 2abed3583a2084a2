/// Bounding-volume tree over the triangles of one mesh, in the mesh's own frame, and ray casting.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "model/mesh.hpp"

namespace vrda::geometry {

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
  /// Tree over the listed triangles; an empty list gives an empty tree.
  BoxTree(const Mesh& mesh, const std::vector<std::int32_t>& triangles);
  explicit BoxTree(const Mesh& mesh);

  /// Recomputes the boxes for the same triangles with other vertices (a rotated copy of the mesh).
  void refit(const Mesh& mesh);

  bool is_empty() const { return nodes_.empty(); }
  const std::vector<Node>& nodes() const { return nodes_; }
  const std::vector<std::int32_t>& order() const { return order_; }

 private:
  void build(const Mesh& mesh);

  std::vector<Node> nodes_;
  std::vector<std::int32_t> order_;  // triangle rows, leaf by leaf
};

/// A ray of limited length.
struct Ray {
  Eigen::Vector3d from_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitY();  ///< unit
  double max_length_mm = 0.0;
};

/// Distance to the first triangle of `mesh` that faces the ray (normal against the direction); infinite where
/// none is within max_length_mm. In the mesh's own frame. A ray through an edge or a vertex hits a triangle
/// there. No allocation; under a microsecond for short rays.
/// Source: Moeller and Trumbore (1997), J Graphics Tools 2(1):21-28.
double ray_distance_mm(const Mesh& mesh, const BoxTree& tree, const Ray& ray);

}  // namespace vrda::geometry
