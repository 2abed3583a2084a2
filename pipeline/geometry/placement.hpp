/// Bounding-volume tree over the triangles of one mesh, in the mesh's own frame, and ray casting.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "core/units.hpp"
#include "model/frames.hpp"
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

// The two objects in the solver frame S (model/frames.hpp): the reference rotated to an attitude, the moving
// object placed by a pose.

/// A mesh in the solver frame with its tree.
struct TreeMesh {
  Mesh mesh;
  BoxTree tree;
};

TreeMesh make_tree_mesh(Mesh mesh);

/// A mesh whose tree is built on first use. Copies share it; thread-safe.
class LateTreeMesh {
 public:
  LateTreeMesh() : LateTreeMesh(Mesh()) {}
  explicit LateTreeMesh(Mesh mesh);
  const Mesh& mesh() const { return state_->made.mesh; }
  const TreeMesh& with_tree() const;

 private:
  struct State {
    TreeMesh made;
    std::once_flag once;
  };
  std::shared_ptr<State> state_;
};

/// Largest sum of the offsets of a pair of triangles.
inline double rounding_mm(const Mesh& reference, const Mesh& moving)
{
  return largest_offset_mm(reference) + largest_offset_mm(moving);
}

/// `reference` rotated to an attitude: vertices, normals and boxes; same triangles.
TreeMesh rotated_reference(const TreeMesh& reference, const Attitude& attitude);

using Corners = std::array<Eigen::Vector3d, 3>;

struct Extent {
  double least = 0.0;
  double most = 0.0;
};

inline Extent extent(const Corners& t, Eigen::Index axis)
{
  return {std::min({t[0][axis], t[1][axis], t[2][axis]}), std::max({t[0][axis], t[1][axis], t[2][axis]})};
}

/// Maps moving boxes and triangles to S without changing the tree; the rotation is about Y only.
class Placement {
 public:
  explicit Placement(const MovingPose& pose) : turn_(sin_cos(pose.theta_rad)), t_(pose.translation_mm) {}

  Eigen::Vector3d operator()(const Eigen::Vector3d& p) const
  {
    return {turn_.cos * p.x() + turn_.sin * p.z() + t_.x(), p.y() + t_.y(),
            -turn_.sin * p.x() + turn_.cos * p.z() + t_.z()};
  }

  Eigen::Vector3d direction(const Eigen::Vector3d& v) const { return (*this)(v)-t_; }

  Corners operator()(const Corners& corner) const
  {
    return {(*this)(corner[0]), (*this)(corner[1]), (*this)(corner[2])};
  }

  /// Encloses the placed box; exact in height.
  BoxTree::Node operator()(const BoxTree::Node& node) const
  {
    const double cx = 0.5 * (node.min_mm[0] + node.max_mm[0]), hx = 0.5 * (node.max_mm[0] - node.min_mm[0]);
    const double cz = 0.5 * (node.min_mm[2] + node.max_mm[2]), hz = 0.5 * (node.max_mm[2] - node.min_mm[2]);
    const double ac = std::abs(turn_.cos), as = std::abs(turn_.sin);
    // Widened, so that rounding never excludes a vertex.
    const double ex = (ac * hx + as * hz) * (1.0 + 1e-12) + 1e-12;
    const double ez = (as * hx + ac * hz) * (1.0 + 1e-12) + 1e-12;
    const double x = turn_.cos * cx + turn_.sin * cz + t_.x();
    const double z = -turn_.sin * cx + turn_.cos * cz + t_.z();
    BoxTree::Node placed = node;
    placed.min_mm = {x - ex, node.min_mm[1] + t_.y(), z - ez};
    placed.max_mm = {x + ex, node.max_mm[1] + t_.y(), z + ez};
    return placed;
  }

 private:
  SinCos turn_;
  Eigen::Vector3d t_;
};

/// Maps boxes and triangles by any rigid motion. For a rotation about Y points are bitwise equal to
/// Placement's.
class RigidPlacement {
 public:
  explicit RigidPlacement(const Pose& X) : R_(X.linear()), t_(X.translation()) {}

  Eigen::Vector3d operator()(const Eigen::Vector3d& p) const
  {
    Eigen::Vector3d placed;
    for (Eigen::Index k = 0; k < 3; ++k)
      placed[k] = R_(k, 0) * p.x() + R_(k, 1) * p.y() + R_(k, 2) * p.z() + t_[k];
    return placed;
  }

  Eigen::Vector3d direction(const Eigen::Vector3d& v) const { return (*this)(v)-t_; }

  Corners operator()(const Corners& corner) const
  {
    return {(*this)(corner[0]), (*this)(corner[1]), (*this)(corner[2])};
  }

  /// Encloses the placed box.
  BoxTree::Node operator()(const BoxTree::Node& node) const
  {
    BoxTree::Node placed = node;
    Eigen::Vector3d centre, half;
    for (std::size_t k = 0; k < 3; ++k) {
      centre[static_cast<Eigen::Index>(k)] = 0.5 * (node.min_mm[k] + node.max_mm[k]);
      half[static_cast<Eigen::Index>(k)] = 0.5 * (node.max_mm[k] - node.min_mm[k]);
    }
    const Eigen::Vector3d c = (*this)(centre);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      const double reach =
          std::abs(R_(i, 0)) * half.x() + std::abs(R_(i, 1)) * half.y() + std::abs(R_(i, 2)) * half.z();
      // Widened, so that rounding never excludes a vertex.
      const double h = reach * (1.0 + 1e-12) + 1e-12;
      placed.min_mm[k] = c[i] - h;
      placed.max_mm[k] = c[i] + h;
    }
    return placed;
  }

 private:
  Eigen::Matrix3d R_;
  Eigen::Vector3d t_;
};

struct TrianglePair {
  std::int32_t reference = -1;
  std::int32_t moving = -1;
  auto operator<=>(const TrianglePair&) const = default;
};

/// What touches: a vertex and a face, or two edges; only with an offset also a moving vertex and an edge of
/// the reference, an edge of the moving object and a vertex of the reference, two vertices.
enum class ContactKind : std::uint8_t {
  moving_vertex,
  reference_vertex,
  edges,
  reference_edge,
  moving_edge,
  vertices
};

/// Calls `visit(pair)` for every pair of two leaves, until it returns true; returns whether it did.
template <typename Visit>
bool visit_leaves(const BoxTree& reference, const BoxTree::Node& r, const BoxTree& moving,
                  const BoxTree::Node& m, const Visit& visit)
{
  for (std::int32_t i = r.first; i < r.first + r.count; ++i) {
    for (std::int32_t k = m.first; k < m.first + m.count; ++k) {
      if (visit(TrianglePair{reference.order()[static_cast<std::size_t>(i)],
                             moving.order()[static_cast<std::size_t>(k)]})) {
        return true;
      }
    }
  }
  return false;
}

/// Sum of the edge lengths of a box.
inline double edge_sum_mm(const BoxTree::Node& node)
{
  return node.max_mm[0] - node.min_mm[0] + node.max_mm[1] - node.min_mm[1] + node.max_mm[2] - node.min_mm[2];
}

/// Calls `visit(pair)` for every pair of triangles whose boxes are within `band_mm`, until it returns true.
/// Returns whether it did. The order is fixed by the trees. `place` maps the moving tree to the reference's
/// frame.
template <typename Transform, typename Visit>
bool visit_close_pairs(const BoxTree& reference, const BoxTree& moving, const Transform& place,
                       double band_mm, const Visit& visit)
{
  if (reference.is_empty() || moving.is_empty()) return false;
  struct Task {
    std::int32_t reference = 0;
    std::int32_t moving = 0;
    BoxTree::Node placed;  // the moving box, kept while the reference's node is split
  };
  std::vector<Task> tasks;
  const auto push = [&](std::int32_t of_reference, std::int32_t of_moving, const BoxTree::Node& m) {
    const BoxTree::Node& r = reference.nodes()[static_cast<std::size_t>(of_reference)];
    for (std::size_t k = 0; k < 3; ++k) {
      if (r.min_mm[k] - m.max_mm[k] > band_mm || m.min_mm[k] - r.max_mm[k] > band_mm) return;
    }
    tasks.push_back({of_reference, of_moving, m});
  };
  const auto placed = [&](std::int32_t of_moving) {
    return place(moving.nodes()[static_cast<std::size_t>(of_moving)]);
  };
  push(0, 0, placed(0));
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    const BoxTree::Node& r = reference.nodes()[static_cast<std::size_t>(task.reference)];
    const BoxTree::Node& m = task.placed;
    if (r.is_leaf() && m.is_leaf()) {
      if (visit_leaves(reference, r, moving, m, visit)) return true;
      continue;
    }
    if (m.is_leaf() || (!r.is_leaf() && edge_sum_mm(r) >= edge_sum_mm(m))) {
      push(r.first, task.moving, m);
      push(task.reference + 1, task.moving, m);
    } else {
      push(task.reference, m.first, placed(m.first));
      push(task.reference, task.moving + 1, placed(task.moving + 1));
    }
  }
  return false;
}

/// The same for the pairs of triangles of one mesh whose boxes touch: each pair once, smaller row first.
template <typename Visit>
bool visit_own_pairs(const BoxTree& tree, const Visit& visit)
{
  if (tree.is_empty()) return false;
  const auto node = [&](std::int32_t i) -> const BoxTree::Node& {
    return tree.nodes()[static_cast<std::size_t>(i)];
  };
  const auto visit_ordered = [&](const TrianglePair& pair) {
    return pair.reference != pair.moving &&
           visit(TrianglePair{std::min(pair.reference, pair.moving), std::max(pair.reference, pair.moving)});
  };
  std::vector<std::array<std::int32_t, 2>> tasks{{0, 0}};
  while (!tasks.empty()) {
    const auto [i, k] = tasks.back();
    tasks.pop_back();
    const BoxTree::Node &a = node(i), &b = node(k);
    bool is_apart = false;
    for (std::size_t axis = 0; axis < 3; ++axis)
      is_apart = is_apart || a.min_mm[axis] > b.max_mm[axis] || b.min_mm[axis] > a.max_mm[axis];
    if (is_apart) continue;
    if (a.is_leaf() && b.is_leaf()) {
      if (visit_leaves(tree, a, tree, b, visit_ordered)) return true;
    } else if (i == k) {
      tasks.insert(tasks.end(), {{i + 1, a.first}, {a.first, a.first}, {i + 1, i + 1}});
    } else if (b.is_leaf() || (!a.is_leaf() && edge_sum_mm(a) >= edge_sum_mm(b))) {
      tasks.insert(tasks.end(), {{a.first, k}, {i + 1, k}});
    } else {
      tasks.insert(tasks.end(), {{i, b.first}, {i, k + 1}});
    }
  }
  return false;
}

}  // namespace vrda::geometry
