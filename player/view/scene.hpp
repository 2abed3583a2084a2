/// The drawables of a joint and their placement.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "model/mesh.hpp"
#include "model/render_mesh.hpp"
#include "store/poses.hpp"
#include "view/lighting.hpp"
#include "store/motion_model.hpp"

namespace vrda::view {

/// A tiled texture with triplanar mapping: projected along the three mesh axes and blended by the normal, so
/// that it needs no texture coordinates and moves with the mesh.
struct Texture {
  int width = 0;  ///< pixels; 0: no texture
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< [height * width * 3] sRGB, top row first
  double scale_mm = 40.0;         ///< width of one tile

  bool is_empty() const { return rgb.empty(); }
};

/// The object to whose frame a drawable is attached.
enum class ParentFrame { reference, moving, world };

/// The layer of a drawable; all except the bodies are optional. Labels are drawn as text, without a drawable.
enum class Layer {
  bodies,
  contacts,
  normals,
  axes,
  helical_axis,
  gap_map,
  ligaments,
  contact_paths,
  labels,
  band
};

/// sRGB with straight alpha.
using VertexColour = std::array<std::uint8_t, 4>;

struct Drawable {
  std::string name;
  Layer layer = Layer::bodies;
  ParentFrame parent = ParentFrame::reference;
  bool is_shown = true;
  bool has_contact = true;  ///< false: visual part only
  /// Closed whatever its revision: with vertex lighting it is culled and lit at its vertices.
  bool is_solid = false;
  RenderMesh mesh;                    ///< relative to origin_mm
  std::vector<VertexColour> colours;  ///< one per vertex, replacing the material's colour; or empty
  std::uint64_t revision = 0;         ///< must be increased with every change of mesh or colours after load
  Eigen::Vector3d origin_mm = Eigen::Vector3d::Zero();  ///< canonical
  Eigen::AlignedBox3d box_mm{Eigen::Vector3d::Zero()};  ///< of the mesh, relative to origin_mm
  Material material;
  double depth_offset_mm = 0.0;  ///< hidden by surfaces that are less than this behind it
  Pose X_world_mesh = Pose::Identity();
};

/// Draw mode of bodies (thesis, appendix C); other layers are always smooth.
enum class DrawMode {
  wire,         ///< edges
  hidden_line,  ///< visible edges
  flat,         ///< one shade per triangle
  smooth,       ///< shaded by vertex normals
  textured      ///< smooth, with the bone's texture
};

struct Scene {
  std::vector<Drawable> drawables;
  std::string reference_name, moving_name;  ///< displayed: "femur", "tibia"
  Texture texture;                          ///< for bone in DrawMode::textured; if empty, bone is mottled
  DrawMode mode = DrawMode::textured;
  Lighting lighting = studio_lighting();
  /// Opaque surfaces are darkened where others within this distance cover the sky; 0: no ambient occlusion.
  double occlusion_radius_mm = 0.0;
  /// Closed opaque surfaces are lit at their vertices instead of every pixel: faster in software rendering.
  bool has_vertex_lighting = false;
  Background background = background_of(Backdrop::studio);
};

/// What is fixed on screen: an object, whose canonical axes are then those of the screen's world, or the
/// direction of push (world W), in which the reference has its attitude and the moving object theta and
/// translation.
enum class FixedObject { moving, reference, push };

/// The frames of a displayed joint. The frame of a fixed object is the same for every pose, bit for bit.
struct JointFrames {
  Pose X_world_reference = Pose::Identity();
  Pose X_world_moving = Pose::Identity();
  Pose X_world_push = Pose::Identity();  ///< world W of the pose, for Delta and the axes
};

/// A fixed object is drawn relative to the rotation centre, as the world W of the poses is.
JointFrames frames_of(const store::JointPose& pose, FixedObject fixed = FixedObject::push,
                      const Eigen::Vector3d& rotation_centre_mm = Eigen::Vector3d::Zero());
/// Where a grid has no pose, the frames of its attitude without coordinates.
JointFrames frames_of(const store::Motion& motion, const store::JointPose& pose,
                      FixedObject fixed = FixedObject::push,
                      const Eigen::Vector3d& rotation_centre_mm = Eigen::Vector3d::Zero());

/// One drawable per component of each part that has triangles, placed in the meshes' frame with the rotation
/// centre at the origin.
Scene scene_of(const Body& reference, const Body& moving, const Eigen::Vector3d& rotation_centre_mm);
/// The same of a model, whose objects have their displayed names.
Scene scene_of(const store::MotionModel& model, const Eigen::Vector3d& rotation_centre_mm);

/// Places every drawable in its parent's frame; those of the world are unchanged. Allocates nothing.
void place(Scene& scene, const JointFrames& frames);

/// [n_drawables] as the appearance has set them.
std::vector<bool> shown_drawables(const Scene& scene);
/// Shows the bodies that `shown` says; without a pose only the fixed one, or the reference. Allocates
/// nothing.
void show_bodies(Scene& scene, const std::vector<bool>& shown, FixedObject fixed, bool has_pose);

/// Places the drawable of a body whose meshes' frame is at `X_world_body`.
void place(Drawable& drawable, const Pose& X_world_body);

struct Sphere {
  Eigen::Vector3d centre_world_mm = Eigen::Vector3d::Zero();
  double radius_mm = 0.0;
};

/// True for visible bodies, to which cameras are fitted.
bool is_framed(const Drawable& drawable);

/// The region of contact at the present placement: a sphere about the centre of the overlap of the contact
/// parts' bounding boxes, with a radius of `widths` times the larger width of the overlap normal to world Y.
/// Includes hidden bodies.
Sphere joint_sphere(const Scene& scene, double widths = 0.85);

/// The world positions of the visible bodies' vertices within the sphere; all vertices if none exists.
std::vector<Eigen::Vector3d> points_within(const Scene& scene, const Sphere& sphere);

/// Scale factor for markers: 1 for a knee with a plateau width of 80 mm.
double marker_scale(const store::MotionModel& model);

/// The cells that determine colour and force scales: the stable cells of the spine, otherwise all stable
/// cells.
std::vector<std::size_t> informative_cells(const store::MotionModel& model);

/// Appends a hidden drawable without contact; returns its index.
std::size_t add_layer(Scene& scene, Layer layer, ParentFrame parent, const std::string& name);

/// The material of markers: plain, opaque, with a soft highlight.
Material marker_material(const VertexColour& colour);

/// Recomputes the box of the vertices used by the triangles; required after a change of the mesh.
void update_box(Drawable& drawable);

}  // namespace vrda::view
