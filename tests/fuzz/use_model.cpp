// The player's use of a motion model, up to drawing.
#include "fuzz/small_models.hpp"

#include <vector>

#include "fuzz/outcome.hpp"
#include "store/motion.hpp"
#include "view/camera.hpp"
#include "view/readings.hpp"
#include "view/scene.hpp"

namespace vrda::test {
namespace {

view::LayerSet all_layers()
{
  view::LayerSet layers;
  for (const std::string& name : view::layer_names()) layers.set(*view::layer_named(name), true);
  return layers;
}

void look_at(const view::Scene& scene, Side side)
{
  constexpr double everywhere_mm = 1e300;
  for (const view::Sphere& sphere :
       {view::joint_sphere(scene), view::Sphere{Eigen::Vector3d::Zero(), everywhere_mm}}) {
    view::CameraFit fit(view::view_rotation(view::View::oblique, side));
    fit.include(view::points_within(scene, sphere));
    view::projection(view::with_depth_range(fit.camera(), scene));
  }
}

/// Poses at and beyond the ends of the motion and between.
std::vector<store::JointPose> some_poses(const store::Motion& motion)
{
  std::vector<store::JointPose> poses;
  const double n = motion.is_sequence() ? static_cast<double>(motion.keys().size() - 1) : 0.0;
  for (const double part : {0.37, -0.1, 0.0, 1.0}) {
    if (motion.is_sequence()) {
      poses.push_back(motion.at_frame(motion.key_at(part * n)));
      continue;
    }
    const double first = motion.first_flexion_rad(), last = motion.last_flexion_rad();
    const double flexion_rad = first + part * (last - first);
    for (const double varus_rad : {motion.balanced_varus_rad(flexion_rad), 1.0})
      poses.push_back(motion.at({flexion_rad, varus_rad}));
  }
  return poses;
}

}  // namespace

void use_motion(const store::MotionModel& model)
{
  for (const std::string& set : store::set_names(model)) {
    const store::Motion motion(model, set);
    const view::GapReader gaps(model, set);
    for (const store::JointPose& pose : some_poses(motion)) {
      require(pose.X_reference_moving.matrix().allFinite(), "a pose that is no number");
      gaps.at(pose);
    }
  }
}

void use_as_player(const store::MotionModel& model)
{
  use_motion(model);
  view::Scene scene = view::scene_of(model.reference, model.moving, model.rotation_centre_mm);
  view::JointLayers layers(model, scene);
  const view::LayerSet shown = all_layers();
  for (const std::string& set : store::set_names(model)) {
    const store::Motion motion(model, set);
    const store::JointPose pose = some_poses(motion).front();
    const view::JointFrames frames = view::frames_of(pose);
    view::place(scene, frames);
    layers.update(scene, motion, {pose, frames, shown});
    look_at(scene, model.side == "left" ? Side::left : Side::right);
  }
}

}  // namespace vrda::test
