#include "solve/joint_map.hpp"

#include <Eigen/Geometry>

#include "core/trig.hpp"

namespace vrda::solve {

Vector6d wrench_of(const Eigen::Vector3d& force_n, const Eigen::Vector3d& p, const SolverPosition& at)
{
  Vector6d wrench;
  wrench << (p - at.pose.translation_mm).cross(force_n), force_n;
  return wrench;
}

JointMap::JointMap(const SolverFrame& frame)
{
  SolverFrame right = frame;
  right.side = Side::right;
  if (frame.side == Side::left) right.delta.z() = -right.delta.z();
  for (Eigen::Index k = 0; k < 3; ++k)
    R_solver_joint_.col(k) = solver_translation_mm(right, Eigen::Matrix3d::Identity().col(k));
}

SolverPosition JointMap::position_at(const JointCoordinates& coordinates) const
{
  // With Delta along the moving object's axis the coordinates are those of S: no rounding.
  if (R_solver_joint_.isIdentity(0.0))
    return {{coordinates(0), coordinates(1)}, {floating_translation_mm(coordinates), coordinates(2)}};
  const Pose X = joint_pose(coordinates);
  Pose X_solver = Pose::Identity();
  X_solver.linear() = R_solver_joint_ * X.linear() * R_solver_joint_.transpose();
  const JointCoordinates angles = joint_coordinates(X_solver);
  SolverPosition at;
  at.attitude = {angles(0), angles(1)};
  at.pose.theta_rad = angles(2);
  at.pose.translation_mm = reference_rotation(at.attitude) * (R_solver_joint_ * X.translation());
  return at;
}

JointCoordinates JointMap::coordinates_at(const SolverPosition& position) const
{
  const Eigen::Matrix3d A_transposed = reference_rotation(position.attitude).transpose();
  Pose X = Pose::Identity();
  X.linear() =
      R_solver_joint_.transpose() * (A_transposed * rotation_y(position.pose.theta_rad)) * R_solver_joint_;
  X.translation() = R_solver_joint_.transpose() * (A_transposed * position.pose.translation_mm);
  return joint_coordinates(X);
}

Matrix6d JointMap::twists(const JointCoordinates& coordinates, const SolverPosition& position) const
{
  const SinCos varus = sin_cos(coordinates(1));
  const Eigen::Matrix3d axes = floating_axes(coordinates);
  const Eigen::Vector3d t = axes * floating_translation_mm(coordinates);
  const Eigen::Vector3d e1 = Eigen::Vector3d::UnitZ(), e2 = axes.col(0), e3 = axes.col(1),
                        across = axes.col(2);
  const double across_by_varus =
      (coordinates(5) * varus.sin - coordinates(4)) / (varus.cos * varus.cos);  // mm/rad
  Eigen::Matrix<double, 3, 6> omega, u;
  omega << -e1, e2, e3, Eigen::Matrix3d::Zero();
  u.col(0) = (-e1).cross(t);
  u.col(1) = e2.cross(t) + across * across_by_varus;
  u.col(2).setZero();
  u.col(3) = e2;
  u.col(4) = e3 - across * (varus.sin / varus.cos);
  u.col(5) = across / varus.cos;
  const Eigen::Matrix3d R = reference_rotation(position.attitude) * R_solver_joint_;
  Matrix6d twists;
  twists.topRows<3>() = R * omega;
  twists.bottomRows<3>() = R * u;
  return twists;
}

Work work_of(const Loads& loads, const SolverPosition& at)
{
  const Eigen::Vector3d force_n = loads.force_n, t = at.pose.translation_mm;
  const Eigen::Vector3d turning_nmm = loads.point_mm.cross(force_n);
  const double on_theta = loads.moment_nmm + turning_nmm.y(),
               on_varus = loads.varus_moment_nmm + turning_nmm.x();
  Work work;
  work.work_nmm = force_n.dot(t) + on_theta * at.pose.theta_rad + on_varus * at.attitude.varus_rad;
  // The wrench whose work is that on theta, on varus and none on flexion: about Y, X and -(0, sin, cos).
  const SinCos varus = sin_cos(at.attitude.varus_rad);
  const Eigen::Vector3d flexion_axis(0.0, varus.sin, varus.cos);
  const double mx = on_varus - force_n.dot(Eigen::Vector3d::UnitX().cross(t));
  const double my = on_theta;
  const double mz = -(varus.sin * my + force_n.dot(flexion_axis.cross(t))) / varus.cos;
  work.wrench << mx, my, mz, force_n;
  return work;
}

}  // namespace vrda::solve
