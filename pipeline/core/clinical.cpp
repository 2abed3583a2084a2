#include "core/clinical.hpp"

#include <cmath>

#include "core/trig.hpp"

namespace vrda::inline core {

ClinicalCoordinates clinical_coordinates(const Pose& X_reference_moving, Side side,
                                         const Eigen::Vector3d& rotation_centre_mm)
{
  Eigen::Matrix3d R = X_reference_moving.linear();
  // Displacement of the moving point at the rotation centre: independent of the meshes' origin.
  Eigen::Vector3d t = X_reference_moving * rotation_centre_mm - rotation_centre_mm;
  if (side == Side::left) {
    const Eigen::Vector3d m(1.0, 1.0, -1.0);
    R = m.asDiagonal() * R * m.asDiagonal();
    t.z() = -t.z();
  }
  // R = Rz(-f) Rx(v) Ry(i): row 2 is (-cos v sin i, sin v, cos v cos i), column 1 is
  // (sin f cos v, cos f cos v, sin v).
  ClinicalCoordinates result;
  result.varus_rad = arc_sine(R(2, 1));
  result.flexion_rad = arc_tangent2(R(0, 1), R(1, 1));
  result.internal_rotation_rad = arc_tangent2(-R(2, 0), R(2, 2));
  // Axes of Grood-Suntay: e1 the femoral flexion axis (Z), e3 the tibial long axis (R's column 1),
  // e2 = e3 x e1, floating and anterior.
  const Eigen::Vector3d e1 = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d e3 = R.col(1);
  const Eigen::Vector3d e2 = e3.cross(e1).normalized();
  result.lateral_mm = t.dot(e1);
  result.anterior_mm = t.dot(e2);
  result.proximal_mm = t.dot(e3);
  return result;
}

namespace {

struct Turn {
  double sin = 0.0, cos = 1.0;  ///< sin >= 0
  Eigen::Vector3d direction = Eigen::Vector3d::UnitZ();
};

Turn turn_of(const Eigen::Matrix3d& R)
{
  const Eigen::Vector3d skew = 0.5 * Eigen::Vector3d(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
  Turn turn;
  turn.sin = skew.norm();
  turn.cos = 0.5 * (R.trace() - 1.0);
  if (turn.cos >= 0.0) {
    if (turn.sin > 0.0) turn.direction = skew / turn.sin;
    return turn;
  }
  // (R + R^T) / 2 = cos I + (1 - cos) n n^T: after subtracting cos I the longest column is parallel to n.
  const Eigen::Matrix3d along =
      0.5 * (R + Eigen::Matrix3d(R.transpose())) - turn.cos * Eigen::Matrix3d::Identity();
  Eigen::Index longest = 0;
  along.diagonal().maxCoeff(&longest);
  turn.direction = along.col(longest).normalized();
  if (turn.direction.dot(skew) < 0.0) turn.direction = -turn.direction;
  return turn;
}

/// Cotangent of half the angle, from the form without cancellation.
double half_cotangent(double sin, double cos)
{
  return cos >= 0.0 ? (1.0 + cos) / sin : sin / (1.0 - cos);
}

Eigen::Matrix3d turned_by(const Eigen::Vector3d& n, double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  Eigen::Matrix3d N;
  N << 0, -n.z(), n.y(), n.z(), 0, -n.x(), -n.y(), n.x(), 0;
  return Eigen::Matrix3d::Identity() + a.sin * N + (1.0 - a.cos) * N * N;
}

}  // namespace

std::optional<HelicalAxis> helical_axis(const Pose& X_fixed_start, const Pose& X_fixed_end,
                                        const Eigen::Vector3d& near_fixed_mm)
{
  const Eigen::Matrix3d R = X_fixed_end.linear() * X_fixed_start.linear().transpose();
  const Turn turn = turn_of(R);
  HelicalAxis axis;
  axis.rotation_rad = arc_tangent2(turn.sin, turn.cos);
  if (axis.rotation_rad < min_rotation_rad) return {};
  axis.direction = turn.direction;
  // Displacement of the body's point that starts at `near`.
  const Eigen::Vector3d way_mm =
      X_fixed_end.translation() - near_fixed_mm + R * (near_fixed_mm - X_fixed_start.translation());
  axis.translation_mm = way_mm.dot(turn.direction);
  const Eigen::Vector3d across_mm = way_mm - axis.translation_mm * turn.direction;
  axis.point_mm = near_fixed_mm +
                  0.5 * (across_mm + half_cotangent(turn.sin, turn.cos) * turn.direction.cross(across_mm));
  return axis;
}

Eigen::Matrix3d midpoint_orientation(const Pose& X_fixed_start, const Pose& X_fixed_end)
{
  const std::optional<HelicalAxis> axis =
      helical_axis(X_fixed_start, X_fixed_end, X_fixed_start.translation());
  const Eigen::Matrix3d R_start = X_fixed_start.linear();
  return axis ? Eigen::Matrix3d(turned_by(axis->direction, 0.5 * axis->rotation_rad) * R_start) : R_start;
}

std::optional<Eigen::Vector2d> instant_centre_mm(const Pose& X_fixed_start, const Pose& X_fixed_end,
                                                 const Eigen::Vector3d& near_fixed_mm)
{
  const Eigen::Matrix3d R = X_fixed_end.linear() * X_fixed_start.linear().transpose();
  // The rotation about Z nearest to R, projected along Z.
  const double y = R(1, 0) - R(0, 1), x = R(0, 0) + R(1, 1);
  const double length = std::sqrt(x * x + y * y);
  if (std::abs(arc_tangent2(y, x)) < min_rotation_rad) return {};
  const Eigen::Vector3d way_mm =
      X_fixed_end.translation() - near_fixed_mm + R * (near_fixed_mm - X_fixed_start.translation());
  const Eigen::Vector2d across_mm(-way_mm.y(), way_mm.x());
  return near_fixed_mm.head<2>() +
         0.5 * (way_mm.head<2>() + half_cotangent(y / length, x / length) * across_mm);
}

}  // namespace vrda::inline core
