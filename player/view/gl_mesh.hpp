/// OpenGL buffers of meshes, and their levels of detail.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "model/render_mesh.hpp"
#include "view/gl_table.hpp"
#include "view/scene.hpp"

namespace vrda::view {

struct DetailLevel {
  std::vector<std::uint32_t> triangles;  ///< three vertex indices per triangle
  double error_mm = 0.0;                 ///< distance of its surface from the full mesh
};

using MeshLevels = std::vector<DetailLevel>;

/// Level 0 is `mesh` in an order optimised for vertex caches; each further level has clearly fewer triangles
/// and a larger error.
MeshLevels levels_of(const RenderMesh& mesh);

/// True if back faces are invisible from outside: with coincident vertices merged, every edge has equally
/// many triangles in both directions, and the enclosed volume is positive.
bool is_closed(const RenderMesh& mesh);

/// The range of indices of one level of detail.
struct IndexRun {
  std::size_t first = 0;
  int n = 0;
  double error_mm = 0.0;
};

struct GpuMesh {
  unsigned vertex_array = 0;
  std::array<unsigned, 3> buffers{};  ///< vertices, triangles, colours
  std::size_t n_vertices = 0;         ///< capacity
  std::size_t n_indices = 0;          ///< capacity
  std::vector<IndexRun> levels;       ///< the full mesh, then coarser ones
  std::uint64_t revision = 0;
  bool is_changed = false;  ///< since the upload
  bool is_closed = false;   ///< its back faces can be culled while it is opaque
  bool has_colours = false;
  bool has_translucent_colours = false;
};

GpuMesh upload_mesh(const GlTable& gl, const view::Drawable& drawable);
/// Uploads the coarser levels, if there are any and the mesh is unchanged since its upload.
void add_levels(const GlTable& gl, const MeshLevels& levels, GpuMesh& mesh);
/// Uploads a new revision. Throws InternalError if the mesh is larger than at its upload.
void refresh(const GlTable& gl, const view::Drawable& drawable, GpuMesh& mesh);
void release_mesh(const GlTable& gl, GpuMesh& mesh);
/// Draws the coarsest level within the allowed error.
void draw(const GlTable& gl, const GpuMesh& mesh, double allowed_error_mm);

}  // namespace vrda::view
