#include "solve/joint_map.hpp"

#include <Eigen/Geometry>

#include "model/coordinates.hpp"
#include "core/trig.hpp"
#include "model/ligaments.hpp"

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

Work work_of(const Loads& loads, const LoadPotential* applied, const SolverPosition& at)
{
  const Eigen::Vector3d t = at.pose.translation_mm, turning_nmm = loads.point_mm.cross(loads.force_n);
  Vector5d constant;
  constant << loads.force_n, loads.moment_nmm + turning_nmm.y(), loads.varus_moment_nmm + turning_nmm.x();
  if (applied != nullptr) constant += applied->constant;
  Vector5d coordinates;
  coordinates << t, at.pose.theta_rad, at.attitude.varus_rad;
  Work work;
  work.work_nmm = constant.dot(coordinates);
  // The wrench whose work is that on theta, on varus and none on flexion: about Y, X and -(0, sin, cos).
  const SinCos varus = sin_cos(at.attitude.varus_rad);
  const Eigen::Vector3d flexion_axis(0.0, varus.sin, varus.cos), force_n = constant.head<3>();
  const double mx = constant(about_varus) - force_n.dot(Eigen::Vector3d::UnitX().cross(t));
  const double my = constant(about_y);
  const double mz = -(varus.sin * my + force_n.dot(flexion_axis.cross(t))) / varus.cos;
  work.wrench << mx, my, mz, force_n;
  if (applied == nullptr) return work;
  const model::JointPlacement placement = model::joint_placement(at.attitude, at.pose);
  for (const LoadPotential::PointForce& force : applied->forces) {
    const Eigen::Vector3d force_S_n = placement.R_S_reference * force.force_reference_n;
    const Eigen::Vector3d p = t + placement.R_S_moving * force.point_moving_mm;
    work.work_nmm += force_S_n.dot(p);
    work.wrench += wrench_of(force_S_n, p, at);
  }
  for (const TensionLine& line : applied->lines) {
    const Eigen::Vector3d p = t + placement.R_S_moving * line.moving_mm;
    const Eigen::Vector3d span_mm = placement.R_S_reference * line.reference_mm - p;
    work.work_nmm -= line.tension_n * span_mm.norm();
    work.wrench += wrench_of(line.tension_n * span_mm.normalized(), p, at);
  }
  return work;
}

}  // namespace vrda::solve
