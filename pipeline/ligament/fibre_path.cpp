#include "ligament/fibre_path.hpp"

#include "core/error.hpp"
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

/// Round its wrap, in the frame of it. The way starts on the object that bears the wrap, so that its end is
/// the one that moves over it.
WrapPath round_wrap(const Fibre& fibre, const Wrap& wrap, const Placement& placement)
{
  const Eigen::Matrix3d R_moving_S = placement.R_S_moving.transpose();
  const auto in_wrap = [&](const Eigen::Vector3d& p_body_mm) {
    return Eigen::Vector3d(wrap.X_body_wrap.linear().transpose() *
                           (p_body_mm - wrap.X_body_wrap.translation()));
  };
  Eigen::Vector3d start_mm, end_mm;
  if (wrap.body == WrapBody::moving) {
    start_mm = in_wrap(fibre.moving_mm);
    end_mm = in_wrap(R_moving_S * (placement.R_S_reference * fibre.reference_mm - placement.t_S_moving_mm));
  } else {
    const Eigen::Vector3d moving_mm = placement.t_S_moving_mm + placement.R_S_moving * fibre.moving_mm;
    start_mm = in_wrap(fibre.reference_mm);
    end_mm = in_wrap(placement.R_S_reference.transpose() * moving_mm);
  }
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
  const WrapPath round = round_wrap(fibre, wrap, placement);
  if (!round.is_wrapped) return straight_path(reference_mm, moving_mm);
  const bool is_on_moving = wrap.body == WrapBody::moving;
  const Eigen::Matrix3d R_S_wrap =
      (is_on_moving ? placement.R_S_moving : placement.R_S_reference) * wrap.X_body_wrap.linear();
  FibrePath path;
  path.length_mm = round.length_mm;
  path.is_wrapped = true;
  path.direction = R_S_wrap * (is_on_moving ? Eigen::Vector3d(-round.arrival) : round.arrival);
  path.end_mm = is_on_moving ? reference_mm : moving_mm;
  path.end_body = is_on_moving ? WrapBody::reference : WrapBody::moving;
  path.bending = R_S_wrap * round.bending * R_S_wrap.transpose();
  return path;
}

FibreWay fibre_way(const Fibre& fibre, const std::vector<Wrap>& wraps, const Placement& placement,
                   std::span<Eigen::Vector3d> points_mm)
{
  check(points_mm.size() >= 4, "a fibre's way has room for four points");
  points_mm.front() = placement.R_S_reference * fibre.reference_mm;
  points_mm.back() = placement.t_S_moving_mm + placement.R_S_moving * fibre.moving_mm;
  const Eigen::Vector3d start_mm = points_mm.front(), span_mm = points_mm.back() - start_mm;
  const std::size_t last = points_mm.size() - 1;
  const WrapPath round =
      fibre.wrap < 0 ? WrapPath{} : round_wrap(fibre, wraps[static_cast<std::size_t>(fibre.wrap)], placement);
  if (!round.is_wrapped) {
    for (std::size_t k = 1; k < last; ++k)
      points_mm[k] = start_mm + static_cast<double>(k) / static_cast<double>(last) * span_mm;
    return {span_mm.norm(), false};
  }
  const Wrap& wrap = wraps[static_cast<std::size_t>(fibre.wrap)];
  const bool is_on_moving = wrap.body == WrapBody::moving;
  for (std::size_t k = 1; k < last; ++k) {
    // The way starts at the object that bears the wrap; the points start at the reference.
    const double part = static_cast<double>(k - 1) / static_cast<double>(last - 2);
    const double along_mm = (is_on_moving ? 1.0 - part : part) * round.arc_mm;
    const Eigen::Vector3d p_body_mm =
        wrap.X_body_wrap * (wrap.shape == WrapShape::cylinder
                                ? cylinder_point_mm(round, along_mm, wrap.radii_mm.x())
                                : ellipsoid_point_mm(round, along_mm, wrap.radii_mm));
    points_mm[k] = is_on_moving ? Eigen::Vector3d(placement.t_S_moving_mm + placement.R_S_moving * p_body_mm)
                                : Eigen::Vector3d(placement.R_S_reference * p_body_mm);
  }
  return {round.length_mm, true};
}

}  // namespace vrda
