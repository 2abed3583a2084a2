#include "model/frames.hpp"

#include "core/units.hpp"

namespace vrda::inline model {
namespace {

Eigen::Vector3d flipped_z(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), -v.z()};
}

Eigen::Vector3d of_right_side(const SolverFrame& frame, const Eigen::Vector3d& v)
{
  return frame.side == Side::left ? flipped_z(v) : v;
}

Eigen::Matrix3d rotation_solver_world(const SolverFrame& frame)
{
  return shortest_rotation(of_right_side(frame, frame.delta), Eigen::Vector3d::UnitY());
}

}  // namespace

bool is_follower_name(const std::string& name)
{
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto is_allowed = [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '-' || c == '_';
  };
  return !name.empty() && name.size() <= 100 && is_letter(name.front()) &&
         std::all_of(name.begin(), name.end(), is_allowed) && !value_named<BodyIndex>(name);
}

Eigen::Matrix3d rotation_x(double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  Eigen::Matrix3d R;
  R << 1, 0, 0, 0, a.cos, -a.sin, 0, a.sin, a.cos;
  return R;
}

Eigen::Matrix3d rotation_y(double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  Eigen::Matrix3d R;
  R << a.cos, 0, a.sin, 0, 1, 0, -a.sin, 0, a.cos;
  return R;
}

Eigen::Matrix3d rotation_z(double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  Eigen::Matrix3d R;
  R << a.cos, -a.sin, 0, a.sin, a.cos, 0, 0, 0, 1;
  return R;
}

Eigen::Matrix3d shortest_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to)
{
  if (from == to) return Eigen::Matrix3d::Identity();
  const double c = from.dot(to);
  // 1 + c loses half the digits near -1: any axis perpendicular to `from` is valid there.
  if (c < -1.0 + 1e-12) {
    const Eigen::Vector3d trial =
        std::abs(from.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d axis = (trial - trial.dot(from) * from).normalized();
    return 2.0 * axis * axis.transpose() - Eigen::Matrix3d::Identity();
  }
  const Eigen::Vector3d v = from.cross(to);
  Eigen::Matrix3d V;
  V << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return Eigen::Matrix3d::Identity() + V + V * V / (1.0 + c);
}

Eigen::Matrix3d reference_rotation(const Attitude& attitude)
{
  return rotation_x(-attitude.varus_rad) * rotation_z(attitude.flexion_rad);
}

Pose pose_of(const MovingPose& pose)
{
  Pose X = Pose::Identity();
  X.linear() = rotation_y(pose.theta_rad);
  X.translation() = pose.translation_mm;
  return X;
}

Mesh solver_mesh(const Mesh& canonical, const SolverFrame& frame)
{
  const Eigen::Matrix3d R = rotation_solver_world(frame);
  Pose X_solver_canonical = Pose::Identity();
  X_solver_canonical.linear() = R;
  // Subtracting first avoids rounding for a mesh far from its origin when Delta is +Y.
  Pose X_centre = Pose::Identity();
  X_centre.translation() = -of_right_side(frame, frame.rotation_centre_mm);
  const Mesh limit = inward_limit(canonical);
  const Mesh right = frame.side == Side::left ? mirrored_z(limit) : limit;
  const Mesh centred = transformed(right, X_centre);
  return R.isIdentity(0.0) ? centred : transformed(centred, X_solver_canonical);
}

Pose X_reference_moving(const SolverFrame& frame, const Attitude& attitude, const MovingPose& pose)
{
  const Eigen::Matrix3d R = rotation_solver_world(frame);
  const Eigen::Vector3d c = of_right_side(frame, frame.rotation_centre_mm);
  const Eigen::Matrix3d A_transposed = reference_rotation(attitude).transpose();
  const Eigen::Matrix3d rotation = R.transpose() * (A_transposed * rotation_y(pose.theta_rad)) * R;
  const Eigen::Vector3d shift = R.transpose() * (A_transposed * pose.translation_mm);
  Pose X = Pose::Identity();
  X.linear() = rotation;
  X.translation() = c + shift - rotation * c;
  if (frame.side == Side::left) {
    // M X M with M = diag(1, 1, -1) changes signs only, so clinical coordinates are bitwise equal.
    const Eigen::Vector3d m(1.0, 1.0, -1.0);
    X.linear() = m.asDiagonal() * Eigen::Matrix3d(X.linear()) * m.asDiagonal();
    X.translation() = flipped_z(X.translation());
  }
  return X;
}

Pose X_solver_reference_moving(const SolverFrame& frame, const Pose& X_reference_moving)
{
  Eigen::Matrix3d rotation = X_reference_moving.linear();
  Eigen::Vector3d shift = of_right_side(frame, X_reference_moving.translation());
  if (frame.side == Side::left) {
    const Eigen::Vector3d m(1.0, 1.0, -1.0);
    rotation = m.asDiagonal() * Eigen::Matrix3d(rotation) * m.asDiagonal();
  }
  const Eigen::Vector3d c = of_right_side(frame, frame.rotation_centre_mm);
  const Eigen::Matrix3d R = rotation_solver_world(frame);
  Pose X = Pose::Identity();
  X.linear() = R * rotation * R.transpose();
  X.translation() = R * (shift + rotation * c - c);
  return X;
}

Eigen::Vector3d world_translation_mm(const SolverFrame& frame, const MovingPose& pose)
{
  return world_from_solver(frame, pose.translation_mm);
}

Eigen::Vector3d solver_translation_mm(const SolverFrame& frame, const Eigen::Vector3d& p_world_mm)
{
  return rotation_solver_world(frame) * of_right_side(frame, p_world_mm);
}

Eigen::Vector3d solver_moment_nmm(const SolverFrame& frame, const Eigen::Vector3d& moment_world_nmm)
{
  const Eigen::Vector3d& m = moment_world_nmm;
  return rotation_solver_world(frame) *
         (frame.side == Side::left ? Eigen::Vector3d(-m.x(), -m.y(), m.z()) : m);
}

Eigen::Vector3d world_from_solver(const SolverFrame& frame, const Eigen::Vector3d& v_solver)
{
  return of_right_side(frame, rotation_solver_world(frame).transpose() * v_solver);
}

bool is_uniform(const Eigen::Vector3d& factor)
{
  return factor.x() == factor.y() && factor.y() == factor.z();
}

}  // namespace vrda::inline model
