/// How far a pose may be from the neutral pose of a joint before the joint counts as dislocated.
#pragma once

#include <limits>

#include "model/frames.hpp"

namespace vrda::inline model {

/// Unbounded by default.
struct JointBounds {
  Eigen::Vector3d neutral_mm = Eigen::Vector3d::Zero();  ///< translation in W of the joint's own side
  double neutral_theta_rad = 0.0;
  double max_travel_mm = std::numeric_limits<double>::infinity();  ///< distance of translations, inclusive
  double max_theta_rad = std::numeric_limits<double>::infinity();  ///< of the smaller rotation, inclusive
};

/// `pose` in the solver frame `frame`. False for a pose that is not finite.
bool is_within(const JointBounds& bounds, const SolverFrame& frame, const MovingPose& pose);

}  // namespace vrda::inline model
