/// From a pose to the numbers of a motion step.
#pragma once

#include "core/frames.hpp"

namespace vrda::inline core {

/// Attitude and pose of a motion step, in S.
struct JointCoordinates {
  Attitude attitude;
  MovingPose pose;
};

/// Inverse of X_reference_moving() of core/frames.hpp: every pose has such coordinates. Flexion and theta are
/// in (-pi, pi], varus in [-pi/2, pi/2]; at its ends only the sum or difference of the other two is defined.
JointCoordinates joint_coordinates(const SolverFrame& frame, const Pose& X_reference_moving);

}  // namespace vrda::inline core
