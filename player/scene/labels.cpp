// Where the names of bones, ligaments and compartments are drawn.
#include "scene/layers.hpp"

namespace vrda::scene {

Eigen::Vector3d place_of(const motion::JointLabel& label, const JointFrames& frames)
{
  const auto placed = [&](motion::JointBody body, const Eigen::Vector3d& p_mm) -> Eigen::Vector3d {
    return body == motion::JointBody::reference ? frames.X_world_reference * p_mm
                                                : frames.X_world_moving * p_mm;
  };
  return 0.5 * (placed(label.first, label.first_mm) + placed(label.second, label.second_mm));
}

}  // namespace vrda::scene
