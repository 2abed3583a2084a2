/// What a leg tracked at thigh and shank says about the knee (thesis 9 left it open).
#pragma once

#include "core/frames.hpp"

namespace vrda {

/// Flexion +, varus (adduction) +, theta: internal rotation +, on both sides.
struct LegAngles {
  double flexion_rad = 0.0;
  double varus_rad = 0.0;
  double theta_rad = 0.0;
};

/// How the bones lie in the bodies fixed to them; bones in canonical axes, as a motion model stores them.
struct LegBodies {
  Pose X_thigh_femur = Pose::Identity();
  Pose X_shank_tibia = Pose::Identity();
};

/// The tibia in the femur's frame, from where the tracker sees the bodies.
Pose X_femur_tibia(const LegBodies& bodies, const Pose& X_tracker_thigh, const Pose& X_tracker_shank);

/// The attitude of a motion model's frame, and theta about its Delta, from the rotation of the tibia in the
/// femur's frame (canonical axes of the own side). With Delta = +Y the Grood-Suntay angles of
/// core/clinical.hpp. Where Delta turns with flexion, `frame` holds that of the flexion at hand. At 90
/// degrees of varus only flexion and theta together are defined.
LegAngles leg_angles(const Pose& X_femur_tibia, const SolverFrame& frame);

/// Where to ask the motion model.
Attitude attitude_of(const LegAngles& angles);

/// The tibia in the femur's frame at those angles, `translation_mm` of it in the solver's frame S
/// (core/frames.hpp): what leg_angles() undoes.
Pose X_femur_tibia(const LegAngles& angles, const SolverFrame& frame,
                   const Eigen::Vector3d& translation_mm = Eigen::Vector3d::Zero());

}  // namespace vrda
