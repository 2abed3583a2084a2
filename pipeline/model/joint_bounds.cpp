#include "model/joint_bounds.hpp"

#include <cmath>

#include "core/units.hpp"

namespace vrda::inline model {

bool is_within(const JointBounds& bounds, const SolverFrame& frame, const MovingPose& pose)
{
  const double travel_mm = (world_translation_mm(frame, pose) - bounds.neutral_mm).norm();
  const double theta_rad = std::abs(std::remainder(pose.theta_rad - bounds.neutral_theta_rad, 2.0 * pi));
  return travel_mm <= bounds.max_travel_mm && theta_rad <= bounds.max_theta_rad;
}

}  // namespace vrda::inline model
