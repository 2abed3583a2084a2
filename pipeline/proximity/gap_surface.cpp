#include "proximity/gap_surface.hpp"

#include <algorithm>
#include <utility>

namespace vrda {
namespace {

// How far out of its neighbour's plane, in parts of the largest coordinate, a face may stand and still be
// called flat: a few roundings of vertices that were turned and shifted.
constexpr double flat_share = 1e-13;

struct EdgeUse {
  std::int32_t low = 0, high = 0;
  bool is_forward = true;
  std::int32_t triangle = 0;
  int slot = 0;
};

std::vector<EdgeUse> sorted_uses(const GapSurface& surface)
{
  std::vector<EdgeUse> uses;
  uses.reserve(3 * surface.triangles.size());
  for (const std::int32_t t : surface.triangles) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from = surface.mesh.triangles(t, k), to = surface.mesh.triangles(t, (k + 1) % 3);
      uses.push_back({std::min(from, to), std::max(from, to), from < to, t, k});
    }
  }
  std::sort(uses.begin(), uses.end(), [](const EdgeUse& l, const EdgeUse& r) {
    return std::pair(l.low, l.high) != std::pair(r.low, r.high)
               ? std::pair(l.low, l.high) < std::pair(r.low, r.high)
               : std::pair(l.triangle, l.slot) < std::pair(r.triangle, r.slot);
  });
  return uses;
}

// Does face g's far corner stand below the plane of f by more than rounding? Then the edge sticks out.
bool sticks_out(const GapSurface& surface, const EdgeUse& f, const EdgeUse& g, double flat_mm)
{
  const Eigen::Vector3d normal = surface.face_normals.row(f.triangle);
  const std::int32_t far = surface.mesh.triangles(g.triangle, (g.slot + 2) % 3);
  const Eigen::Vector3d across = surface.mesh.vertices_mm.row(far) - surface.mesh.vertices_mm.row(f.low);
  return normal.dot(across) < -flat_mm;
}

bool is_degenerate(const GapSurface& surface, const EdgeUse& use)
{
  return surface.face_normals.row(use.triangle).isZero(0.0);
}

}  // namespace

GapSurface gap_surface(const Mesh& mesh, std::vector<std::int32_t> triangles)
{
  GapSurface surface;
  surface.mesh = mesh;
  std::sort(triangles.begin(), triangles.end());
  surface.triangles = std::move(triangles);
  surface.face_normals.resize(mesh.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    surface.face_normals.row(t) = face_normal(mesh, t).transpose();
  }
  surface.neighbours.assign(static_cast<std::size_t>(mesh.triangles.rows()), {-1, -1, -1});
  const double flat_mm =
      mesh.vertices_mm.rows() > 0 ? flat_share * mesh.vertices_mm.cwiseAbs().maxCoeff() : 0.0;
  const std::vector<EdgeUse> uses = sorted_uses(surface);
  for (std::size_t i = 0; i + 1 < uses.size(); ++i) {
    const EdgeUse &f = uses[i], &g = uses[i + 1];
    const auto same = [&uses, &f](std::size_t k) {
      return k < uses.size() && uses[k].low == f.low && uses[k].high == f.high;
    };
    if (!same(i + 1)) continue;
    const bool is_pair = !same(i + 2) && (i == 0 || !same(i - 1));
    if (!is_pair || f.is_forward == g.is_forward || is_degenerate(surface, f) || is_degenerate(surface, g)) {
      continue;
    }
    if (sticks_out(surface, f, g, flat_mm) || sticks_out(surface, g, f, flat_mm)) continue;
    surface.neighbours[static_cast<std::size_t>(f.triangle)][static_cast<std::size_t>(f.slot)] = g.triangle;
    surface.neighbours[static_cast<std::size_t>(g.triangle)][static_cast<std::size_t>(g.slot)] = f.triangle;
  }
  return surface;
}

unsigned touching_edges(const GapSurface& surface, std::int32_t triangle, const std::vector<bool>& counts)
{
  unsigned edges = 0;
  for (unsigned k = 0; k < 3; ++k) {
    const std::int32_t across = surface.neighbours[static_cast<std::size_t>(triangle)][k];
    if (across < 0 || !counts[static_cast<std::size_t>(across)]) edges |= 1U << k;
  }
  return edges;
}

}  // namespace vrda
