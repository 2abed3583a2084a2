// Where the surface of a mesh ends.
#include "analysis/pose_assessment.hpp"

#include <algorithm>
#include <utility>

namespace vrda::analysis {

std::vector<std::int8_t> boundary_edges(const Mesh& mesh)
{
  struct Side {
    std::int32_t first, second;  // sorted vertices
    Eigen::Index triangle;
    int corner;
  };
  std::vector<Side> sides;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const auto [first, second] = std::minmax(mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3));
      sides.push_back({first, second, t, k});
    }
  }
  const auto edge = [](const Side& s) { return std::pair(s.first, s.second); };
  std::sort(sides.begin(), sides.end(), [&](const Side& a, const Side& b) { return edge(a) < edge(b); });
  std::vector<std::int8_t> bits(static_cast<std::size_t>(mesh.triangles.rows()), 0);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool is_shared = (i > 0 && edge(sides[i - 1]) == edge(sides[i])) ||
                           (i + 1 < sides.size() && edge(sides[i]) == edge(sides[i + 1]));
    if (!is_shared)
      bits[static_cast<std::size_t>(sides[i].triangle)] |= static_cast<std::int8_t>(1 << sides[i].corner);
  }
  return bits;
}

namespace {

double distance_to_segment_mm(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b)
{
  const Eigen::Vector3d along = b - a;
  const double length_sq = along.squaredNorm();
  const double share = length_sq > 0.0 ? std::clamp((p - a).dot(along) / length_sq, 0.0, 1.0) : 0.0;
  return (p - a - share * along).norm();
}

}  // namespace

bool is_at_border(const Mesh& mesh, const std::vector<std::int8_t>& border, std::int32_t t,
                  const Eigen::Vector3d& p_mm, double resolution_mm)
{
  // Writing the model refuses a row outside the mesh, which only a damaged journal has.
  if (t < 0 || static_cast<std::size_t>(t) >= border.size()) return false;
  const int bits = border[static_cast<std::size_t>(t)];
  for (int k = 0; k < 3; ++k) {
    if ((bits >> k & 1) == 0) continue;
    const Eigen::Vector3d a = mesh.vertices_mm.row(mesh.triangles(t, k)).transpose();
    const Eigen::Vector3d b = mesh.vertices_mm.row(mesh.triangles(t, (k + 1) % 3)).transpose();
    if (distance_to_segment_mm(p_mm, a, b) <= resolution_mm) return true;
  }
  return false;
}

}  // namespace vrda::analysis
