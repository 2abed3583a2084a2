#include "view/gl_mesh.hpp"

#include <GL/glcorearb.h>
#include <meshoptimizer.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstddef>
#include <numeric>

#include "core/error.hpp"

namespace vrda::view {
namespace {

/// From half a pixel in a close-up (20 pixels per mm) to half a pixel of a whole leg, in steps of sqrt(2).
constexpr std::array<double, 9> target_error_mm{0.03, 0.042, 0.06, 0.085, 0.12, 0.17, 0.25, 0.35, 0.5};

/// Smaller meshes have negligible cost and get no levels.
constexpr std::size_t least_triangles = 500;

/// A level is kept if it has at most this fraction of the previous level's triangles.
constexpr double largest_fraction = 0.8;

std::vector<std::uint32_t> cache_ordered(const std::vector<std::uint32_t>& triangles, std::size_t n_vertices)
{
  std::vector<std::uint32_t> ordered(triangles.size());
  meshopt_optimizeVertexCache(ordered.data(), triangles.data(), triangles.size(), n_vertices);
  return ordered;
}

/// For each vertex, the lowest-numbered vertex with the same position.
std::vector<std::uint32_t> merged_vertices(const RenderMesh& mesh)
{
  std::vector<std::uint32_t> order(mesh.vertices.size()), merged(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0U);
  const auto position = [&](std::uint32_t i) { return mesh.vertices[i].position_mm; };
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    return position(a) != position(b) ? position(a) < position(b) : a < b;
  });
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool is_new = i == 0 || position(order[i]) != position(order[i - 1]);
    merged[order[i]] = is_new ? order[i] : merged[order[i - 1]];
  }
  return merged;
}

double volume_mm3(const RenderMesh& mesh)
{
  double six_volumes_mm3 = 0.0;
  const auto corner_mm = [&](std::size_t i) {
    return Eigen::Map<const Eigen::Vector3f>(mesh.vertices[mesh.triangles[i]].position_mm.data())
        .cast<double>()
        .eval();
  };
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
    six_volumes_mm3 += corner_mm(i).dot(corner_mm(i + 1).cross(corner_mm(i + 2)));
  return six_volumes_mm3 / 6.0;
}

}  // namespace

MeshLevels levels_of(const RenderMesh& mesh)
{
  MeshLevels levels;
  const std::size_t n_vertices = mesh.vertices.size();
  levels.push_back({cache_ordered(mesh.triangles, n_vertices), 0.0});
  if (mesh.triangles.size() < 3 * least_triangles) return levels;
  const float* const positions = mesh.vertices.front().position_mm.data();
  // meshoptimizer's errors are relative to the mesh's extent.
  const double extent_mm = meshopt_simplifyScale(positions, n_vertices, sizeof(RenderVertex));
  for (const double wanted_mm : target_error_mm) {
    // Simplify the full mesh each time: errors of successive simplification add up, and a level within 0.085
    // mm would have three times the triangles.
    std::vector<std::uint32_t> fewer(mesh.triangles.size());
    float error = 0.0F;
    fewer.resize(meshopt_simplify(fewer.data(), mesh.triangles.data(), mesh.triangles.size(), positions,
                                  n_vertices, sizeof(RenderVertex), 0,
                                  static_cast<float>(wanted_mm / extent_mm), 0, &error));
    const auto n_before = static_cast<double>(levels.back().triangles.size());
    if (static_cast<double>(fewer.size()) > largest_fraction * n_before) continue;
    levels.push_back({cache_ordered(fewer, n_vertices), static_cast<double>(error) * extent_mm});
  }
  return levels;
}

bool is_closed(const RenderMesh& mesh)
{
  const std::vector<std::uint32_t> merged = merged_vertices(mesh);
  // Edges with the smaller vertex first; the sign is the original direction.
  struct Edge {
    std::uint32_t low, high;
    int sign;
  };
  std::vector<Edge> edges;
  edges.reserve(mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::size_t next = i % 3 == 2 ? i - 2 : i + 1;
    const std::uint32_t a = merged[mesh.triangles[i]], b = merged[mesh.triangles[next]];
    edges.push_back({std::min(a, b), std::max(a, b), a < b ? 1 : -1});
  }
  std::ranges::sort(
      edges, [](const Edge& a, const Edge& b) { return a.low != b.low ? a.low < b.low : a.high < b.high; });
  int balance = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    balance += edges[i].sign;
    const bool is_last =
        i + 1 == edges.size() || edges[i + 1].low != edges[i].low || edges[i + 1].high != edges[i].high;
    if (is_last && balance != 0) return false;
  }
  return volume_mm3(mesh) > 0.0;
}

namespace {

template <class T>
GLsizeiptr bytes_of(const std::vector<T>& items)
{
  return static_cast<GLsizeiptr>(items.size() * sizeof(T));
}

void upload_colours(const GlTable& gl, const view::Drawable& drawable, GpuMesh& mesh)
{
  const std::vector<view::VertexColour>& colours = drawable.colours;
  check(colours.empty() || colours.size() == drawable.mesh.vertices.size(), "there is one colour per vertex");
  mesh.has_colours = !colours.empty();
  mesh.has_translucent_colours =
      std::ranges::any_of(colours, [](const view::VertexColour& colour) { return colour[3] < 255; });
  if (colours.empty()) return;
  gl.BindBuffer(GL_ARRAY_BUFFER, mesh.buffers[2]);
  gl.BufferData(GL_ARRAY_BUFFER, bytes_of(colours), colours.data(), GL_DYNAMIC_DRAW);
  gl.EnableVertexAttribArray(2);
  gl.VertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(view::VertexColour), nullptr);
}

}  // namespace

GpuMesh upload_mesh(const GlTable& gl, const view::Drawable& drawable)
{
  const RenderMesh& mesh = drawable.mesh;
  GpuMesh gpu;
  gl.GenVertexArrays(1, &gpu.vertex_array);
  gl.GenBuffers(static_cast<GLsizei>(gpu.buffers.size()), gpu.buffers.data());
  gl.BindVertexArray(gpu.vertex_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, gpu.buffers[0]);
  gl.BufferData(GL_ARRAY_BUFFER, bytes_of(mesh.vertices), mesh.vertices.data(), GL_STATIC_DRAW);
  gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, gpu.buffers[1]);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, bytes_of(mesh.triangles), mesh.triangles.data(), GL_STATIC_DRAW);
  gpu.levels.push_back({0, static_cast<int>(mesh.triangles.size()), 0.0});
  gl.EnableVertexAttribArray(0);
  gl.EnableVertexAttribArray(1);
  constexpr GLsizei stride = sizeof(RenderVertex);
  gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, stride, nullptr);
  gl.VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(RenderVertex, normal)));
  upload_colours(gl, drawable, gpu);
  gpu.n_vertices = mesh.vertices.size();
  gpu.n_indices = mesh.triangles.size();
  gpu.revision = drawable.revision;
  gpu.is_closed = is_closed(mesh);
  return gpu;
}

void add_levels(const GlTable& gl, const MeshLevels& levels, GpuMesh& mesh)
{
  if (mesh.is_changed || levels.size() < 2) return;
  mesh.levels.clear();
  std::vector<std::uint32_t> indices;
  for (const DetailLevel& level : levels) {
    mesh.levels.push_back({indices.size(), static_cast<int>(level.triangles.size()), level.error_mm});
    indices.insert(indices.end(), level.triangles.begin(), level.triangles.end());
  }
  gl.BindVertexArray(mesh.vertex_array);
  gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, bytes_of(indices), indices.data(), GL_STATIC_DRAW);
}

void refresh(const GlTable& gl, const view::Drawable& drawable, GpuMesh& mesh)
{
  if (drawable.revision == mesh.revision) return;
  const RenderMesh& changed = drawable.mesh;
  check(changed.vertices.size() <= mesh.n_vertices && changed.triangles.size() <= mesh.n_indices,
        "a new revision of a mesh is not larger than at its upload");
  gl.BindVertexArray(mesh.vertex_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, mesh.buffers[0]);
  gl.BufferSubData(GL_ARRAY_BUFFER, 0, bytes_of(changed.vertices), changed.vertices.data());
  gl.BufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, bytes_of(changed.triangles), changed.triangles.data());
  upload_colours(gl, drawable, mesh);
  // Only the full level is overwritten; the coarser ones are invalid now.
  mesh.is_changed = true;
  mesh.is_closed = false;
  mesh.levels.resize(1);
  mesh.levels[0].n = static_cast<int>(changed.triangles.size());
  mesh.revision = drawable.revision;
}

void release_mesh(const GlTable& gl, GpuMesh& mesh)
{
  gl.DeleteVertexArrays(1, &mesh.vertex_array);
  gl.DeleteBuffers(static_cast<GLsizei>(mesh.buffers.size()), mesh.buffers.data());
  mesh = {};
}

void draw(const GlTable& gl, const GpuMesh& mesh, double allowed_error_mm)
{
  const IndexRun* chosen = mesh.levels.data();
  for (const IndexRun& level : mesh.levels) {
    if (level.error_mm <= allowed_error_mm) chosen = &level;
  }
  gl.BindVertexArray(mesh.vertex_array);
  gl.DrawElements(GL_TRIANGLES, chosen->n, GL_UNSIGNED_INT,
                  buffer_offset(chosen->first * sizeof(std::uint32_t)));
}

}  // namespace vrda::view
