#include "proximity/ray_travel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.hpp"
#include "proximity/gap_kernel.hpp"

namespace vrda {
namespace {

using gap_rules::infinity;
/// Barycentric: a ray through a shared edge must meet at least one of both triangles.
constexpr double ray_edge_slack = 1e-12;
/// Boxes are that much wider: a ray along a side of one, or a flat one, must not be lost.
constexpr double box_margin_mm = 1e-9;
/// Halving the triangles at each node, a tree of all that 32 bits count is no deeper.
constexpr std::size_t deepest = 64;

/// Slabs divide by the direction: a component of 0 becomes a hair.
Eigen::Vector3d inverse_of(const Eigen::Vector3d& direction)
{
  constexpr double hair = 1e-300;
  return direction.unaryExpr([](double d) { return 1.0 / (std::abs(d) < hair ? hair : d); });
}

bool meets_box(const BoxTree::Node& node, const Eigen::Vector3d& from_mm, const Eigen::Vector3d& inverse,
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
  const double facing = a.dot(across);  // minus the direction times the doubled area's normal
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

double ray_travel_mm(const Mesh& mesh, const BoxTree& tree, const Ray& ray)
{
  if (tree.is_empty()) return infinity;
  const Eigen::Vector3d inverse = inverse_of(ray.direction);
  std::array<std::int32_t, deepest> stack{};
  std::size_t n = 1;
  double shortest_mm = ray.longest_mm;
  bool is_met = false;
  while (n > 0) {
    const std::int32_t at = stack[--n];
    const BoxTree::Node& node = tree.nodes()[static_cast<std::size_t>(at)];
    if (!meets_box(node, ray.from_mm, inverse, shortest_mm)) continue;
    if (!node.is_leaf()) {
      check(n + 2 <= deepest, "a tree of triangles is not deeper than the stack");
      stack[n++] = node.first;
      stack[n++] = at + 1;
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const double travel_mm = triangle_travel_mm(mesh, tree.order()[static_cast<std::size_t>(i)], ray);
      if (travel_mm > shortest_mm) continue;
      shortest_mm = travel_mm;
      is_met = true;
    }
  }
  return is_met ? shortest_mm : infinity;
}

}  // namespace vrda
