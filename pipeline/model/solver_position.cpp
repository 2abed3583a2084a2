// From a pose to the numbers of a motion step.
#include "model/frames.hpp"

#include "core/trig.hpp"

namespace vrda::inline model {

SolverPosition solver_position(const SolverFrame& frame, const Pose& X_reference_moving)
{
  // R = Rz(-f) Rx(v) Ry(theta), as in core/clinical.cpp but about the axes of S.
  const Pose X = X_solver_reference_moving(frame, X_reference_moving);
  const Eigen::Matrix3d R = X.linear();
  SolverPosition result;
  result.attitude = {arc_tangent2(R(0, 1), R(1, 1)), arc_sine(R(2, 1))};
  result.pose.theta_rad = arc_tangent2(-R(2, 0), R(2, 2));
  result.pose.translation_mm = reference_rotation(result.attitude) * X.translation();
  return result;
}

}  // namespace vrda::inline model
