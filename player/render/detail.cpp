#include "render/detail.hpp"

#include <meshoptimizer.h>

#include <array>

namespace vrda {
namespace {

/// From half a pixel of a close look (20 pixels a mm) to one of a whole leg.
constexpr std::array<double, 5> wanted_error_mm{0.03, 0.06, 0.12, 0.25, 0.5};

/// Below this many triangles a mesh costs next to nothing.
constexpr std::size_t least_triangles = 500;

/// A level is kept when it has less than this part of the triangles before it.
constexpr double worthwhile = 0.8;

std::vector<std::uint32_t> cache_ordered(const std::vector<std::uint32_t>& triangles, std::size_t n_vertices)
{
  std::vector<std::uint32_t> ordered(triangles.size());
  meshopt_optimizeVertexCache(ordered.data(), triangles.data(), triangles.size(), n_vertices);
  return ordered;
}

}  // namespace

std::vector<DetailLevel> levels_of(const DrawMesh& mesh)
{
  std::vector<DetailLevel> levels;
  const std::size_t n_vertices = mesh.vertices.size();
  levels.push_back({cache_ordered(mesh.triangles, n_vertices), 0.0});
  if (mesh.triangles.size() < 3 * least_triangles) return levels;
  const float* const positions = mesh.vertices.front().position_mm.data();
  // meshoptimizer measures errors as parts of the mesh's extent.
  const double extent_mm = meshopt_simplifyScale(positions, n_vertices, sizeof(DrawVertex));
  for (const double wanted_mm : wanted_error_mm) {
    const DetailLevel& last = levels.back();
    const double more_mm = wanted_mm - last.error_mm;  // each level is made from the last: errors add up
    if (more_mm <= 0.0) continue;
    std::vector<std::uint32_t> fewer(last.triangles.size());
    float error = 0.0F;
    fewer.resize(meshopt_simplify(fewer.data(), last.triangles.data(), last.triangles.size(), positions,
                                  n_vertices, sizeof(DrawVertex), 0, static_cast<float>(more_mm / extent_mm),
                                  0, &error));
    if (static_cast<double>(fewer.size()) > worthwhile * static_cast<double>(last.triangles.size())) continue;
    const double error_mm = last.error_mm + static_cast<double>(error) * extent_mm;
    levels.push_back({cache_ordered(fewer, n_vertices), error_mm});
  }
  return levels;
}

}  // namespace vrda
