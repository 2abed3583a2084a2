#include "report/outline.hpp"

#include <algorithm>
#include <array>

#include "core/trig.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

using Point = Eigen::Vector2d;
struct Edge {
  Point a, b;
};

double cross(const Point& a, const Point& b)
{
  return a.x() * b.y() - a.y() * b.x();
}

bool counts(const std::array<Eigen::Vector3d, 3>& corner, const OutlineOptions& options)
{
  return std::all_of(corner.begin(), corner.end(), [&](const Eigen::Vector3d& p) {
    return p.y() >= options.from_mm && p.y() <= options.to_mm;
  });
}

std::vector<Edge> edges_of(const Mesh& mesh, const OutlineOptions& options)
{
  std::vector<Edge> edges;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const std::array<Eigen::Vector3d, 3> corner = corners(mesh, t);
    if (!counts(corner, options)) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d& a = corner[k];
      const Eigen::Vector3d& b = corner[(k + 1) % 3];
      edges.push_back({{a.x(), a.z()}, {b.x(), b.z()}});
    }
  }
  return edges;
}

Point middle_of(const std::vector<Edge>& edges)
{
  Point least = edges.front().a, largest = edges.front().a;
  for (const Edge& edge : edges) {
    least = least.cwiseMin(edge.a);
    largest = largest.cwiseMax(edge.a);
  }
  return 0.5 * (least + largest);
}

// How far along `direction` from `middle` the edge is met; below 0 when it is not.
double crossing_mm(const Edge& edge, const Point& middle, const Point& direction)
{
  const Point a = edge.a - middle, b = edge.b - middle;
  const double side_a = cross(direction, a), side_b = cross(direction, b);
  if ((side_a > 0.0) == (side_b > 0.0)) return -1.0;
  const double share = side_a / (side_a - side_b);
  return direction.dot(a + share * (b - a));
}

}  // namespace

std::vector<Eigen::Vector2d> outline(const Mesh& mesh, const OutlineOptions& options)
{
  const std::vector<Edge> edges = edges_of(mesh, options);
  if (edges.empty()) return {};
  const Point middle = middle_of(edges);
  std::vector<Point> rim;
  for (int k = 0; k < options.n_directions; ++k) {
    const SinCos turn = sin_cos(2.0 * pi * k / options.n_directions);
    const Point direction(turn.cos, turn.sin);
    double farthest_mm = 0.0;
    for (const Edge& edge : edges) farthest_mm = std::max(farthest_mm, crossing_mm(edge, middle, direction));
    if (farthest_mm > 0.0) rim.push_back(middle + farthest_mm * direction);
  }
  return rim;
}

}  // namespace vrda
