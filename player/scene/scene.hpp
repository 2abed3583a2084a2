/// The drawables of a joint and where they stand.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/draw_mesh.hpp"
#include "core/mesh.hpp"
#include "motion/poses.hpp"
#include "scene/lighting.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// Repeated over a surface, seen along each of the three axes of its mesh and mixed by the normal
/// (triplanar), so that it needs no coordinates of its own and moves with the mesh.
struct Texture {
  int width = 0;  ///< pixels; 0: no texture
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< [height * width * 3] sRGB, top row first
  double scale_mm = 40.0;         ///< width of one repeat

  bool is_empty() const { return rgb.empty(); }
};

/// The object whose frame a drawable hangs in.
enum class Owner { reference, moving, world };

/// What a drawable belongs to; all but the bodies come and go on demand.
enum class Layer { bodies, contacts, normals, axes, helical_axis, gap_map, ligaments };

/// sRGB with straight alpha.
using VertexColour = std::array<std::uint8_t, 4>;

struct Drawable {
  std::string name;
  Layer layer = Layer::bodies;
  Owner owner = Owner::reference;
  bool is_shown = true;
  bool has_contact = true;            ///< false: drawn only
  DrawMesh mesh;                      ///< relative to origin_mm
  std::vector<VertexColour> colours;  ///< one a vertex instead of the material's, or none
  std::uint64_t revision = 0;         ///< raised with every change of mesh or colours once loaded
  Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();  ///< canonical
  Box box_mm;                                           ///< of mesh, relative to origin_mm
  Material material;
  Pose X_world_mesh = Pose::Identity();
};

/// How bodies are drawn (thesis, appendix C); other layers are always smooth.
enum class DrawMode {
  wire,         ///< edges
  hidden_line,  ///< edges that nothing hides
  flat,         ///< one shade a triangle
  smooth,       ///< shaded by vertex normals
  textured      ///< smooth, with the bone's texture
};

struct Scene {
  std::vector<Drawable> drawables;
  Texture texture;  ///< of bone, in DrawMode::textured; without one bone is mottled
  DrawMode mode = DrawMode::textured;
  Lighting lighting = studio_lighting();
  Background background = background_of(Backdrop::studio);
};

/// Which object stands still on screen.
enum class Held { moving, reference };

/// The frames of a joint on screen: the reference under its attitude, the moving object under Delta's
/// frame and, within it, theta and the translation.
struct JointFrames {
  Pose X_world_reference = Pose::Identity();
  Pose X_world_delta = Pose::Identity();
  Pose X_delta_moving = Pose::Identity();
};

JointFrames frames_of(const JointPose& pose, Held held = Held::moving);

/// One drawable for each component of each part that has triangles. Placed as in the meshes' own frame
/// with the rotation centre at the origin.
Scene scene_of(const Body& reference, const Body& moving, const Eigen::Vector3d& rotation_centre_mm,
               double crease_rad = default_crease_rad);

/// Moves every drawable to its frame; those of the world's stay. Allocates nothing.
void place(Scene& scene, const JointFrames& frames);

struct Sphere {
  Eigen::Vector3d centre_world_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;
};

/// Bodies that are shown: a picture needs room for them, and for nothing else.
bool is_framed(const Drawable& drawable);

/// The place where the objects meet, as placed: around the middle of the overlap of the bounding boxes of
/// their contact parts, as wide as `widths` times the larger width of that overlap across world Y. Hidden
/// bodies count: the joint is where it is.
Sphere joint_sphere(const Scene& scene, double widths = 0.85);

/// The vertices of the bodies, as placed, within the sphere; every one of theirs when none is.
std::vector<Eigen::Vector3d> points_within(const Scene& scene, const Sphere& sphere);

/// How large signs are drawn: 1 for a knee, whose plateaus are 80 mm wide.
double sign_scale(const MotionModel& model);

/// The cells whose values set a scale: the stable ones of the spine, where a joint is shown by default;
/// without any, every stable one.
std::vector<std::size_t> telling_cells(const MotionModel& model);

/// Appended hidden; its place in the scene is returned. It does not take part in contact.
std::size_t add_layer(Scene& scene, Layer layer, Owner owner, const std::string& name);

/// The material of signs: plain, opaque, a soft highlight.
Material sign_material(const VertexColour& colour);

/// The box of the vertices that the triangles use. Wanted after a mesh was changed.
void update_box(Drawable& drawable);

}  // namespace vrda
