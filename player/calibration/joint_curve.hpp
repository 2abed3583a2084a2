/// Motion of a joint along its flexion as a table: what a functional registration needs of a motion model, and
/// what its record keeps of it. In: knots of the pose of the tibia in the femur, mm and rad. Out: the pose at any
/// flexion.
#pragma once

#include <span>
#include <vector>

#include "model/mesh.hpp"

namespace vrda::calibration {

struct JointCurve {
  using Knot = Eigen::Matrix<double, 6, 1>;  ///< translation (mm), rotation vector (rad, below pi)

  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();  ///< of the joint; same numbers in both bones at zero pose
  double first_rad = 0.0, step_rad = 0.0;               ///< flexions of the knots
  std::vector<Knot> knots;                              ///< two or more

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

}  // namespace vrda::calibration
