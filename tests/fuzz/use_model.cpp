// The player's use of a motion model, up to drawing.
#include "fuzz/small_models.hpp"

#include <vector>

#include "fuzz/outcome.hpp"
#include "motion/poses.hpp"
#include "navigation/gap_reading.hpp"
#include "scene/camera.hpp"
#include "scene/joint_layers.hpp"
#include "scene/scene.hpp"

namespace vrda::test {
namespace {

scene::LayerSet all_layers()
{
  scene::LayerSet layers;
  for (const std::string& name : scene::layer_names()) layers.set(*scene::layer_named(name), true);
  return layers;
}

void look_at(const scene::Scene& scene, Side side)
{
  constexpr double everywhere_mm = 1e300;
  for (const scene::Sphere& sphere :
       {scene::joint_sphere(scene), scene::Sphere{Eigen::Vector3d::Zero(), everywhere_mm}}) {
    scene::CameraFit fit(scene::view_rotation(scene::View::oblique, side));
    fit.include(scene::points_within(scene, sphere));
    scene::projection(scene::with_depth_range(fit.camera(), scene));
  }
}

/// Poses at and beyond the ends of the motion and between.
std::vector<motion::JointPose> some_poses(const motion::Motion& motion)
{
  std::vector<motion::JointPose> poses;
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
  for (const std::string& set : motion::set_names(model)) {
    const motion::Motion motion(model, set);
    const navigation::GapReader gaps(model, set);
    for (const motion::JointPose& pose : some_poses(motion)) {
      require(pose.X_reference_moving.matrix().allFinite(), "a pose that is no number");
      gaps.at(pose);
    }
  }
}

void use_as_player(const store::MotionModel& model)
{
  use_motion(model);
  scene::Scene scene = scene::scene_of(model.reference, model.moving, model.rotation_centre_mm);
  scene::JointLayers layers(model, scene);
  const scene::LayerSet shown = all_layers();
  for (const std::string& set : motion::set_names(model)) {
    const motion::Motion motion(model, set);
    const motion::JointPose pose = some_poses(motion).front();
    const scene::JointFrames frames = scene::frames_of(pose);
    scene::place(scene, frames);
    layers.update(scene, motion, {pose, frames, shown});
    look_at(scene, model.side == "left" ? Side::left : Side::right);
  }
}

}  // namespace vrda::test
