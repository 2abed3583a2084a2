#include "view/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/schema.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "model/step_record.hpp"
#include "view/structures.hpp"

namespace vrda::view {
namespace {

constexpr std::size_t n_sides = 12;
constexpr std::size_t n_ball_rings = 9;
/// An arrow has pairs of rings for tail, shaft, back of the head and cone, each with its own normals.
constexpr std::size_t n_arrow_rings = 8, n_rod_rings = 6;

template <std::size_t n>
const std::array<SinCos, n>& circle()
{
  static const std::array<SinCos, n> points = [] {
    std::array<SinCos, n> made{};
    for (std::size_t k = 0; k < n; ++k)
      made[k] = sin_cos(static_cast<double>(k) * (2.0 * pi / static_cast<double>(n)));
    return made;
  }();
  return points;
}

/// Right-handed orthonormal frame: two directions across, one along.
struct Frame {
  Eigen::Vector3d u, v, along;
};

Frame frame_along(const Eigen::Vector3d& along)
{
  Eigen::Index least = 0;
  along.cwiseAbs().minCoeff(&least);
  const Eigen::Vector3d u = along.cross(Eigen::Vector3d::Unit(least)).normalized();
  return {u, along.cross(u), along};
}

struct Ring {
  Eigen::Vector3d centre_mm;
  double radius_mm = 0.0;
  double outward = 1.0;  ///< radial component of the normal
  double forward = 0.0;  ///< axial component of the normal
};

std::array<float, 3> single(const Eigen::Vector3d& v)
{
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

std::size_t set_ring(RenderMesh& mesh, std::size_t first_vertex, const Frame& frame, const Ring& ring)
{
  for (std::size_t k = 0; k < n_sides; ++k) {
    const SinCos& angle = circle<n_sides>()[k];
    const Eigen::Vector3d across = angle.cos * frame.u + angle.sin * frame.v;
    RenderVertex& vertex = mesh.vertices[first_vertex + k];
    vertex.position_mm = single(ring.centre_mm + ring.radius_mm * across);
    vertex.normal = single(ring.outward * across + ring.forward * frame.along);
  }
  return first_vertex + n_sides;
}

/// Triangles between the rings of `sides` vertices that begin at `first`, counter-clockwise seen from
/// outside.
void add_band(RenderMesh& mesh, std::size_t first, std::size_t sides)
{
  for (std::size_t k = 0; k < sides; ++k) {
    const auto a = static_cast<std::uint32_t>(first + k);
    const auto b = static_cast<std::uint32_t>(first + (k + 1) % sides);
    const auto n = static_cast<std::uint32_t>(sides);
    for (const std::uint32_t index : {a, b, b + n, a, b + n, a + n}) mesh.triangles.push_back(index);
  }
}

/// Adds rings and the bands between successive rings; with step 2 only between the rings of each pair.
void add_rings(RenderMesh& mesh, std::size_t n_rings, std::size_t step, std::size_t sides = n_sides)
{
  const std::size_t first = mesh.vertices.size();
  mesh.vertices.resize(first + n_rings * sides);
  for (std::size_t ring = 0; ring + 1 < n_rings; ring += step) add_band(mesh, first + ring * sides, sides);
}

SolidSize size_of(std::size_t n_rings, std::size_t step, std::size_t sides = n_sides)
{
  return {n_rings * sides, n_rings / step * 6 * sides - (step == 1 ? 6 * sides : 0)};
}

/// Writes a flat end cap: a ring and its centre, in axial order. `ring.forward` is -1 or 1.
std::size_t set_end(RenderMesh& mesh, std::size_t vertex, const Frame& frame, const Ring& ring)
{
  const Ring centre{ring.centre_mm, 0.0, 0.0, ring.forward};
  vertex = set_ring(mesh, vertex, frame, ring.forward > 0.0 ? ring : centre);
  return set_ring(mesh, vertex, frame, ring.forward > 0.0 ? centre : ring);
}

}  // namespace

SolidSize ball_size()
{
  return size_of(n_ball_rings, 1);
}
SolidSize arrow_size()
{
  return size_of(n_arrow_rings, 2);
}
SolidSize tube_size(std::size_t n_points)
{
  return size_of(n_points + 2, 1, n_tube_sides);
}

void add_balls(RenderMesh& mesh, std::size_t n)
{
  for (std::size_t i = 0; i < n; ++i) add_rings(mesh, n_ball_rings, 1);
}
void add_rods(RenderMesh& mesh, std::size_t n)
{
  for (std::size_t i = 0; i < n; ++i) add_rings(mesh, n_rod_rings, 2);
}
void add_arrows(RenderMesh& mesh, std::size_t n)
{
  for (std::size_t i = 0; i < n; ++i) add_rings(mesh, n_arrow_rings, 2);
}
void add_tube(RenderMesh& mesh, std::size_t n_points)
{
  add_rings(mesh, n_points + 2, 1, n_tube_sides);
}

void set_ball(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& centre_mm, double radius_mm)
{
  const Frame frame = frame_along(Eigen::Vector3d::UnitY());
  for (std::size_t i = 0; i < n_ball_rings; ++i) {
    const SinCos turn = sin_cos(static_cast<double>(i) * (pi / static_cast<double>(n_ball_rings - 1)));
    const Eigen::Vector3d ring_mm = centre_mm - radius_mm * turn.cos * frame.along;
    first_vertex = set_ring(mesh, first_vertex, frame, {ring_mm, radius_mm * turn.sin, turn.sin, -turn.cos});
  }
}

void set_rod(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& from_mm,
             const Eigen::Vector3d& to_mm, double radius_mm)
{
  const Frame frame = frame_along((to_mm - from_mm).normalized());
  std::size_t vertex = set_end(mesh, first_vertex, frame, {from_mm, radius_mm, 0.0, -1.0});
  vertex = set_ring(mesh, vertex, frame, {from_mm, radius_mm});
  vertex = set_ring(mesh, vertex, frame, {to_mm, radius_mm});
  set_end(mesh, vertex, frame, {to_mm, radius_mm, 0.0, 1.0});
}

void set_arrow(RenderMesh& mesh, std::size_t first_vertex, const Eigen::Vector3d& from_mm,
               const Eigen::Vector3d& to_mm, double radius_mm)
{
  constexpr double head_by_shaft = 3.0, head_slimness = 2.6, most_of_arrow = 0.6;
  const double length_mm = (to_mm - from_mm).norm();
  const Frame frame = frame_along((to_mm - from_mm) / length_mm);
  const double head_radius_mm =
      std::min(head_by_shaft * radius_mm, most_of_arrow * length_mm / head_slimness);
  const double shaft_radius_mm = head_radius_mm / head_by_shaft;
  const Eigen::Vector3d arrow_neck_mm = to_mm - head_slimness * head_radius_mm * frame.along;
  std::size_t vertex = set_end(mesh, first_vertex, frame, {from_mm, shaft_radius_mm, 0.0, -1.0});
  vertex = set_ring(mesh, vertex, frame, {from_mm, shaft_radius_mm});
  vertex = set_ring(mesh, vertex, frame, {arrow_neck_mm, shaft_radius_mm});
  vertex = set_end(mesh, vertex, frame, {arrow_neck_mm, head_radius_mm, 0.0, -1.0});
  // Normal of a cone with a length of head_slimness radii.
  constexpr double outward = 0.933, forward = 0.359;
  vertex = set_ring(mesh, vertex, frame, {arrow_neck_mm, head_radius_mm, outward, forward});
  set_ring(mesh, vertex, frame, {to_mm, 0.0, outward, forward});
}

void set_tube(RenderMesh& mesh, std::size_t first_vertex, std::span<const Eigen::Vector3d> points_mm,
              double radius_mm)
{
  set_band(mesh, first_vertex, points_mm, {radius_mm, radius_mm});
}

void set_band(RenderMesh& mesh, std::size_t first_vertex, std::span<const Eigen::Vector3d> points_mm,
              const BandSection& section)
{
  constexpr double coincident_mm = 1e-9;
  check(points_mm.size() >= 2, "a tube has at least two points");
  const std::size_t last = points_mm.size() - 1;
  Frame frame = frame_along(Eigen::Vector3d::UnitY());
  bool has_frame = false;
  std::size_t vertex = first_vertex;
  const auto set_section = [&](const Eigen::Vector3d& centre_mm, double width_mm, double forward) {
    for (std::size_t k = 0; k < n_tube_sides; ++k) {
      const SinCos& angle = circle<n_tube_sides>()[k];
      const double scale = width_mm / section.half_width_mm;
      RenderVertex& made = mesh.vertices[vertex + k];
      made.position_mm = single(centre_mm + scale * (section.half_width_mm * angle.cos * frame.u +
                                                     section.half_thickness_mm * angle.sin * frame.v));
      // The gradient of the ellipse.
      const Eigen::Vector3d outward =
          section.half_thickness_mm * angle.cos * frame.u + section.half_width_mm * angle.sin * frame.v;
      made.normal = single(forward == 0.0 ? outward.normalized() : Eigen::Vector3d(forward * frame.along));
    }
    vertex += n_tube_sides;
  };
  for (std::size_t i = 0; i <= last; ++i) {
    const Eigen::Vector3d tangent_mm = points_mm[std::min(i + 1, last)] - points_mm[i > 0 ? i - 1 : 0];
    const double length_mm = tangent_mm.norm();
    if (length_mm > coincident_mm) {
      // The width's direction, or else the minimal rotation from the previous ring's frame.
      const Eigen::Vector3d along = tangent_mm / length_mm;
      const double part = static_cast<double>(i) / static_cast<double>(last);
      const Eigen::Vector3d across = (1.0 - part) * section.across_first + part * section.across_last;
      const Eigen::Vector3d wanted = across - along.dot(across) * along;
      const Eigen::Vector3d u = frame.u - along.dot(frame.u) * along;
      if (wanted.norm() > 0.1 * across.norm()) {
        frame = {wanted.normalized(), along.cross(wanted.normalized()), along};
      } else {
        frame = has_frame && u.norm() > 0.1 ? Frame{u.normalized(), along.cross(u.normalized()), along}
                                            : frame_along(along);
      }
      has_frame = true;
    }
    const double off_middle = std::abs(2.0 * static_cast<double>(i) / static_cast<double>(last) - 1.0);
    const double width_mm =
        (1.0 + section.flare * off_middle * off_middle * off_middle) * section.half_width_mm;
    if (i == 0) set_section(points_mm[0], 0.0, -1.0);
    set_section(points_mm[i], width_mm, 0.0);
    if (i == last) set_section(points_mm[last], 0.0, 1.0);
  }
}

Lighting studio_lighting()
{
  Lighting lighting;
  lighting.sky = {0.19F, 0.21F, 0.25F};
  lighting.ground = {0.075F, 0.065F, 0.060F};
  lighting.lights.push_back({Eigen::Vector3f(-0.50F, 0.70F, 0.70F).normalized(), {0.80F, 0.775F, 0.72F}});
  lighting.lights.push_back({Eigen::Vector3f(0.85F, 0.05F, 0.50F).normalized(), {0.19F, 0.22F, 0.27F}});
  lighting.lights.push_back({Eigen::Vector3f(0.25F, 0.55F, -0.80F).normalized(), {0.40F, 0.42F, 0.46F}});
  return lighting;
}

Background background_of(Backdrop backdrop)
{
  switch (backdrop) {
    case Backdrop::studio:
      return {Eigen::Vector3f(0.745F, 0.791F, 0.839F), Eigen::Vector3f(0.371F, 0.434F, 0.503F)};
    case Backdrop::night:
      return {Eigen::Vector3f(0.034F, 0.045F, 0.061F), Eigen::Vector3f(0.007F, 0.009F, 0.013F)};
    case Backdrop::black:
      return {};
  }
  throw InternalError("unknown backdrop");
}

const core::DocumentSchema& lights_schema();  // schemas/lights.schema.json

namespace {

Eigen::Vector3f three(const core::DocumentValue& root, const char* key)
{
  return core::vector3_at(root, key).cast<float>();
}

Light light_of(const core::Document& document, const core::DocumentValue& value, const std::string& key)
{
  constexpr float shortest_direction = 1e-3F;
  const Eigen::Vector3f towards = three(value, "towards");
  if (towards.norm() < shortest_direction)
    document.refuse(key + ".towards", "no direction", "a non-zero vector");
  Light light;
  light.towards_camera = towards.normalized();
  light.colour = three(value, "colour");
  return light;
}

}  // namespace

Lights parsed_lights(const std::string& text, const std::string& name)
{
  const core::Document document = lights_schema().read(text, name);
  const core::DocumentValue& root = document.root;
  Lights lights;
  lights.lighting.sky = three(root, "hemisphere.sky");
  lights.lighting.ground = three(root, "hemisphere.ground");
  for (const core::DocumentValue& light : core::list_or_empty(root, "light")) {
    const std::string key = "light." + std::to_string(lights.lighting.lights.size());
    lights.lighting.lights.push_back(light_of(document, light, key));
  }
  if (root.contains("background"))
    lights.background = Background{three(root, "background.top"), three(root, "background.bottom")};
  return lights;
}

Lights read_lights(const std::string& path)
{
  return parsed_lights(core::read_document_text(path, "a lights file (schemas/lights.md)"), path);
}

namespace {

/// Chosen visually: the notch and the clefts at the menisci darken, the condyles do not.
constexpr double occlusion_radius_of_knee_mm = 12.0;

Eigen::Vector3d as_vector(const std::array<float, 3>& v)
{
  return {v[0], v[1], v[2]};
}

void add_part(Scene& scene, const Body& body, BodyIndex parent, const Drawable& model, const Part& part)
{
  const std::vector<std::vector<Eigen::Index>> triangles = triangles_by_component(body, part);
  for (std::size_t c = 0; c < triangles.size(); ++c) {
    if (triangles[c].empty()) continue;
    Drawable drawable = model;
    drawable.name = body.components[c].name;
    drawable.structure = model.structure + "/" + structure_name(body.components, c);
    drawable.parent = parent;
    drawable.mesh = make_render_mesh(part.mesh, triangles[c], drawable.origin_mm,
                                     crease_rad_of(body.components[c].material));
    update_box(drawable);
    drawable.material = material_of(body.components[c].material);
    scene.drawables.push_back(std::move(drawable));
  }
}

/// World bounding box of the contact parts of one object at the present placement.
Eigen::AlignedBox3d extent_of(const Scene& scene, BodyIndex parent)
{
  Eigen::AlignedBox3d extent;
  for (const Drawable& drawable : scene.drawables) {
    if (drawable.parent != parent || !drawable.has_contact || drawable.layer != Layer::bodies) continue;
    for (const RenderVertex& vertex : drawable.mesh.vertices)
      extent.extend(drawable.X_world_mesh * as_vector(vertex.position_mm));
  }
  return extent;
}

}  // namespace

JointFrames with_followers(JointFrames frames, const store::JointPose& pose)
{
  frames.has_follower = pose.has_follower;
  for (std::size_t k = 0; k < frames.has_follower.size(); ++k) {
    if (frames.has_follower[k])
      frames.X_world_follower[k] = frames.X_world_reference * pose.X_reference_follower[k];
  }
  return frames;
}

namespace {

JointFrames joint_frames_of(const store::JointPose& pose, BodyIndex fixed,
                            const Eigen::Vector3d& rotation_centre_mm)
{
  if (fixed == BodyIndex::world) return {pose.X_world_reference, pose.X_world_moving, Pose::Identity()};
  // The fixed object is only recentred; all motion is that of the other one.
  Pose X_world_fixed = Pose::Identity();
  X_world_fixed.translation() = -rotation_centre_mm;
  if (fixed == BodyIndex::reference)
    return {X_world_fixed, X_world_fixed * pose.X_reference_moving,
            X_world_fixed * pose.X_world_reference.inverse()};
  return {X_world_fixed * pose.X_reference_moving.inverse(), X_world_fixed,
          X_world_fixed * pose.X_world_moving.inverse()};
}

}  // namespace

JointFrames frames_of(const store::JointPose& pose, BodyIndex fixed,
                      const Eigen::Vector3d& rotation_centre_mm)
{
  return with_followers(joint_frames_of(pose, fixed, rotation_centre_mm), pose);
}

JointFrames frames_of(const store::Motion& motion, const store::JointPose& pose, BodyIndex fixed,
                      const Eigen::Vector3d& rotation_centre_mm)
{
  const bool is_placed = pose.status == store::PoseStatus::solved || motion.is_sequence();
  return frames_of(is_placed ? pose : motion.joint_pose(pose.attitude, {}), fixed, rotation_centre_mm);
}

Scene scene_of(const Body& reference, const Body& moving, const Eigen::Vector3d& rotation_centre_mm)
{
  Scene scene;
  Drawable model;
  model.origin_mm = rotation_centre_mm;
  for (const bool has_contact : {true, false}) {
    model.has_contact = has_contact;
    model.structure = body_path(BodyIndex::reference);
    add_part(scene, reference, BodyIndex::reference, model,
             has_contact ? reference.contact : reference.visual);
    model.structure = body_path(BodyIndex::moving);
    add_part(scene, moving, BodyIndex::moving, model, has_contact ? moving.contact : moving.visual);
  }
  scene.occlusion_radius_mm = occlusion_radius_of_knee_mm * store::width_ratio(moving);
  return scene;
}

Scene scene_of(const store::MotionModel& model, const Eigen::Vector3d& rotation_centre_mm)
{
  Scene scene = scene_of(model.reference, model.moving, rotation_centre_mm);
  Drawable drawn;
  drawn.origin_mm = rotation_centre_mm;
  for (const store::FollowerRows& follower : model.followers) {
    const auto body = static_cast<BodyIndex>(follower.body_index);
    drawn.structure = body_path(body, follower.name);
    for (const bool has_contact : {true, false}) {
      drawn.has_contact = has_contact;
      add_part(scene, follower.body, body, drawn, has_contact ? follower.body.contact : follower.body.visual);
    }
  }
  scene.reference_name = store::displayed_name(model, BodyIndex::reference);
  scene.moving_name = store::displayed_name(model, BodyIndex::moving);
  return scene;
}

void place(Scene& scene, const JointFrames& frames)
{
  for (Drawable& drawable : scene.drawables) {
    if (drawable.parent == BodyIndex::world) continue;
    if (frames.has(drawable.parent)) place(drawable, frames.of(drawable.parent));
  }
}

std::vector<bool> shown_drawables(const Scene& scene)
{
  std::vector<bool> shown;
  for (const Drawable& drawable : scene.drawables) shown.push_back(drawable.is_shown);
  return shown;
}

void show_bodies(Scene& scene, const std::vector<bool>& shown, BodyIndex fixed, bool has_pose,
                 const JointFrames& frames)
{
  const BodyIndex missing = fixed == BodyIndex::moving ? BodyIndex::reference : BodyIndex::moving;
  for (std::size_t k = 0; k < shown.size(); ++k) {
    Drawable& drawable = scene.drawables[k];
    if (drawable.layer == Layer::bodies)
      drawable.is_shown = shown[k] && frames.has(drawable.parent) && (has_pose || drawable.parent != missing);
  }
}

void place(Drawable& drawable, const Pose& X_world_body)
{
  drawable.X_world_mesh = X_world_body;
  drawable.X_world_mesh.translation() += X_world_body.linear() * drawable.origin_mm;
}

bool is_framed(const Drawable& drawable)
{
  return drawable.is_shown && drawable.layer == Layer::bodies;
}

Sphere joint_sphere(const Scene& scene, double widths)
{
  const Eigen::AlignedBox3d reference = extent_of(scene, BodyIndex::reference);
  const Eigen::AlignedBox3d moving = extent_of(scene, BodyIndex::moving);
  if (reference.isEmpty() || moving.isEmpty()) return {};
  // If the boxes are separate along an axis, the overlap's sizes are negative and its centre is that of the
  // gap.
  const Eigen::AlignedBox3d overlap = reference.intersection(moving);
  const double width_mm = std::max(overlap.sizes().x(), overlap.sizes().z());
  return {overlap.center(), widths * std::max(width_mm, 0.0)};
}

std::vector<Eigen::Vector3d> points_within(const Scene& scene, const Sphere& sphere)
{
  std::vector<Eigen::Vector3d> all, within;
  for (const Drawable& drawable : scene.drawables) {
    if (!is_framed(drawable)) continue;
    for (const RenderVertex& vertex : drawable.mesh.vertices) {
      all.push_back(drawable.X_world_mesh * as_vector(vertex.position_mm));
      if ((all.back() - sphere.centre_world_mm).norm() <= sphere.radius_mm) within.push_back(all.back());
    }
  }
  return within.empty() ? all : within;
}

double marker_scale(const store::MotionModel& model)
{
  return store::width_ratio(model.moving);
}

std::vector<std::size_t> informative_cells(const store::MotionModel& model)
{
  std::vector<std::size_t> spine, all;
  for (Eigen::Index cell = 0; cell < model.status.size(); ++cell) {
    if (model.status.data()[cell] != status_stable) continue;
    all.push_back(static_cast<std::size_t>(cell));
    if (model.is_spine.size() > 0 && model.is_spine.data()[cell] == 1)
      spine.push_back(static_cast<std::size_t>(cell));
  }
  return spine.empty() ? all : spine;
}

std::size_t add_layer(Scene& scene, Layer layer, BodyIndex parent, const std::string& name)
{
  Drawable drawable;
  drawable.name = name;
  drawable.layer = layer;
  drawable.parent = parent;
  drawable.is_shown = false;
  drawable.has_contact = false;
  scene.drawables.push_back(std::move(drawable));
  return scene.drawables.size() - 1;
}

Material marker_material(const VertexColour& colour)
{
  return {linear_from_srgb(colour), 1.0F, 0.18F, 40.0F, 0.0F};
}

void update_box(Drawable& drawable)
{
  constexpr float none_mm = std::numeric_limits<float>::infinity();
  std::array<float, 3> low_mm{none_mm, none_mm, none_mm}, high_mm{-none_mm, -none_mm, -none_mm};
  for (const std::uint32_t index : drawable.mesh.triangles) {
    const std::array<float, 3>& p_mm = drawable.mesh.vertices[index].position_mm;
    for (std::size_t k = 0; k < 3; ++k) {
      low_mm[k] = std::min(low_mm[k], p_mm[k]);
      high_mm[k] = std::max(high_mm[k], p_mm[k]);
    }
  }
  drawable.box_mm = drawable.mesh.triangles.empty()
                        ? Eigen::AlignedBox3d(Eigen::Vector3d::Zero())
                        : Eigen::AlignedBox3d(as_vector(low_mm), as_vector(high_mm));
}

namespace {

VertexColour rgb(unsigned hex)
{
  const auto byte = [&](unsigned shift) { return static_cast<std::uint8_t>(hex >> shift & 0xFFU); };
  return {byte(16), byte(8), byte(0), 255};
}

std::uint8_t rounded(double value)
{
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

}  // namespace

VertexColour interpolated_colour(const VertexColour& a, const VertexColour& b, double part)
{
  VertexColour colour{};
  for (std::size_t k = 0; k < colour.size(); ++k) colour[k] = rounded(a[k] + part * (b[k] - a[k]));
  return colour;
}

VertexColour colour_of(const Legend& legend, double value)
{
  if (value < legend.lowest && !legend.below_label.empty()) return legend.below;
  if (value > legend.highest && legend.beyond) return *legend.beyond;
  constexpr std::size_t last = std::tuple_size_v<Palette> - 1;
  const double position =
      std::clamp((value - legend.lowest) / (legend.highest - legend.lowest), 0.0, 1.0) * last;
  const std::size_t before = std::min(static_cast<std::size_t>(position), last - 1);
  return interpolated_colour(legend.palette[before], legend.palette[before + 1],
                             position - static_cast<double>(before));
}

double srgb_of(double linear)
{
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

double linear_of(double srgb)
{
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

VertexColour srgb_from_linear(const Eigen::Vector3f& linear)
{
  const auto channel = [&](Eigen::Index k) {
    const double c = linear[k];
    return rounded(255.0 * srgb_of(c));
  };
  return {channel(0), channel(1), channel(2), 255};
}

Eigen::Vector3f linear_from_srgb(const VertexColour& colour)
{
  const auto channel = [&](std::size_t k) {
    const double c = colour[k] / 255.0;
    return static_cast<float>(linear_of(c));
  };
  return {channel(0), channel(1), channel(2)};
}

const Palette& gap_palette()
{
  static const Palette palette{rgb(0xF0F921), rgb(0xFCCE25), rgb(0xFCA636), rgb(0xF2844B),
                               rgb(0xE16462), rgb(0xCC4778), rgb(0xB12A90), rgb(0x8F0DA4),
                               rgb(0x6A00A8), rgb(0x41049D), rgb(0x0D0887)};
  return palette;
}

const Palette& strain_palette()
{
  static const Palette palette{rgb(0xFDD49E), rgb(0xFDC58E), rgb(0xFDB27B), rgb(0xFC9662),
                               rgb(0xF77D52), rgb(0xEF6548), rgb(0xE1452F), rgb(0xD02619),
                               rgb(0xBA0A06), rgb(0x9E0000), rgb(0x7F0000)};
  return palette;
}

bool is_removed(const SectionPlane& section, const Eigen::Vector3d& p_mm, const Eigen::Vector3d& eye_mm)
{
  return (section.normal.dot(p_mm) > section.at_mm) == (section.normal.dot(eye_mm) > section.at_mm);
}

const std::vector<std::string>& layer_names()
{
  static const std::vector<std::string> names{"contacts",  "normals",       "axes",   "helical-axis", "gaps",
                                              "ligaments", "contact-paths", "labels", "band"};
  return names;
}

const std::string& name_of(Layer layer)
{
  check(layer != Layer::bodies, "only optional layers have names");
  return layer_names()[static_cast<std::size_t>(layer) - 1];
}

std::optional<Layer> layer_named(const std::string& name)
{
  const auto found = std::ranges::find(layer_names(), name);
  if (found == layer_names().end()) return std::nullopt;
  return static_cast<Layer>(found - layer_names().begin() + 1);
}

}  // namespace vrda::view
