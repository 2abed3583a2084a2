/// Motion in clinical numbers: Grood-Suntay numbers of a pose (moving body, the tibia, in the reference, the
/// femur; schemas/clinical.md writes every formula out) and the axis that a body turns about between two
/// poses.
#pragma once

#include <optional>

#include "core/frames.hpp"
#include "core/mesh.hpp"

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

/// A smaller turn has no axis: rounding of coordinates of some 100 mm, 1e-13 mm, would shift it by more than
/// 1e-7 mm.
inline constexpr double least_turn_rad = 1e-6;

/// The screw that takes a body from one pose to another.
struct HelicalAxis {
  double rotation_rad = 0.0;    ///< in (0, pi]
  double translation_mm = 0.0;  ///< along `direction`
  Eigen::Vector3d direction;    ///< unit; the turn about it is right-handed
  Eigen::Vector3d point_mm;     ///< of the axis, nearest to the point asked for
};

/// The screw from `X_fixed_start` to `X_fixed_end` of a moving body, in the fixed frame, as `near_fixed_mm`
/// is. Nothing where it turns by less than least_turn_rad. Source: Spoor and Veldpaus (1980) J Biomech
/// 13:391-393. Differs: the angle is the arc tangent of the skew part's length and the trace, which loses no
/// digits for small turns; beyond a right angle the direction comes from the symmetric part.
std::optional<HelicalAxis> helical_axis(const Pose& X_fixed_start, const Pose& X_fixed_end,
                                        const Eigen::Vector3d& near_fixed_mm);

/// Half of the screw's turn added to the start: the orientation midway. The start's where there is no axis.
Eigen::Matrix3d orientation_midway(const Pose& X_fixed_start, const Pose& X_fixed_end);

/// The centre of the turn as seen along Z, (x, y) of the fixed frame: where the perpendicular bisectors meet
/// of the ways, in the plane, of the moving point that starts at `near_fixed_mm` and of any other point that
/// keeps to the plane (Reuleaux; thesis figure 3). Nothing where the turn about Z is below least_turn_rad.
std::optional<Eigen::Vector2d> instant_centre_mm(const Pose& X_fixed_start, const Pose& X_fixed_end,
                                                 const Eigen::Vector3d& near_fixed_mm);

}  // namespace vrda
