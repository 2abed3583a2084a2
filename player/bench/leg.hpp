/// Knee angles from the tracked poses of thigh and shank (left open in thesis 9).
#pragma once

#include "model/frames.hpp"

namespace vrda::bench {

/// Flexion +, varus (adduction) +, theta: internal rotation +, on both sides.
struct LegAngles {
  double flexion_rad = 0.0;
  double varus_rad = 0.0;
  double theta_rad = 0.0;
};

/// Poses of the bones in the bodies fixed to them; bones in canonical axes, as stored in a motion model.
struct LegBodies {
  Pose X_thigh_femur = Pose::Identity();
  Pose X_shank_tibia = Pose::Identity();
};

/// The tibia in the femur's frame, from the tracked poses of the bodies.
Pose X_femur_tibia(const LegBodies& bodies, const Pose& X_tracker_thigh, const Pose& X_tracker_shank);

/// Attitude in a motion model's frame, and theta about its Delta, from the rotation of the tibia in the
/// femur's frame (canonical axes of its own side). With Delta = +Y these are the Grood-Suntay angles of
/// core/clinical.hpp. If Delta depends on flexion, `frame` must be that of the current flexion. At 90
/// degrees of varus only a combination of flexion and theta is defined.
LegAngles leg_angles(const Pose& X_femur_tibia, const SolverFrame& frame);

/// The attitude at which to query the motion model.
Attitude attitude_of(const LegAngles& angles);

/// Inverse of leg_angles(): the tibia in the femur's frame, with `translation_mm` in the solver's frame S
/// (core/frames.hpp).
Pose X_femur_tibia(const LegAngles& angles, const SolverFrame& frame,
                   const Eigen::Vector3d& translation_mm = Eigen::Vector3d::Zero());

}  // namespace vrda::bench
