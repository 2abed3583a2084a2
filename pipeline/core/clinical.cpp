#include "core/clinical.hpp"

#include "core/trig.hpp"

namespace vrda {

Clinical clinical_of(const Pose& X_reference_moving, Side side, const Eigen::Vector3d& rotation_centre_mm)
{
  Eigen::Matrix3d R = X_reference_moving.linear();
  // Where the moving point at the rotation centre went: free of the choice of the meshes' origin.
  Eigen::Vector3d t = X_reference_moving * rotation_centre_mm - rotation_centre_mm;
  if (side == Side::left) {
    const Eigen::Vector3d m(1.0, 1.0, -1.0);
    R = m.asDiagonal() * R * m.asDiagonal();
    t.z() = -t.z();
  }
  // R = Rz(-f) Rx(v) Ry(i): row 2 is (-cos v sin i, sin v, cos v cos i), column 1 is
  // (sin f cos v, cos f cos v, sin v).
  Clinical result;
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

}  // namespace vrda
