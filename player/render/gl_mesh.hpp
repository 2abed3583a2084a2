/// Meshes in the memory of OpenGL.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "render/detail.hpp"
#include "render/gl_table.hpp"
#include "scene/scene.hpp"

namespace vrda {

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
