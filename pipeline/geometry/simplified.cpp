#include "geometry/simplified.hpp"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "geometry/nearest_surface.hpp"

namespace vrda::geometry {
namespace {

using Positions = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;

// The listed triangles with their vertices, in the order of the mesh.
Mesh with_triangles(const Mesh& mesh, const std::vector<std::int32_t>& corner)
{
  std::vector<std::int32_t> row(static_cast<std::size_t>(mesh.vertices_mm.rows()), -1);
  for (const std::int32_t v : corner) row[static_cast<std::size_t>(v)] = 0;
  std::vector<Eigen::Index> kept;
  for (std::size_t v = 0; v < row.size(); ++v) {
    if (row[v] < 0) continue;
    row[v] = static_cast<std::int32_t>(kept.size());
    kept.push_back(static_cast<Eigen::Index>(v));
  }
  Mesh fewer;
  fewer.vertices_mm = mesh.vertices_mm(kept, Eigen::all);
  fewer.triangles.resize(static_cast<Eigen::Index>(corner.size() / 3), 3);
  for (std::size_t k = 0; k < corner.size(); ++k)
    fewer.triangles.data()[k] = row[static_cast<std::size_t>(corner[k])];
  fewer.normals = vertex_normals(fewer);
  return fewer;
}

// The library computes in single precision: over a whole tibia its errors are 0.1 mm.
constexpr double cell_mm = 40.0;

std::map<std::array<int, 3>, std::vector<Eigen::Index>> cells_of(const Mesh& mesh)
{
  std::map<std::array<int, 3>, std::vector<Eigen::Index>> cells;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    const Eigen::Array3d at = ((a + b + c).array() / (3.0 * cell_mm)).floor();
    cells[{static_cast<int>(at[0]), static_cast<int>(at[1]), static_cast<int>(at[2])}].push_back(t);
  }
  return cells;
}

// Appends the corners of what is left of some triangles; their common border stays.
void add_simplified(const Mesh& mesh, const std::vector<Eigen::Index>& triangles, double kept,
                    double error_mm, std::vector<std::int32_t>& corner)
{
  std::vector<std::int32_t> row;  // of the mesh
  for (const Eigen::Index t : triangles) {
    for (const std::int32_t v : mesh.triangles.row(t)) row.push_back(v);
  }
  std::vector<std::int32_t> used = row;
  std::sort(used.begin(), used.end());
  used.erase(std::unique(used.begin(), used.end()), used.end());
  std::vector<std::uint32_t> all, fewer(row.size());
  for (const std::int32_t v : row)
    all.push_back(static_cast<std::uint32_t>(std::lower_bound(used.begin(), used.end(), v) - used.begin()));
  const Points at_mm = mesh.vertices_mm(used, Eigen::all);
  const Positions positions = (at_mm.rowwise() - at_mm.row(0)).cast<float>();
  constexpr std::size_t stride = 3 * sizeof(float);
  const float extent_mm = meshopt_simplifyScale(positions.data(), used.size(), stride);
  fewer.resize(meshopt_simplify(fewer.data(), all.data(), all.size(), positions.data(), used.size(), stride,
                                static_cast<std::size_t>(kept * static_cast<double>(all.size())),
                                static_cast<float>(error_mm) / extent_mm, meshopt_SimplifyLockBorder,
                                nullptr));
  for (const std::uint32_t v : fewer) corner.push_back(used[v]);
}

double largest_distance_mm(const Mesh& from, const Mesh& to)
{
  constexpr Eigen::Index n_samples = 20'000;
  const NearestSurface surface(to);
  const Eigen::Index step = 1 + from.vertices_mm.rows() / n_samples;
  double largest_mm = 0.0;
  for (Eigen::Index v = 0; v < from.vertices_mm.rows(); v += step)
    largest_mm = std::max(largest_mm, surface.nearest(from.vertices_mm.row(v)).distance_mm);
  return largest_mm;
}

}  // namespace

std::optional<SimplifiedMesh> simplified(const Mesh& mesh, Eigen::Index n_wanted, double largest_mm)
{
  if (mesh.triangles.rows() <= n_wanted) return std::nullopt;
  const double kept = static_cast<double>(n_wanted) / static_cast<double>(mesh.triangles.rows());
  const auto cells = cells_of(mesh);
  // Its error is a mean over the planes around a vertex: the largest distance is some times that.
  for (double error_mm = 0.5 * largest_mm; error_mm > 0.05 * largest_mm; error_mm *= 0.5) {
    std::vector<std::int32_t> corner;
    for (const auto& [cell, triangles] : cells) add_simplified(mesh, triangles, kept, error_mm, corner);
    if (static_cast<Eigen::Index>(corner.size()) == mesh.triangles.size()) break;
    SimplifiedMesh out{with_triangles(mesh, corner)};
    out.largest_mm = largest_distance_mm(mesh, out.mesh);
    if (out.largest_mm <= largest_mm) return out;
  }
  return std::nullopt;
}

}  // namespace vrda::geometry
