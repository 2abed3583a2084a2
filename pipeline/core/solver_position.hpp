/// From a pose to the numbers of a motion step.
#pragma once

#include "core/frames.hpp"

namespace vrda::inline core {

/// Attitude of the reference and pose of the moving object, in S.
struct SolverPosition {
  Attitude attitude;
  MovingPose pose;
};

/// Inverse of X_reference_moving() of core/frames.hpp: every pose has such numbers. Flexion and theta are
/// in (-pi, pi], varus in [-pi/2, pi/2]; at its ends only the sum or difference of the other two is defined.
SolverPosition solver_position(const SolverFrame& frame, const Pose& X_reference_moving);

}  // namespace vrda::inline core
