#include "ligament/fibre_path.hpp"

#include "ligament/wrap_path.hpp"

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

WrapPath round_wrap(const Wrap& wrap, const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm)
{
  switch (wrap.shape) {
    case WrapShape::cylinder:
      return cylinder_path(start_mm, end_mm, wrap.radii_mm.x(), wrap.radii_mm.z());
    case WrapShape::ellipsoid:
      return ellipsoid_path(start_mm, end_mm, wrap.radii_mm);
  }
  return {};
}

}  // namespace

Placement placed(const Attitude& attitude, const MovingPose& pose)
{
  return {reference_rotation(attitude), rotation_y(pose.theta_rad), pose.translation_mm};
}

FibrePath fibre_path(const Fibre& fibre, const std::vector<Wrap>& wraps, const Placement& placement)
{
  const Eigen::Vector3d reference_mm = placement.R_S_reference * fibre.reference_mm;
  const Eigen::Vector3d moving_mm = placement.t_S_moving_mm + placement.R_S_moving * fibre.moving_mm;
  if (fibre.wrap < 0) return straight_path(reference_mm, moving_mm);
  const Wrap& wrap = wraps[static_cast<std::size_t>(fibre.wrap)];
  const bool is_on_moving = wrap.body == WrapBody::moving;
  const Eigen::Matrix3d R_S_wrap =
      (is_on_moving ? placement.R_S_moving : placement.R_S_reference) * wrap.X_body_wrap.linear();
  // The way starts on the object that bears the wrap, so that its end is the one that moves over it.
  const auto in_wrap = [&](const Eigen::Vector3d& p_body_mm) {
    return Eigen::Vector3d(wrap.X_body_wrap.linear().transpose() *
                           (p_body_mm - wrap.X_body_wrap.translation()));
  };
  const Eigen::Vector3d across_mm =
      is_on_moving
          ? Eigen::Vector3d(placement.R_S_moving.transpose() * (reference_mm - placement.t_S_moving_mm))
          : Eigen::Vector3d(placement.R_S_reference.transpose() * moving_mm);
  const WrapPath round =
      round_wrap(wrap, in_wrap(is_on_moving ? fibre.moving_mm : fibre.reference_mm), in_wrap(across_mm));
  if (!round.is_wrapped) return straight_path(reference_mm, moving_mm);
  FibrePath path;
  path.length_mm = round.length_mm;
  path.is_wrapped = true;
  path.direction = R_S_wrap * (is_on_moving ? Eigen::Vector3d(-round.arrival) : round.arrival);
  path.end_mm = is_on_moving ? reference_mm : moving_mm;
  path.end_body = is_on_moving ? WrapBody::reference : WrapBody::moving;
  path.bending = R_S_wrap * round.bending * R_S_wrap.transpose();
  return path;
}

}  // namespace vrda
