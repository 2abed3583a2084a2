/// Clinical description of motion: the Grood-Suntay coordinates of a pose (moving body, the tibia, in the
/// reference, the femur; formulas in schemas/clinical.md) and the helical axis between two poses.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "model/frames.hpp"
#include "model/mesh.hpp"
#include "core/units.hpp"

namespace vrda::inline model {

/// Angles: flexion +, varus (adduction) +, internal rotation +. Translations of the tibial point that
/// coincides with the rotation centre at the zero pose, along the Grood-Suntay axes: anterior +,
/// proximal +, lateral + on both sides.
struct ClinicalCoordinates {
  double flexion_rad = 0.0;
  double varus_rad = 0.0;
  double internal_rotation_rad = 0.0;
  double anterior_mm = 0.0;
  double proximal_mm = 0.0;
  double lateral_mm = 0.0;
};

/// Decomposes `X_reference_moving`: R = Rz(-flexion) Rx(varus) Ry(internal) on the right side; on the left
/// the mirrored pose is decomposed. `rotation_centre_mm` is in canonical coordinates of the joint's own side.
/// Source: Grood and Suntay (1983) J Biomech Eng 105:136-144.
ClinicalCoordinates clinical_coordinates(const Pose& X_reference_moving, Side side,
                                         const Eigen::Vector3d& rotation_centre_mm);

/// `angle` plus whole turns, within half a turn of `near`; the same bits where none is added.
double nearest_turn(double angle, double near, double turn = 2.0 * pi);

/// The angles plus whole turns: each is within half a turn of the one before it. NaN is skipped.
std::vector<double> unwrapped(std::vector<double> angles, double turn = 2.0 * pi);

/// Of the numbers (f, v, i) and (f + pi, pi - v, i + pi) of one orientation, plus whole turns, those that
/// change least from `before`; the latter point the floating axis, and anterior, the other way. At gimbal
/// lock, where only f - i or f + i is defined, both change equally; anterior is then undefined.
ClinicalCoordinates nearest_numbers(const ClinicalCoordinates& c, const ClinicalCoordinates& before);

/// The coordinates of successive poses as continuous curves, beyond the ranges of clinical_coordinates():
/// nearest_numbers() of each pose to those of the pose before.
class ContinuousCoordinates {
 public:
  ContinuousCoordinates(Side side, const Eigen::Vector3d& rotation_centre_mm);

  /// Of the next pose. The first has the numbers of clinical_coordinates(), and so has every pose, with equal
  /// bits, whose numbers need no change.
  ClinicalCoordinates next(const Pose& X_reference_moving);

  /// Poses so far at gimbal lock, or beyond it.
  int n_locked() const { return n_locked_; }

 private:
  Side side_;
  Eigen::Vector3d rotation_centre_mm_;
  std::optional<ClinicalCoordinates> before_;
  int n_locked_ = 0;
};

/// A warning about poses at gimbal lock; empty without any.
std::string gimbal_lock_text(int n_locked);

/// Smallest rotation with a defined axis: below it, rounding of coordinates of some 100 mm (1e-13 mm) shifts
/// the axis by more than 1e-7 mm.
inline constexpr double min_rotation_rad = 1e-6;

/// The screw motion from one pose of a body to another.
struct HelicalAxis {
  double rotation_rad = 0.0;    ///< in (0, pi]
  double translation_mm = 0.0;  ///< along `direction`
  Eigen::Vector3d direction;    ///< unit; the rotation about it is right-handed
  Eigen::Vector3d point_mm;     ///< of the axis, nearest to the given point
};

/// The screw motion from `X_fixed_start` to `X_fixed_end` of a moving body; the axis and `near_fixed_mm` are
/// in the fixed frame. Empty where the rotation is below min_rotation_rad. Source: Spoor and Veldpaus (1980)
/// J Biomech 13:391-393. Differs: the angle is the arc tangent of the skew part's norm and the trace, which
/// is accurate for small rotations; beyond a right angle the direction comes from the symmetric part.
std::optional<HelicalAxis> helical_axis(const Pose& X_fixed_start, const Pose& X_fixed_end,
                                        const Eigen::Vector3d& near_fixed_mm);

/// The start's orientation rotated by half the screw's angle; the start's orientation where there is no axis.
Eigen::Matrix3d midpoint_orientation(const Pose& X_fixed_start, const Pose& X_fixed_end);

/// The instant centre of the rotation about Z, (x, y) of the fixed frame: the intersection of the
/// perpendicular bisectors of the planar displacements of the moving point that starts at `near_fixed_mm` and
/// of any other point that stays in the plane (Reuleaux; thesis figure 3). Empty where the rotation about Z
/// is below min_rotation_rad.
std::optional<Eigen::Vector2d> instant_centre_mm(const Pose& X_fixed_start, const Pose& X_fixed_end,
                                                 const Eigen::Vector3d& near_fixed_mm);

}  // namespace vrda::inline model
