#include "solve/feature_distance.hpp"

#include <Eigen/Geometry>
#include <limits>

#include "solve/rounded_contact.hpp"

namespace vrda::solve {
namespace {

constexpr double parallel_edges = 1e-6;  // sine of their angle

}  // namespace

FeatureDistance feature_distance(const ContactConstraint& constraint, const SolverPosition& at,
                                 const Eigen::Vector3d& pivot_mm)
{
  const Eigen::Matrix3d R_reference = reference_rotation(at.attitude),
                        R_moving = rotation_y(at.pose.theta_rad);
  const Eigen::Vector3d reference_mm = R_reference * constraint.reference_mm;
  const Eigen::Vector3d moving_mm =
      at.pose.translation_mm + R_moving * Eigen::Vector3d(pivot_mm + constraint.moving_mm);
  const Eigen::Vector3d apart_mm = moving_mm - reference_mm;
  FeatureDistance out;
  if (constraint.offset_mm > 0.0) {
    const RoundedContact near = rounded_distance(
        {constraint.kind, constraint.offset_mm, reference_mm, moving_mm,
         R_reference * constraint.reference_direction, R_moving * constraint.moving_direction},
        Eigen::Vector3d::UnitY());
    out.distance_mm = near.mm;
    if (!std::isfinite(near.mm)) return out;
    out.normal = near.normal;
    out.wrench = wrench_of(near.normal, near.moving_mm, at);
    out.point_mm = near.reference_mm + constraint.reference_offset_mm * near.normal;
    return out;
  }
  out.point_mm = reference_mm;
  switch (constraint.kind) {
    case ContactConstraint::Kind::face_of_reference:
      out.normal = R_reference * constraint.reference_direction;
      out.wrench = wrench_of(out.normal, moving_mm, at);
      break;
    case ContactConstraint::Kind::face_of_moving:
      out.normal = R_moving * constraint.moving_direction;
      out.wrench = wrench_of(out.normal, reference_mm, at);
      break;
    default: {
      const Eigen::Vector3d u = R_reference * constraint.reference_direction,
                            v = R_moving * constraint.moving_direction;
      Eigen::Vector3d across = u.cross(v);
      if (across.y() > 0.0) across = -across;
      const double length = across.norm();
      if (length < parallel_edges) {
        out.distance_mm = std::numeric_limits<double>::infinity();
        return out;
      }
      out.normal = across / length;
      out.wrench = wrench_of(out.normal, moving_mm, at);
      // The normal turns with the moving edge: d(u x v) = u x (omega x v).
      const Eigen::Vector3d side_mm = apart_mm - out.normal.dot(apart_mm) * out.normal;
      const Eigen::Vector3d signed_u = u.cross(v).y() > 0.0 ? Eigen::Vector3d(-u) : u;
      out.wrench.head<3>() += v.cross(side_mm.cross(signed_u)) / length;
      break;
    }
  }
  out.distance_mm = out.normal.dot(apart_mm);
  return out;
}

}  // namespace vrda::solve
