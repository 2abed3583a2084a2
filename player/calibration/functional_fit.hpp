/// Motion of a joint along its flexion as a table: what a functional registration needs of a motion model,
/// and what its record keeps of it. In: knots of the pose of the tibia in the femur, mm and rad. Out: the
/// pose at any flexion.
#pragma once

#include "bench/calibration_file.hpp"
#include "calibration/least_squares.hpp"
#include "core/units.hpp"

namespace vrda::calibration {

struct JointCurve {
  using Knot = Eigen::Matrix<double, 6, 1>;  ///< translation (mm), rotation vector (rad, below pi)

  Eigen::Vector3d centre_mm =
      Eigen::Vector3d::Zero();             ///< of the joint; same numbers in both bones at zero pose
  double first_rad = 0.0, step_rad = 0.0;  ///< flexions of the knots
  std::vector<Knot> knots;                 ///< two or more

  double last_rad() const { return first_rad + step_rad * static_cast<double>(knots.size() - 1); }
  /// Pose of the tibia in the femur: a cubic Hermite polynomial of each coordinate with the slopes of the
  /// neighbours' differences, so that its derivative is continuous; linear beyond the ends.
  Pose at(double flexion_rad) const;
};

/// The curve of a joint whose lengths are all `scale` times as large.
JointCurve scaled(const JointCurve& curve, double scale);

/// As stored in a record: centre (mm), first flexion and step (deg), then the knots (mm, deg).
std::vector<double> numbers_of(const JointCurve& curve);
/// Its inverse. Throws FitError with `file` and `field` if the numbers are not those of a curve.
JointCurve joint_curve_of(std::span<const double> numbers, const std::string& field, const std::string& file);

// Placement of a joint's model in thigh and shank from tracked motion, starting from landmarks (thesis 9:
// bones located from outside). In: bends of the leg, the model's motion, the placements by landmarks with
// their covariances; mm and rad. Out: both placements with a joint covariance, and their held-out errors.

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// One motion of the leg: the shank's body in the thigh's body.
struct FlexionTrial {
  std::string name;
  std::vector<Pose> X_thigh_shank;
};

/// A bone in its body by landmarks, with the covariance of an bench::Estimate in mm and rad.
struct BonePlacement {
  Pose X_body_bone = Pose::Identity();
  Matrix6 covariance_mm_rad = Matrix6::Identity();
};

struct FunctionalInput {
  std::span<const FlexionTrial> trials;
  const JointCurve& curve;  ///< of the model in the subject's size
  const BonePlacement& femur;
  const BonePlacement& tibia;
  bench::FunctionalSettings settings;
};

/// Root mean square distance and angle between tracked and fitted motion, flexion being free.
struct MotionError {
  double mm = 0.0;  ///< of the tibia's point at the joint's centre
  double rad = 0.0;
};

struct FunctionalFit {
  Pose X_thigh_femur = Pose::Identity(), X_shank_tibia = Pose::Identity();
  double flexion_range_rad = 0.0;
  int n_beyond = 0;  ///< samples beyond the model's flexions, which are not used
  /// Expected overlay error at the joint, see joint_error_mm(): by landmarks and by this fit.
  double landmarks_joint_mm = 0.0, joint_mm = 0.0;
  MotionError held_out;      ///< each trial by the fit to the others
  MotionError by_landmarks;  ///< all trials by the placements by landmarks
  MotionError deviation;     ///< of the joint from the model, as fitted
  /// Poses "femur" and "tibia"; residuals: held-out lengths of each trial (root mean square), mm.
  bench::Estimate estimate;
};

/// Places both bones so that the model's motion, with a smooth deviation from it, explains the tracked one;
/// the flexion of each sample is free, and directions that the motion does not determine remain those of the
/// landmarks. Throws FitError with `file` and the trial's index: fewer than two trials, a range of flexion of
/// less than 40 degrees, mostly beyond the model's range, or not explained by the model; a trial that
/// contradicts the others; a motion that does not improve on the landmarks; a fit that does not converge.
FunctionalFit fit_functional(const FunctionalInput& input, const std::string& file);

/// Range of flexion of a trial for the placements by landmarks, rad.
double flexion_range_rad(const FlexionTrial& trial, const FunctionalInput& input);
inline constexpr double least_flexion_range_rad = rad_from_deg(40.0);

/// Overlay error of a bone: root mean square displacement of the six points 30 mm from the joint's centre
/// along the axes, for a displacement of X_found against X_true.
double joint_error_mm(const Pose& X_found, const Pose& X_true, const Eigen::Vector3d& centre_mm);

}  // namespace vrda::calibration
