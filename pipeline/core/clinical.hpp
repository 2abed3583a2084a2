/// Grood-Suntay numbers of a pose: moving body (tibia) in the reference (femur). schemas/clinical.md
/// writes every formula out.
#pragma once

#include "core/frames.hpp"

namespace vrda {

/// Angles: flexion +, varus (adduction) +, internal rotation +. Translations of the tibial point that
/// lies at the rotation centre at the zero pose, on the Grood-Suntay axes: anterior +, proximal +,
/// lateral + on both sides.
struct Clinical {
  double flexion_rad = 0.0;
  double varus_rad = 0.0;
  double internal_rotation_rad = 0.0;
  double anterior_mm = 0.0;
  double proximal_mm = 0.0;
  double lateral_mm = 0.0;
};

/// Decomposed from `X_reference_moving` alone: R = Rz(-flexion) Rx(varus) Ry(internal) on the right side,
/// and of the mirrored pose on the left. `rotation_centre_mm` in canonical coordinates of the own side.
/// Source: Grood and Suntay (1983) J Biomech Eng 105:136-144.
Clinical clinical_of(const Pose& X_reference_moving, Side side, const Eigen::Vector3d& rotation_centre_mm);

}  // namespace vrda
