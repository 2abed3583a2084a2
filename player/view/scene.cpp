#include "view/scene.hpp"

#include <algorithm>
#include "store/joint_parts.hpp"

#include "model/step_record.hpp"
#include "view/joint_layers.hpp"

namespace vrda::view {
namespace {

/// Chosen visually: the notch and the clefts at the menisci darken, the condyles do not.
constexpr double occlusion_radius_of_knee_mm = 12.0;

Eigen::Vector3d as_vector(const std::array<float, 3>& v)
{
  return {v[0], v[1], v[2]};
}

void add_part(Scene& scene, const Body& body, ParentFrame parent, const Drawable& model, const Part& part)
{
  const std::vector<std::vector<Eigen::Index>> triangles = triangles_by_component(body, part);
  for (std::size_t c = 0; c < triangles.size(); ++c) {
    if (triangles[c].empty()) continue;
    Drawable drawable = model;
    drawable.name = body.components[c].name;
    drawable.parent = parent;
    drawable.mesh = make_render_mesh(part.mesh, triangles[c], drawable.origin_mm,
                                     crease_rad_of(body.components[c].material));
    update_box(drawable);
    drawable.material = material_of(body.components[c].material);
    scene.drawables.push_back(std::move(drawable));
  }
}

/// World bounding box of the contact parts of one object at the present placement.
Eigen::AlignedBox3d extent_of(const Scene& scene, ParentFrame parent)
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

JointFrames frames_of(const store::JointPose& pose, FixedObject fixed,
                      const Eigen::Vector3d& rotation_centre_mm)
{
  if (fixed == FixedObject::push) return {pose.X_world_reference, pose.X_world_moving, Pose::Identity()};
  // The fixed object is only recentred; all motion is that of the other one.
  Pose X_world_fixed = Pose::Identity();
  X_world_fixed.translation() = -rotation_centre_mm;
  if (fixed == FixedObject::reference)
    return {X_world_fixed, X_world_fixed * pose.X_reference_moving,
            X_world_fixed * pose.X_world_reference.inverse()};
  return {X_world_fixed * pose.X_reference_moving.inverse(), X_world_fixed,
          X_world_fixed * pose.X_world_moving.inverse()};
}

JointFrames frames_of(const store::Motion& motion, const store::JointPose& pose, FixedObject fixed,
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
    add_part(scene, reference, ParentFrame::reference, model,
             has_contact ? reference.contact : reference.visual);
    add_part(scene, moving, ParentFrame::moving, model, has_contact ? moving.contact : moving.visual);
  }
  scene.occlusion_radius_mm = occlusion_radius_of_knee_mm * store::width_ratio(moving);
  return scene;
}

Scene scene_of(const store::MotionModel& model, const Eigen::Vector3d& rotation_centre_mm)
{
  Scene scene = scene_of(model.reference, model.moving, rotation_centre_mm);
  scene.reference_name = store::displayed_name(model, store::JointBody::reference);
  scene.moving_name = store::displayed_name(model, store::JointBody::moving);
  return scene;
}

void place(Scene& scene, const JointFrames& frames)
{
  for (Drawable& drawable : scene.drawables) {
    if (drawable.parent == ParentFrame::world) continue;
    place(drawable,
          drawable.parent == ParentFrame::reference ? frames.X_world_reference : frames.X_world_moving);
  }
}

std::vector<bool> shown_drawables(const Scene& scene)
{
  std::vector<bool> shown;
  for (const Drawable& drawable : scene.drawables) shown.push_back(drawable.is_shown);
  return shown;
}

void show_bodies(Scene& scene, const std::vector<bool>& shown, FixedObject fixed, bool has_pose)
{
  const ParentFrame missing = fixed == FixedObject::moving ? ParentFrame::reference : ParentFrame::moving;
  for (std::size_t k = 0; k < shown.size(); ++k) {
    Drawable& drawable = scene.drawables[k];
    if (drawable.layer == Layer::bodies)
      drawable.is_shown = shown[k] && (has_pose || drawable.parent != missing);
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
  const Eigen::AlignedBox3d reference = extent_of(scene, ParentFrame::reference);
  const Eigen::AlignedBox3d moving = extent_of(scene, ParentFrame::moving);
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

std::size_t add_layer(Scene& scene, Layer layer, ParentFrame parent, const std::string& name)
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
  Eigen::AlignedBox3d box_mm;
  for (const std::uint32_t index : drawable.mesh.triangles)
    box_mm.extend(as_vector(drawable.mesh.vertices[index].position_mm));
  drawable.box_mm = box_mm.isEmpty() ? Eigen::AlignedBox3d(Eigen::Vector3d::Zero()) : box_mm;
}

}  // namespace vrda::view
