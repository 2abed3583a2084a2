/// Meshes in the memory of OpenGL, and their levels of detail.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/draw_mesh.hpp"
#include "render/gl_table.hpp"
#include "scene/scene.hpp"

namespace vrda {

struct DetailLevel {
  std::vector<std::uint32_t> triangles;  ///< three indices of the mesh's vertices each
  double error_mm = 0.0;                 ///< how far its surface may lie from the mesh's
};

using MeshLevels = std::vector<DetailLevel>;

/// `mesh` in an order that suits graphics hardware, then coarser levels, each with clearly fewer triangles
/// and a larger error than the one before.
MeshLevels levels_of(const DrawMesh& mesh);

/// Whether nothing of the inside can be seen from outside: vertices at one place taken as one, every edge has
/// as many triangles one way as the other, and the triangles enclose a positive volume.
bool is_closed(const DrawMesh& mesh);

/// A run of indices that draws the mesh to within an error.
struct IndexRun {
  std::size_t first = 0;
  int n = 0;
  double error_mm = 0.0;
};

struct GpuMesh {
  unsigned vertex_array = 0;
  std::array<unsigned, 3> buffers{};  ///< vertices, triangles, colours
  std::size_t n_vertices = 0;         ///< there is room for
  std::size_t n_indices = 0;          ///< there is room for
  std::vector<IndexRun> levels;       ///< the whole mesh, then coarser ones
  std::uint64_t revision = 0;
  bool is_changed = false;  ///< since it was uploaded
  bool is_closed = false;   ///< its back faces need no drawing while it is opaque
  bool has_colours = false;
  bool has_translucent_colours = false;
};

GpuMesh uploaded(const GlTable& gl, const Drawable& drawable);
/// Gives the mesh its coarser levels, when there are some and it is still the one that was uploaded.
void add_levels(const GlTable& gl, const MeshLevels& levels, GpuMesh& mesh);
/// Takes a new revision over. A mesh larger than the one uploaded is a broken promise.
void refresh(const GlTable& gl, const Drawable& drawable, GpuMesh& mesh);
void drop(const GlTable& gl, GpuMesh& mesh);
/// The coarsest level within the error allowed.
void draw(const GlTable& gl, const GpuMesh& mesh, double allowed_error_mm);

}  // namespace vrda
