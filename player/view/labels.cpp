// Where the names of bones, ligaments and compartments are drawn.
#include "view/layers.hpp"

namespace vrda::view {

Eigen::Vector3d place_of(const store::JointLabel& label, const JointFrames& frames)
{
  const auto placed = [&](store::JointBody body, const Eigen::Vector3d& p_mm) -> Eigen::Vector3d {
    return body == store::JointBody::reference ? frames.X_world_reference * p_mm
                                                : frames.X_world_moving * p_mm;
  };
  return 0.5 * (placed(label.first, label.first_mm) + placed(label.second, label.second_mm));
}

}  // namespace vrda::view
