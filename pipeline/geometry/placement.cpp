#include "geometry/placement.hpp"

#include <limits>
#include <numeric>
#include <utility>

#include "core/text.hpp"
#include "geometry/gap_kernel.hpp"

namespace vrda::geometry {
namespace {

// One triangle a leaf was faster than two on the generic knee: the exact kernel costs more than a node.
constexpr std::int32_t leaf_size = 1;

struct Range {
  std::int32_t begin = 0;
  std::int32_t end = 0;
};

void grow(BoxTree::Node& node, const Eigen::Vector3d& p)
{
  for (std::size_t k = 0; k < 3; ++k) {
    node.min_mm[k] = std::min(node.min_mm[k], p[static_cast<Eigen::Index>(k)]);
    node.max_mm[k] = std::max(node.max_mm[k], p[static_cast<Eigen::Index>(k)]);
  }
}

BoxTree::Node empty_box()
{
  BoxTree::Node node;
  node.min_mm.fill(std::numeric_limits<double>::infinity());
  node.max_mm.fill(-std::numeric_limits<double>::infinity());
  return node;
}

BoxTree::Node box_of(const Mesh& mesh, const std::vector<std::int32_t>& order, Range range)
{
  BoxTree::Node node = empty_box();
  for (std::int32_t k = range.begin; k < range.end; ++k) {
    for (const Eigen::Vector3d& p : corners(mesh, order[static_cast<std::size_t>(k)])) grow(node, p);
  }
  return node;
}

// A triangle's box and the sum of its corners.
struct Bounds {
  Eigen::Vector3d min_mm, max_mm, sum_mm;
};

std::vector<Bounds> bounds_of(const Mesh& mesh)
{
  std::vector<Bounds> bounds;
  bounds.reserve(static_cast<std::size_t>(mesh.triangles.rows()));
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    bounds.push_back({a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c), a + b + c});
  }
  return bounds;
}

BoxTree::Node box_of(const std::vector<Bounds>& bounds, const std::vector<std::int32_t>& order, Range range)
{
  BoxTree::Node node = empty_box();
  for (std::int32_t k = range.begin; k < range.end; ++k) {
    const Bounds& one = bounds[static_cast<std::size_t>(order[static_cast<std::size_t>(k)])];
    grow(node, one.min_mm);
    grow(node, one.max_mm);
  }
  return node;
}

Eigen::Index longest_axis(const BoxTree::Node& node)
{
  std::size_t axis = 0;
  for (std::size_t k = 1; k < 3; ++k) {
    if (node.max_mm[k] - node.min_mm[k] > node.max_mm[axis] - node.min_mm[axis]) axis = k;
  }
  return static_cast<Eigen::Index>(axis);
}

}  // namespace

BoxTree::BoxTree(const Mesh& mesh)
{
  order_.resize(static_cast<std::size_t>(mesh.triangles.rows()));
  std::iota(order_.begin(), order_.end(), 0);
  build(mesh);
}

BoxTree::BoxTree(const Mesh& mesh, const std::vector<std::int32_t>& triangles) : order_(triangles)
{
  build(mesh);
}

void BoxTree::build(const Mesh& mesh)
{
  if (order_.empty()) return;
  const std::vector<Bounds> bounds = bounds_of(mesh);
  nodes_.reserve(2 * order_.size() - 1);
  // Right children are stacked, so that the left child always follows its parent.
  struct Task {
    Range range;
    std::int32_t parent = -1;  // node whose `first` is set to this one; -1 for left children
  };
  std::vector<Task> tasks{{{0, static_cast<std::int32_t>(order_.size())}, -1}};
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    const auto index = static_cast<std::int32_t>(nodes_.size());
    if (task.parent >= 0) nodes_[static_cast<std::size_t>(task.parent)].first = index;
    Node node = box_of(bounds, order_, task.range);
    const std::int32_t n = task.range.end - task.range.begin;
    if (n <= leaf_size) {
      node.first = task.range.begin;
      node.count = n;
      nodes_.push_back(node);
      continue;
    }
    nodes_.push_back(node);
    const std::int32_t middle = task.range.begin + n / 2;
    const Eigen::Index axis = longest_axis(node);
    // Ties by row, so that the tree does not depend on the library's partition.
    std::nth_element(order_.begin() + task.range.begin, order_.begin() + middle,
                     order_.begin() + task.range.end, [&](std::int32_t l, std::int32_t r) {
                       const double cl = bounds[static_cast<std::size_t>(l)].sum_mm[axis],
                                    cr = bounds[static_cast<std::size_t>(r)].sum_mm[axis];
                       return cl != cr ? cl < cr : l < r;
                     });
    tasks.push_back({{middle, task.range.end}, index});
    tasks.push_back({{task.range.begin, middle}, -1});
  }
}

void BoxTree::refit(const Mesh& mesh)
{
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    Node& node = nodes_[n];
    if (node.is_leaf()) {
      const Node fresh = box_of(mesh, order_, {node.first, node.first + node.count});
      node.min_mm = fresh.min_mm;
      node.max_mm = fresh.max_mm;
      continue;
    }
    const Node& left = nodes_[n + 1];
    const Node& right = nodes_[static_cast<std::size_t>(node.first)];
    for (std::size_t k = 0; k < 3; ++k) {
      node.min_mm[k] = std::min(left.min_mm[k], right.min_mm[k]);
      node.max_mm[k] = std::max(left.max_mm[k], right.max_mm[k]);
    }
  }
}

namespace {

using gap_rules::infinity;
/// Barycentric: a ray through a shared edge must hit at least one of the two triangles.
constexpr double ray_edge_slack = 1e-12;
/// Boxes are widened by this, so that rays along a face of a box and flat boxes are not missed.
constexpr double box_margin_mm = 1e-9;
/// Bound on the depth: nodes halve the triangles, whose count has 32 bits.
constexpr std::size_t max_depth = 64;

/// Inverse direction for the slab test; a component of 0 is replaced by a tiny one.
Eigen::Vector3d inverse_of(const Eigen::Vector3d& direction)
{
  constexpr double tiny = 1e-300;
  return direction.unaryExpr([](double d) { return 1.0 / (std::abs(d) < tiny ? tiny : d); });
}

bool intersects_box(const BoxTree::Node& node, const Eigen::Vector3d& from_mm, const Eigen::Vector3d& inverse,
                    double longest_mm)
{
  double enter_mm = 0.0, leave_mm = longest_mm;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    const double a = (node.min_mm[k] - box_margin_mm - from_mm[axis]) * inverse[axis];
    const double b = (node.max_mm[k] + box_margin_mm - from_mm[axis]) * inverse[axis];
    enter_mm = std::max(enter_mm, std::min(a, b));
    leave_mm = std::min(leave_mm, std::max(a, b));
  }
  return enter_mm <= leave_mm;
}

double triangle_travel_mm(const Mesh& mesh, Eigen::Index t, const Ray& ray)
{
  const std::array<Eigen::Vector3d, 3> p = corners(mesh, t);
  const Eigen::Vector3d a = p[1] - p[0], b = p[2] - p[0];
  const Eigen::Vector3d across = ray.direction.cross(b);
  const double facing = a.dot(across);  // -direction . (a x b)
  if (!(facing > 0.0)) return infinity;
  const Eigen::Vector3d start = ray.from_mm - p[0];
  const double u = start.dot(across), least = -ray_edge_slack * facing,
               most = (1.0 + ray_edge_slack) * facing;
  if (u < least || u > most) return infinity;
  const Eigen::Vector3d q = start.cross(a);
  const double v = ray.direction.dot(q);
  if (v < least || u + v > most) return infinity;
  const double travel_mm = b.dot(q) / facing;
  return travel_mm >= 0.0 ? travel_mm : infinity;
}

}  // namespace

double ray_distance_mm(const Mesh& mesh, const BoxTree& tree, const Ray& ray)
{
  if (tree.is_empty()) return infinity;
  const Eigen::Vector3d inverse = inverse_of(ray.direction);
  std::array<std::int32_t, max_depth> stack{};
  std::size_t n = 1;
  double shortest_mm = ray.max_length_mm;
  bool is_hit = false;
  while (n > 0) {
    const std::int32_t at = stack[--n];
    const BoxTree::Node& node = tree.nodes()[static_cast<std::size_t>(at)];
    if (!intersects_box(node, ray.from_mm, inverse, shortest_mm)) continue;
    if (!node.is_leaf()) {
      check(n + 2 <= max_depth, "the depth of a box tree is within the stack");
      stack[n++] = node.first;
      stack[n++] = at + 1;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const double travel_mm = triangle_travel_mm(mesh, tree.order()[static_cast<std::size_t>(i)], ray);
      if (travel_mm > shortest_mm) continue;
      shortest_mm = travel_mm;
      is_hit = true;
    }
  }
  return is_hit ? shortest_mm : infinity;
}

TreeMesh make_tree_mesh(Mesh mesh)
{
  TreeMesh result{std::move(mesh), {}};
  result.tree = BoxTree(result.mesh);
  return result;
}

LateTreeMesh::LateTreeMesh(Mesh mesh) : state_(std::make_shared<State>())
{
  state_->made.mesh = std::move(mesh);
}

const TreeMesh& LateTreeMesh::with_tree() const
{
  std::call_once(state_->once, [this] { state_->made.tree = BoxTree(state_->made.mesh); });
  return state_->made;
}

TreeMesh rotated_reference(const TreeMesh& reference, const Attitude& attitude)
{
  Pose X = Pose::Identity();
  X.linear() = reference_rotation(attitude);
  TreeMesh result{transformed(reference.mesh, X), reference.tree};
  result.tree.refit(result.mesh);
  return result;
}

}  // namespace vrda::geometry
