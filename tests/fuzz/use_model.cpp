#include "fuzz/use_model.hpp"

#include "fuzz/outcome.hpp"
#include "motion/poses.hpp"
#include "navigation/gap_reading.hpp"
#include "scene/camera.hpp"
#include "scene/joint_layers.hpp"
#include "scene/scene.hpp"

namespace vrda::test {
namespace {

LayerSet all_layers()
{
  LayerSet layers;
  for (const std::string& name : layer_names()) layers.set(*layer_named(name), true);
  return layers;
}

void look_at(const Scene& scene, Side side)
{
  constexpr double everywhere_mm = 1e300;
  for (const Sphere& sphere : {joint_sphere(scene), Sphere{Eigen::Vector3d::Zero(), everywhere_mm}}) {
    CameraFit fit(view_rotation(View::oblique, side));
    fit.include(points_within(scene, sphere));
    projection(with_depth_range(fit.camera(), scene));
  }
}

}  // namespace

void use_motion(const MotionModel& model)
{
  for (const std::string& set : set_names(model)) {
    const Motion motion(model, set);
    const GapReader gaps(model, set);
    const double first = motion.first_flexion_rad(), last = motion.last_flexion_rad();
    for (const double part : {-0.1, 0.0, 0.37, 1.0}) {
      const double flexion_rad = first + part * (last - first);
      for (const double varus_rad : {motion.balanced_varus_rad(flexion_rad), 1.0}) {
        const JointRate rate = motion.rate_at({flexion_rad, varus_rad});
        require(rate.pose.X_reference_moving.matrix().allFinite(), "a pose that is no number");
        gaps.at(rate.pose.attitude);
      }
    }
  }
}

void use_as_player(const MotionModel& model)
{
  use_motion(model);
  Scene scene = scene_of(model.reference, model.moving, model.rotation_centre_mm);
  JointLayers layers(model, scene);
  const LayerSet shown = all_layers();
  for (const std::string& set : set_names(model)) {
    const Motion motion(model, set);
    const double first = motion.first_flexion_rad(), last = motion.last_flexion_rad();
    const JointPose pose = motion.at({first + 0.37 * (last - first), motion.balanced_varus_rad(first)});
    const JointFrames frames = frames_of(pose);
    place(scene, frames);
    layers.update(scene, motion, {pose, frames, shown});
    look_at(scene, model.side == "left" ? Side::left : Side::right);
  }
}

}  // namespace vrda::test
