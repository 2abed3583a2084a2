#include "ligament/fibre_path.hpp"

namespace vrda {
namespace {

FibrePath straight_path(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm)
{
  FibrePath path;
  path.end_mm = to_mm;
  const Eigen::Vector3d span_mm = to_mm - from_mm;
  path.length_mm = span_mm.norm();
  if (path.length_mm == 0.0) return path;
  path.direction = span_mm / path.length_mm;
  path.bending = (Eigen::Matrix3d::Identity() - path.direction * path.direction.transpose()) / path.length_mm;
  return path;
}

}  // namespace

Placement placed(const Attitude& attitude, const MovingPose& pose)
{
  return {reference_rotation(attitude), rotation_y(pose.theta_rad), pose.translation_mm};
}

FibrePath fibre_path(const Fibre& fibre, const std::vector<Wrap>& /*wraps*/, const Placement& placement)
{
  const Eigen::Vector3d reference_mm = placement.R_S_reference * fibre.reference_mm;
  const Eigen::Vector3d moving_mm = placement.t_S_moving_mm + placement.R_S_moving * fibre.moving_mm;
  return straight_path(reference_mm, moving_mm);
}

}  // namespace vrda
