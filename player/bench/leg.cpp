#include "bench/leg.hpp"

#include "model/clinical.hpp"

namespace vrda::bench {

Pose X_femur_tibia(const LegBodies& bodies, const Pose& X_tracker_thigh, const Pose& X_tracker_shank)
{
  const Pose X_tracker_femur = X_tracker_thigh * bodies.X_thigh_femur;
  const Pose X_tracker_tibia = X_tracker_shank * bodies.X_shank_tibia;
  return X_tracker_femur.inverse() * X_tracker_tibia;
}

LegAngles leg_angles(const Pose& X_femur_tibia, const SolverFrame& frame)
{
  // S is a right knee whose Delta is +Y.
  const Pose X_solver = X_solver_reference_moving(frame, X_femur_tibia);
  const ClinicalCoordinates clinical = clinical_coordinates(X_solver, Side::right, Eigen::Vector3d::Zero());
  return {clinical.flexion_rad, clinical.varus_rad, clinical.internal_rotation_rad};
}

Attitude attitude_of(const LegAngles& angles)
{
  return {angles.flexion_rad, angles.varus_rad};
}

Pose X_femur_tibia(const LegAngles& angles, const SolverFrame& frame, const Eigen::Vector3d& translation_mm)
{
  return X_reference_moving(frame, attitude_of(angles), {translation_mm, angles.theta_rad});
}

}  // namespace vrda::bench
