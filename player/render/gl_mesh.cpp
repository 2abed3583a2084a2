#include "render/gl_mesh.hpp"

#include <GL/glcorearb.h>

#include <algorithm>
#include <cstddef>

#include "core/error.hpp"
#include "render/detail.hpp"

namespace vrda {
namespace {

template <class T>
GLsizeiptr bytes_of(const std::vector<T>& items)
{
  return static_cast<GLsizeiptr>(items.size() * sizeof(T));
}

void upload_colours(const GlTable& gl, const Drawable& drawable, GpuMesh& mesh)
{
  const std::vector<VertexColour>& colours = drawable.colours;
  check(colours.empty() || colours.size() == drawable.mesh.vertices.size(), "a vertex has one colour");
  mesh.has_colours = !colours.empty();
  mesh.has_translucent_colours =
      std::any_of(colours.begin(), colours.end(), [](const VertexColour& colour) { return colour[3] < 255; });
  if (colours.empty()) return;
  gl.BindBuffer(GL_ARRAY_BUFFER, mesh.buffers[2]);
  gl.BufferData(GL_ARRAY_BUFFER, bytes_of(colours), colours.data(), GL_DYNAMIC_DRAW);
  gl.EnableVertexAttribArray(2);
  gl.VertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(VertexColour), nullptr);
}

}  // namespace

GpuMesh uploaded(const GlTable& gl, const Drawable& drawable)
{
  const DrawMesh& mesh = drawable.mesh;
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
  constexpr GLsizei stride = sizeof(DrawVertex);
  gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, stride, nullptr);
  gl.VertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(DrawVertex, normal)));
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

void refresh(const GlTable& gl, const Drawable& drawable, GpuMesh& mesh)
{
  if (drawable.revision == mesh.revision) return;
  const DrawMesh& changed = drawable.mesh;
  check(changed.vertices.size() <= mesh.n_vertices && changed.triangles.size() <= mesh.n_indices,
        "a mesh of a new revision is no larger than the one loaded");
  gl.BindVertexArray(mesh.vertex_array);
  gl.BindBuffer(GL_ARRAY_BUFFER, mesh.buffers[0]);
  gl.BufferSubData(GL_ARRAY_BUFFER, 0, bytes_of(changed.vertices), changed.vertices.data());
  gl.BufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, bytes_of(changed.triangles), changed.triangles.data());
  upload_colours(gl, drawable, mesh);
  // Into the room of the first level; its coarser ones are no longer of this mesh.
  mesh.is_changed = true;
  mesh.is_closed = false;
  mesh.levels.resize(1);
  mesh.levels[0].n = static_cast<int>(changed.triangles.size());
  mesh.revision = drawable.revision;
}

void drop(const GlTable& gl, GpuMesh& mesh)
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

}  // namespace vrda
