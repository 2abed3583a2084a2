/// OpenGL buffers of meshes, and their levels of detail.
#pragma once

#include <Eigen/Geometry>

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

/// True if it has an inside: as above, except for a thousandth of the edges, since scanned bones have
/// defects.
bool is_solid(const RenderMesh& mesh);

/// Distance along a ray to the nearest triangle, in units of |direction|; infinite without a hit.
double nearest_hit(const RenderMesh& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& direction);

/// The range of indices of one level of detail.
struct IndexRun {
  std::size_t first = 0;
  int n = 0;
  double error_mm = 0.0;
};

struct GpuMesh {
  Geometry geometry;
  GlObject colours;                           ///< by vertex
  std::size_t n_vertices = 0;                 ///< capacity
  std::size_t n_indices = 0;                  ///< capacity
  std::vector<IndexRun> levels;               ///< the full mesh, then coarser ones
  std::vector<Eigen::AlignedBox3d> boxes_mm;  ///< of parts of the full mesh
  std::uint64_t revision = 0;
  bool is_changed = false;  ///< since the upload
  bool is_closed = false;   ///< its back faces can be culled while it is opaque
  bool has_colours = false;
  bool has_translucent_colours = false;
};

// Draws the surfaces of a scene with its materials, lights and draw mode.

enum class SurfacePass {
  opaque,       ///< colour and depth of opaque surfaces
  front_depth,  ///< depth of translucent surfaces
  /// Fragments of translucent surfaces in front of the depth texture in unit 2, to the fragment lists of
  /// gl_renderer.cpp.
  translucent_store,
  translucent_depth,  ///< depth of translucent surfaces between the depth textures in units 0 and 2
  translucent_colour  ///< translucent surfaces, blended over the frame buffer
};

struct SurfaceOptions {
  double coarseness_px = 0.0;        ///< as in RenderOptions
  bool has_deferred_levels = false;  ///< as in RenderOptions
};

/// Texture unit of the depth of the nearest surfaces of a structure.
inline constexpr int front_unit = 2;

class SurfacePainter {
 public:
  static constexpr std::size_t all_groups = static_cast<std::size_t>(-1);
  /// The translucent drawables of one structure, of which only the nearest surface is drawn: the shaft and
  /// the end of a bone overlap. A drawable without a structure is one of its own, and drawn completely.
  struct Group {
    std::size_t row = 0;
    bool is_structure = false;
    PixelBox box;  ///< within the viewport
  };
  SurfacePainter(const GlTable& gl, const SurfaceOptions& options) : gl_(gl), options_(options) {}

  void load(const Scene& scene);
  /// Uploads drawables with a new revision. The scene must have the loaded drawables.
  void refresh(const Scene& scene);
  /// Sets camera, lights and mode for the following passes; `view` is the viewport.
  void begin(const Scene& scene, const Shot& shot, const PixelBox& view, bool is_multisampled);
  void draw(const Scene& scene, SurfacePass pass, std::size_t group = all_groups);
  /// Of the shot of begin().
  const std::vector<Group>& translucent_groups() const { return translucent_groups_; }
  /// Bounds of the translucent surfaces within the viewport; empty without such surfaces.
  const PixelBox& translucent_box() const { return translucent_box_; }
  /// Bounds of all shown surfaces within the viewport; the whole viewport for lines, which are wider.
  const PixelBox& content_box() const { return content_box_; }

 private:
  struct Program {
    GlProgram linked;
    std::uint64_t n_begun = 0;  ///< number of the shot whose uniforms are set
  };
  enum class Shading { smooth, mottled, textured, flat, lines, depth, front };
  static constexpr std::size_t n_shadings = 7;
  struct Variant {
    Shading shading = Shading::smooth;
    bool is_coloured = false;  ///< by vertex
    bool is_stored = false;    ///< to the fragment lists
    bool is_vertex_lit = false;
    bool is_multisampled = false;  ///< Shading::depth only
  };

  /// That of meshes_[i]: those of the scene, then those of Scene::other.
  static const Drawable& drawable_of(const Scene& scene, std::size_t i);
  bool is_shown(const Scene& scene, std::size_t i) const;
  Shading shading_of(const Drawable& drawable) const;
  double allowed_error_mm(const Drawable& drawable) const;
  bool is_translucent(const Drawable& drawable, const GpuMesh& mesh) const;
  Program& compiled(const Variant& variant);
  void set_shot(Program& program);
  void set_material(const GlProgram& program, const Drawable& drawable, Shading shading);
  void draw_one(const Drawable& drawable, const GpuMesh& mesh, Variant variant);
  void draw_lines(const Scene& scene);
  void find_levels(const Scene& scene);
  void take_levels();
  void load_texture(const Texture& texture);
  PixelBox bounds(const Scene& scene, const PixelBox& view, bool is_only_translucent,
                  std::size_t group = all_groups) const;
  void find_groups(const Scene& scene, const PixelBox& view);

  const GlTable& gl_;
  SurfaceOptions options_;
  std::vector<GpuMesh> meshes_;
  std::vector<std::size_t> group_;  ///< [n_meshes]
  std::vector<Group> translucent_groups_;
  std::future<std::vector<MeshLevels>> levels_;  ///< one entry per mesh, while being computed
  static constexpr std::size_t n_variants = n_shadings * 16 * (most_lights + 1);
  /// Indexed by variant and number of lights; compiled on first use.
  std::array<Program, n_variants> programs_{};
  std::uint64_t n_begun_ = 0;
  DrawMode mode_ = DrawMode::smooth;
  bool is_multisampled_ = false, has_own_ = true, has_other_ = true;
  const Lighting* lighting_ = nullptr;  ///< of the scene of begin()
  GlObject texture_;
  float repeats_by_mm_ = 0.0F;  ///< texture tiles per mm; 0 without a texture
  Eigen::Vector3f line_shade_{1.0F, 1.0F, 1.0F};
  Pose X_camera_world_ = Pose::Identity();
  double px_mm_at_1_mm_ = 0.0;  ///< pixels per mm, times the depth in mm
  double near_mm_ = 1.0;
  bool has_section_ = false;
  Eigen::Vector3f section_normal_{0.0F, 0.0F, 0.0F};  ///< camera axes, towards the camera
  float section_at_mm_ = 1.0F;                        ///< along it, from the camera
  Eigen::Matrix4f projection_ = Eigen::Matrix4f::Identity();
  PixelBox translucent_box_, content_box_;
};

}  // namespace vrda::view
