/// The joint's six coordinates in the solver frame S: positions, velocities and the work of the loads.
#pragma once

#include "model/frames.hpp"
#include "model/joint_coordinates.hpp"
#include "model/solver_options.hpp"
#include "solve/applied_loads.hpp"

namespace vrda::solve {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A twist of the moving object relative to the reference, in S: angular velocity (rad), then the velocity of
/// the moving object's origin (mm). A point at `p` moves by u + omega x (p - pose.translation_mm). Forces
/// are moments about that origin (N mm), then forces (N), so that their product is work.
inline Eigen::Vector3d velocity_at(const Vector6d& twist, const SolverPosition& at, const Eigen::Vector3d& p)
{
  return twist.tail<3>() + twist.head<3>().cross(p - at.pose.translation_mm);
}

/// Moment and force of `force_n` acting at the point `p`.
Vector6d wrench_of(const Eigen::Vector3d& force_n, const Eigen::Vector3d& p, const SolverPosition& at);

class JointMap {
 public:
  explicit JointMap(const SolverFrame& frame);

  SolverPosition position_at(const JointCoordinates& coordinates) const;
  JointCoordinates coordinates_at(const SolverPosition& position) const;

  /// Twists in S by each coordinate, columns; `position` is that of the coordinates.
  Matrix6d twists(const JointCoordinates& coordinates, const SolverPosition& position) const;

 private:
  Eigen::Matrix3d R_solver_joint_;
};

/// Work of the loads from zero coordinates of S (core/solver_options.hpp), N mm, and their wrench. Applied
/// loads and lines count with `applied`, which stands for them near one pose; null without any.
struct Work {
  double work_nmm = 0.0;
  Vector6d wrench = Vector6d::Zero();
};
Work work_of(const Loads& loads, const LoadPotential* applied, const SolverPosition& at);

}  // namespace vrda::solve
