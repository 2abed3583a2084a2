// Layers of the joint's axes and of the helical axis.
#include "model/side.hpp"
#include "view/layers.hpp"

#include <algorithm>

#include "core/units.hpp"
#include "view/scene.hpp"
#include "view/solids.hpp"

namespace vrda::view {
namespace {

// Sizes for a knee, mm: rods are longer than its width, so that their ends protrude from the bones.
constexpr double half_rod_mm = 62.0, arrow_mm = 48.0, delta_from_mm = -75.0, delta_to_mm = -40.0;
constexpr double rod_radius_mm = 0.8, arrow_radius_mm = 0.9, helical_radius_mm = 1.1;

struct Axis {
  const char* name;
  VertexColour colour;
};
enum AxisRow : std::size_t { anterior, proximal, right, flexion, varus, push, helical };
constexpr std::array<Axis, 7> axes{{{"anterior", {205, 52, 44, 255}},
                                    {"proximal", {62, 152, 66, 255}},
                                    {"right", {52, 92, 198, 255}},
                                    {"flexion axis", {238, 158, 32, 255}},
                                    {"varus axis", {178, 72, 178, 255}},
                                    {"Delta", {245, 245, 240, 255}},
                                    {"helical axis", {32, 186, 196, 255}}}};

/// Builds a rod through the origin, or an arrow, along +Y.
void set_mesh(Drawable& drawable, AxisRow row, double scale)
{
  const Eigen::Vector3d up = Eigen::Vector3d::UnitY();
  RenderMesh& mesh = drawable.mesh;
  if (row == flexion || row == varus || row == helical) {
    add_rods(mesh, 1);
    const double radius_mm = row == helical ? helical_radius_mm : rod_radius_mm;
    set_rod(mesh, 0, -scale * half_rod_mm * up, scale * half_rod_mm * up, scale * radius_mm);
  } else {
    add_arrows(mesh, 1);
    const double from_mm = row == push ? delta_from_mm : 0.0, to_mm = row == push ? delta_to_mm : arrow_mm;
    set_arrow(mesh, 0, scale * from_mm * up, scale * to_mm * up, scale * arrow_radius_mm);
  }
  update_box(drawable);
}

std::size_t add_axis(const store::MotionModel& model, Scene& scene, AxisRow row)
{
  const Layer layer = row == helical ? Layer::helical_axis : Layer::axes;
  const std::size_t index = add_layer(scene, layer, ParentFrame::world, axes[row].name);
  Drawable& drawable = scene.drawables[index];
  drawable.material = marker_material(axes[row].colour);
  set_mesh(drawable, row, marker_scale(model));
  return index;
}

/// Pose of a mesh along +Y through a world point along a world direction; the rotation about its axis is
/// arbitrary.
Pose aligned(const Eigen::Vector3d& through_world_mm, const Eigen::Vector3d& along_world)
{
  Pose X = Pose::Identity();
  X.linear() = shortest_rotation(Eigen::Vector3d::UnitY(), along_world.normalized());
  X.translation() = through_world_mm;
  return X;
}

}  // namespace

const std::vector<Label>& JointLayers::axis_labels()
{
  static const std::vector<Label> labels = [] {
    std::vector<Label> made;
    made.reserve(axes.size());
    for (const Axis& axis : axes) made.push_back({axis.name, axis.colour});
    return made;
  }();
  return labels;
}

AxesLayer::AxesLayer(const store::MotionModel& model, Scene& scene)
    : side_(side_named(model.side)), rotation_centre_mm_(model.rotation_centre_mm)
{
  first_drawable_ = scene.drawables.size();
  for (const AxisRow row : {anterior, proximal, right, flexion, varus, push}) add_axis(model, scene, row);
}

void AxesLayer::update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown) const
{
  const Pose& X_world_reference = shown.frames.X_world_reference;
  const Eigen::Vector3d centre_mm = X_world_reference * rotation_centre_mm_;
  const Eigen::Vector3d delta = motion.delta_of(shown.pose);
  // Flexion axis: Z of the solver frame rotated by the varus; varus axis: X of the solver frame.
  const SolverFrame frame{side_, rotation_centre_mm_, delta};
  const Eigen::Matrix3d R_world_push = shown.frames.X_world_push.linear();
  const auto on_screen = [&](const Eigen::Vector3d& v_solver) {
    return Eigen::Vector3d(R_world_push * world_from_solver(frame, v_solver));
  };
  std::array<Eigen::Vector3d, 6> along;
  for (const AxisRow row : {anterior, proximal, right})
    along[row] = X_world_reference.linear() * Eigen::Vector3d::Unit(static_cast<Eigen::Index>(row));
  along[flexion] = on_screen(rotation_x(-shown.pose.attitude.varus_rad) * Eigen::Vector3d::UnitZ());
  along[varus] = on_screen(Eigen::Vector3d::UnitX());
  along[push] = R_world_push * delta;
  for (std::size_t row = 0; row < along.size(); ++row) {
    Drawable& drawable = scene.drawables[first_drawable_ + row];
    drawable.is_shown = true;
    drawable.X_world_mesh = aligned(centre_mm, along[row]);
  }
}

std::optional<HelicalAxis> helical_axis_at(const store::Motion& motion, const Attitude& attitude,
                                           const Eigen::Vector3d& near_mm)
{
  constexpr double step_rad = rad_from_deg(1.0);
  const double first_rad = std::max(attitude.flexion_rad - step_rad, motion.first_flexion_rad());
  const double last_rad = std::min(attitude.flexion_rad + step_rad, motion.last_flexion_rad());
  const store::JointPose before = motion.at({first_rad, attitude.varus_rad});
  const store::JointPose after = motion.at({last_rad, attitude.varus_rad});
  if (before.status != store::PoseStatus::solved || after.status != store::PoseStatus::solved) return {};
  return helical_axis(before.X_reference_moving, after.X_reference_moving, near_mm);
}

std::optional<HelicalAxis> helical_axis_at_frame(const store::Motion& motion, double key,
                                                 const Eigen::Vector3d& near_mm)
{
  const double position = motion.position_of(key);
  const store::JointPose before = motion.at_frame(motion.key_at(position - 1.0));
  const store::JointPose after = motion.at_frame(motion.key_at(position + 1.0));
  if (before.status != store::PoseStatus::solved || after.status != store::PoseStatus::solved) return {};
  return helical_axis(before.X_reference_moving, after.X_reference_moving, near_mm);
}

HelicalAxisLayer::HelicalAxisLayer(const store::MotionModel& model, Scene& scene)
    : rotation_centre_mm_(model.rotation_centre_mm), drawable_(add_axis(model, scene, helical))
{
}

void HelicalAxisLayer::update(Scene& scene, const store::Motion& motion, const DisplayedPose& shown) const
{
  const std::optional<HelicalAxis> axis =
      motion.is_sequence() ? helical_axis_at_frame(motion, shown.pose.key, rotation_centre_mm_)
                           : helical_axis_at(motion, shown.pose.attitude, rotation_centre_mm_);
  Drawable& drawable = scene.drawables[drawable_];
  drawable.is_shown = axis.has_value();
  if (!axis) return;
  const Pose& X_world_reference = shown.frames.X_world_reference;
  drawable.X_world_mesh =
      aligned(X_world_reference * axis->point_mm, X_world_reference.linear() * axis->direction);
}

}  // namespace vrda::view
