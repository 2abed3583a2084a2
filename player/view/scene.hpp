/// Meshes of balls, rods, arrows and tubes, written to preallocated vertices.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/mesh.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"

namespace vrda::view {

/// Numbers of vertices and indices of one solid.
struct SolidSize {
  std::size_t n_vertices = 0;
  std::size_t n_indices = 0;
};

/// Vertices of a ring of a tube. Fibres are many and thin: with 12 the bench draws a tenth fewer frames.
inline constexpr std::size_t n_tube_sides = 8;

SolidSize ball_size();
SolidSize arrow_size();
SolidSize tube_size(std::size_t n_points);

/// Append `n` solids with all indices; only the vertices change afterwards. The triangles of the first k
/// solids are the first k * n_indices indices.
void add_balls(RenderMesh& mesh, std::size_t n);
void add_rods(RenderMesh& mesh, std::size_t n);
void add_arrows(RenderMesh& mesh, std::size_t n);
void add_tube(RenderMesh& mesh, std::size_t n_points);

/// Write the vertices of a solid from `first_vertex` on; allocate nothing. Lengths must be positive, mm.
void set_ball(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& centre_mm, double radius_mm);
/// A cylinder with flat ends.
void set_rod(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& from_mm,
             const Eigen::Vector3d& to_mm, double radius_mm);
/// `radius_mm` is the shaft radius; the head has three times the radius. Both are reduced for short arrows.
void set_arrow(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& from_mm,
               const Eigen::Vector3d& to_mm, double radius_mm);
/// A tube along at least two points, closed at both ends. Coincident points are allowed.
void set_tube(RenderMesh& mesh, std::size_t first_vertex, std::span<const Eigen::Vector3d> points_mm,
              double radius_mm);

/// The elliptic cross section of a band.
struct BandSection {
  double half_width_mm = 1.0, half_thickness_mm = 1.0;
  /// Directions of the width at both ends, of any length; between the ends they are interpolated. Zero or
  /// along the band: any direction.
  Eigen::Vector3d across_first{0, 0, 0}, across_last{0, 0, 0};
  double flare = 0.0;  ///< by which part the band is wider at its ends
};
/// A tube with an elliptic cross section, in the vertices of a tube.
void set_band(RenderMesh& mesh, std::size_t first_vertex, std::span<const Eigen::Vector3d> points_mm,
              const BandSection& section);

// Lights and backgrounds. Colours are linear RGB on [0, 1].

struct Light {
  Eigen::Vector3f towards_camera{0.0F, 0.0F, 1.0F};  ///< unit direction to the light in camera axes
  Eigen::Vector3f colour{1.0F, 1.0F, 1.0F};
};

/// Hemisphere light along world Y, plus directional lights attached to the camera.
struct Lighting {
  Eigen::Vector3f sky{0.2F, 0.2F, 0.2F};
  Eigen::Vector3f ground{0.1F, 0.1F, 0.1F};
  std::vector<Light> lights;  ///< at most 4
};
inline constexpr std::size_t most_lights = 4;

/// Vertical gradient.
struct Background {
  Eigen::Vector3f top{0.0F, 0.0F, 0.0F};
  Eigen::Vector3f bottom{0.0F, 0.0F, 0.0F};
};

/// Key light from the upper left, a cooler fill light, a rim light from behind.
Lighting studio_lighting();

enum class Backdrop {
  studio,  ///< light grey
  night,   ///< dark blue grey
  black,   ///< transparent on the bench's display
};
Background background_of(Backdrop backdrop);

struct Lights {
  Lighting lighting;
  std::optional<Background> background;  ///< if the file has one
};

/// Reads a TOML file (schemas/lights.md). Throws InputError naming the file and the key.
Lights read_lights(const std::string& path);

/// Parses the text of a lights file; `name` is used in errors.
Lights parsed_lights(const std::string& text, const std::string& name);

// The drawables of a joint and their placement.

/// A tiled texture with triplanar mapping: projected along the three mesh axes and blended by the normal, so
/// that it needs no texture coordinates and moves with the mesh.
struct Texture {
  int width = 0;  ///< pixels; 0: no texture
  int height = 0;
  std::vector<std::uint8_t> rgb;  ///< [height * width * 3] sRGB, top row first
  double scale_mm = 40.0;         ///< width of one tile

  bool is_empty() const { return rgb.empty(); }
};

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
  band,
  caps  ///< of solids cut by the scene's section; without a name
};

/// sRGB with straight alpha.
using VertexColour = std::array<std::uint8_t, 4>;

struct Drawable {
  std::string name;
  Layer layer = Layer::bodies;
  BodyIndex parent = BodyIndex::reference;  ///< to whose frame it is attached
  /// Id of the structure (schemas/view-state.md); empty: of none.
  std::string structure = {};
  bool is_hidden = false;  ///< by its structure, whatever its layer shows
  float highlight = 0.0F;  ///< glow, from 0 to 1
  bool is_shown = true;
  bool has_contact = true;  ///< false: visual part only
  /// Closed whatever its revision: it is culled where no section opens it, and lit at its vertices with
  /// vertex lighting.
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

/// A plane n . p = at_mm in the axes of the screen's world; n is a unit vector. What is on the camera's side
/// is not drawn and not picked.
struct SectionPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double at_mm = 0.0;
  bool operator==(const SectionPlane&) const = default;
};
/// Whether the section removes a point for a camera at `eye_mm`; world.
bool is_removed(const SectionPlane& section, const Eigen::Vector3d& p_mm, const Eigen::Vector3d& eye_mm);

struct Scene {
  std::vector<Drawable> drawables;
  std::optional<SectionPlane> section;
  std::string reference_name, moving_name;  ///< displayed: "femur", "tibia"
  Texture texture;                          ///< for bone in DrawMode::textured; if empty, bone is mottled
  DrawMode mode = DrawMode::textured;
  Lighting lighting = studio_lighting();
  /// Opaque surfaces are darkened where others within this distance cover the sky; 0: no ambient occlusion.
  double occlusion_radius_mm = 0.0;
  /// Closed opaque surfaces are lit at their vertices instead of every pixel: faster in software rendering.
  bool has_vertex_lighting = false;
  Background background = background_of(Backdrop::studio);
  /// Another joint, drawn with the lights, section and mode of this scene where a shot has it; or null.
  const Scene* other = nullptr;
};

/// What can be fixed on screen, in the order of the choices: an object, whose canonical axes are then those
/// of the screen's world, or the direction of push (world W), in which the reference has its attitude and the
/// moving object theta and translation.
inline constexpr std::array holdable{BodyIndex::moving, BodyIndex::reference, BodyIndex::world};
inline std::size_t held_row(BodyIndex held)
{
  return static_cast<std::size_t>(std::find(holdable.begin(), holdable.end(), held) - holdable.begin());
}

/// The frames of a displayed joint. The frame of a fixed object is the same for every pose, bit for bit.
struct JointFrames {
  Pose X_world_reference = Pose::Identity();
  Pose X_world_moving = Pose::Identity();
  Pose X_world_push = Pose::Identity();  ///< world W of the pose, for Delta and the axes
  /// Of bodies that follow the joint, by model::follower_row(); undefined where they have no pose.
  std::array<Pose, model::most_followers> X_world_follower{};
  std::array<bool, model::most_followers> has_follower{};

  bool has(BodyIndex body) const
  {
    return model::row_of(body) < 2 || has_follower.at(model::follower_row(body));
  }
  const Pose& of(BodyIndex body) const
  {
    return body == BodyIndex::reference ? X_world_reference
           : body == BodyIndex::moving  ? X_world_moving
                                        : X_world_follower.at(model::follower_row(body));
  }
};

/// `frames` with the followers of the pose.
JointFrames with_followers(JointFrames frames, const store::JointPose& pose);

/// A fixed object is drawn relative to the rotation centre, as the world W of the poses is.
JointFrames frames_of(const store::JointPose& pose, BodyIndex fixed = BodyIndex::world,
                      const Eigen::Vector3d& rotation_centre_mm = Eigen::Vector3d::Zero());
/// Where a grid has no pose, the frames of its attitude without coordinates.
JointFrames frames_of(const store::Motion& motion, const store::JointPose& pose,
                      BodyIndex fixed = BodyIndex::world,
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
/// Shows the bodies that `shown` says and that have a pose; without a pose of the joint only the fixed one,
/// or the reference. Allocates nothing.
void show_bodies(Scene& scene, const std::vector<bool>& shown, BodyIndex fixed, bool has_pose,
                 const JointFrames& frames);

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
std::size_t add_layer(Scene& scene, Layer layer, BodyIndex parent, const std::string& name);

/// The material of markers: plain, opaque, with a soft highlight.
Material marker_material(const VertexColour& colour);

/// Recomputes the box of the vertices used by the triangles; required after a change of the mesh.
void update_box(Drawable& drawable);

// Optional layers (contacts, forces, axes, gaps, ligaments) and colour palettes.

/// Evenly spaced colours from the lowest to the highest value.
using Palette = std::array<VertexColour, 11>;

/// The colour scale of a layer.
struct Legend {
  std::string title;  ///< with the unit: "strain, %"
  double lowest = 0.0;
  double highest = 1.0;
  Palette palette{};
  VertexColour below{};     ///< colour of values below the lowest
  std::string below_label;  ///< empty: no such colour
  std::optional<VertexColour>
      beyond;                ///< colour of values above the highest; without one, that of the highest
  std::string beyond_label;  ///< label for values above the highest
};

/// The colour of `value`, interpolated in the palette and clamped at its ends.
VertexColour colour_of(const Legend& legend, double value);

/// Linear interpolation from a (`part` = 0) to b (`part` = 1), in sRGB.
VertexColour interpolated_colour(const VertexColour& a, const VertexColour& b, double part);

/// Conversion of linear light to sRGB and back, both on [0, 1]; of a colour to opaque sRGB and back.
double srgb_of(double linear);
double linear_of(double srgb);
VertexColour srgb_from_linear(const Eigen::Vector3f& linear);
Eigen::Vector3f linear_from_srgb(const VertexColour& colour);

/// For gaps: bright is close, with uniformly decreasing lightness, also for colour-blind viewers.
/// Source: "plasma" of matplotlib (Smith and van der Walt, CC0).
const Palette& gap_palette();

/// For strains of taut fibres, from light orange to dark red; as on the page (schemas/view-state.md).
/// Source: "OrRd" of ColorBrewer (Brewer, Apache 2.0) without its palest colours.
const Palette& strain_palette();

inline constexpr std::size_t n_layers = 10;  // without the caps

class LayerSet {
 public:
  bool has(Layer layer) const { return is_on_[static_cast<std::size_t>(layer)]; }
  void set(Layer layer, bool is_on) { is_on_[static_cast<std::size_t>(layer)] = is_on; }
  bool operator==(const LayerSet&) const = default;

 private:
  std::array<bool, n_layers> is_on_{};
};

/// "contacts", "normals", "axes", "helical-axis", "gaps", "ligaments", "contact-paths", "labels", "band": the
/// names of Layer without the bodies.
const std::vector<std::string>& layer_names();
const std::string& name_of(Layer layer);  ///< not of the bodies
std::optional<Layer> layer_named(const std::string& name);

/// An entry of a colour key.
struct Label {
  std::string name;
  VertexColour colour{};
};

/// A pose to display, its frames, and the visible layers.
struct DisplayedPose {
  store::JointPose pose;
  JointFrames frames;  ///< of `pose`
  LayerSet layers;
};

/// The layers of one motion model in one scene. Built once; updating allocates nothing.
class JointLayers {
 public:
  /// Appends the layers' drawables, hidden, to `scene`, whose order must not change afterwards. Copies the
  /// required data of the model.
  JointLayers(const store::MotionModel& model, Scene& scene);
  ~JointLayers();
  JointLayers(JointLayers&&) noexcept;
  JointLayers& operator=(JointLayers&&) noexcept;

  /// Shows `shown.layers` at a pose of `motion` and hides the others (all if the pose is not solved). Must be
  /// called after place(), since it moves only the layers. A mesh and its revision change only if necessary;
  /// mesh sizes are constant.
  void update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown);

  /// The layers for which the model has data.
  const LayerSet& available() const { return available_; }
  /// The colour scale of the gap map (mm) or of the ligaments (percent).
  const Legend& legend(Layer layer) const;
  /// The colours of the axes: those of layer "axes", then of "helical-axis".
  static const std::vector<Label>& axis_labels();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
  LayerSet available_;
};

}  // namespace vrda::view
