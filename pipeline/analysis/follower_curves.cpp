// Rotations and displacements of bodies that follow the joint, over flexion.
#include "analysis/flexion_curves.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "store/motion.hpp"

namespace vrda::analysis {

std::vector<CurveGroup> follower_curves(const store::MotionModel& model,
                                        const std::vector<store::JointPose>& poses, int /*n_threads*/)
{
  std::vector<CurveGroup> groups;
  for (const store::FollowerRows* follower : store::in_order(model.followers)) {
    CurveGroup turns{
        follower->name,
        "Rotations of " + follower->name + " over flexion: R = Rz(-flexion) Rx(rotation) Ry(tilt).",
        "degrees",
        {}};
    CurveGroup shifts{
        follower->name,
        "Displacement of the centre of " + follower->name + " along the axes of the body that it follows.",
        "mm",
        {}};
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
      Curve curve{"follower_" + follower->name + "_" + follower_coordinate_names[k] + unit_suffix(k),
                  follower_coordinate_names[k],
                  {}};
      for (const store::JointPose& pose : poses) {
        const std::optional<Pose> X_of = pose.X_of(*follower);
        curve.values.push_back(
            X_of ? in_files(follower_coordinates(*X_of, side_named(model.side), follower->centre_mm))[k]
                 : nan);
      }
      (is_rotation(k) ? turns : shifts).curves.push_back(std::move(curve));
    }
    groups.push_back(std::move(turns));
    groups.push_back(std::move(shifts));
  }
  return groups;
}

}  // namespace vrda::analysis
