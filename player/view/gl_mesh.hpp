/// OpenGL buffers of meshes, and their levels of detail.
#pragma once

#include <array>
#include <cstdint>
#include <future>
#include <vector>

#include "model/mesh.hpp"
#include "view/gl_table.hpp"
#include "view/renderer.hpp"
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

// Draws the surfaces of a scene with its materials, lights and draw mode.

enum class SurfacePass {
  opaque,             ///< colour and depth of opaque surfaces
  translucent_store,  ///< fragments of translucent surfaces, to the lists of gl_translucency.hpp
  translucent_depth,  ///< depth of translucent surfaces in front of the depth texture in unit 0
  translucent_colour  ///< translucent surfaces, blended over the frame buffer
};

/// Rectangle in OpenGL pixels: y from the bottom.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;

  bool is_empty() const { return width <= 0 || height <= 0; }
};
/// The smallest box around both; an empty one counts as nothing.
PixelBox bounding_box(const PixelBox& a, const PixelBox& b);

struct SurfaceOptions {
  double coarseness_px = 0.0;        ///< as in RenderOptions
  bool has_deferred_levels = false;  ///< as in RenderOptions
};

class SurfacePainter {
 public:
  SurfacePainter(const GlTable& gl, const SurfaceOptions& options);
  ~SurfacePainter();

  void load(const view::Scene& scene);
  /// Uploads drawables with a new revision. The scene must have the loaded drawables.
  void refresh(const view::Scene& scene);
  /// Sets camera, lights and mode for the following passes; `view` is the viewport.
  void begin(const view::Scene& scene, const view::Camera& camera, const PixelBox& view,
             bool is_multisampled);
  void draw(const view::Scene& scene, SurfacePass pass);
  /// Bounds of the translucent surfaces within the viewport; empty without such surfaces.
  const PixelBox& translucent_box() const { return translucent_box_; }
  /// Bounds of all shown surfaces within the viewport; the whole viewport for lines, which are wider.
  const PixelBox& content_box() const { return content_box_; }

 private:
  struct Uniforms {
    int X_camera_mesh = -1, projection = -1, colour = -1, opacity = -1, specular = -1, shininess = -1,
        mottling = -1, up_camera = -1, sky = -1, ground = -1, light_direction = -1, light_colour = -1,
        behind = -1, image = -1, repeats_by_mm = -1, depth_offset_mm = -1;
  };
  struct Program {
    unsigned id = 0;
    Uniforms at;
    std::uint64_t n_begun = 0;  ///< number of the shot whose uniforms are set
  };
  enum class Shading { smooth, mottled, textured, flat, lines, depth };
  static constexpr std::size_t n_shadings = 6;
  struct Variant {
    Shading shading = Shading::smooth;
    bool is_coloured = false;  ///< by vertex
    bool is_stored = false;    ///< to the fragment lists
    bool is_vertex_lit = false;
    bool is_multisampled = false;  ///< Shading::depth only
  };

  Shading shading_of(const view::Drawable& drawable) const;
  double allowed_error_mm(const view::Drawable& drawable) const;
  bool is_translucent(const view::Drawable& drawable, const GpuMesh& mesh) const;
  Program& compiled(const Variant& variant);
  void set_shot(Program& program);
  void set_material(const Program& program, const view::Drawable& drawable, Shading shading);
  void draw_one(const view::Drawable& drawable, const GpuMesh& mesh, Variant variant);
  void draw_lines(const view::Scene& scene);
  void find_levels(const view::Scene& scene);
  void take_levels();
  void load_texture(const view::Texture& texture);
  PixelBox bounds(const view::Scene& scene, const PixelBox& view, bool is_only_translucent) const;

  const GlTable& gl_;
  SurfaceOptions options_;
  std::vector<GpuMesh> meshes_;
  std::future<std::vector<MeshLevels>> levels_;  ///< one entry per mesh, while being computed
  static constexpr std::size_t n_variants = n_shadings * 16 * (view::most_lights + 1);
  /// Indexed by variant and number of lights; compiled on first use.
  std::array<Program, n_variants> programs_{};
  std::uint64_t n_begun_ = 0;
  view::DrawMode mode_ = view::DrawMode::smooth;
  bool is_multisampled_ = false;
  const view::Lighting* lighting_ = nullptr;  ///< of the scene of begin()
  unsigned texture_ = 0;
  float repeats_by_mm_ = 0.0F;  ///< texture tiles per mm; 0 without a texture
  Eigen::Vector3f line_shade_{1.0F, 1.0F, 1.0F};
  Pose X_camera_world_ = Pose::Identity();
  double px_mm_at_1_mm_ = 0.0;  ///< pixels per mm, times the depth in mm
  double near_mm_ = 1.0;
  Eigen::Matrix4f projection_ = Eigen::Matrix4f::Identity();
  PixelBox translucent_box_, content_box_;
};

}  // namespace vrda::view
