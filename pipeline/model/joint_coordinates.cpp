#include "model/joint_coordinates.hpp"

#include "model/clinical.hpp"
#include "model/frames.hpp"
#include "core/trig.hpp"

namespace vrda::inline model {

const char* name_of(CoordinateRole role)
{
  return role == CoordinateRole::driven ? "driven" : role == CoordinateRole::given ? "given" : "free";
}

Eigen::Matrix3d floating_axes(const JointCoordinates& coordinates)
{
  return rotation_z(-coordinates(0)) * rotation_x(coordinates(1));
}

Eigen::Vector3d floating_translation_mm(const JointCoordinates& coordinates)
{
  // lateral = T . e1 with e1 = (0, sin varus, cos varus) along the floating axes.
  const SinCos varus = sin_cos(coordinates(1));
  return {coordinates(3), coordinates(4), (coordinates(5) - coordinates(4) * varus.sin) / varus.cos};
}

Pose joint_pose(const JointCoordinates& coordinates)
{
  const Eigen::Matrix3d axes = floating_axes(coordinates);
  Pose X = Pose::Identity();
  X.linear() = axes * rotation_y(coordinates(2));
  X.translation() = axes * floating_translation_mm(coordinates);
  return X;
}

JointCoordinates joint_coordinates(const Pose& X_reference_moving)
{
  const ClinicalCoordinates c =
      clinical_coordinates(X_reference_moving, Side::right, Eigen::Vector3d::Zero());
  JointCoordinates coordinates;
  coordinates << c.flexion_rad, c.varus_rad, c.internal_rotation_rad, c.anterior_mm, c.proximal_mm,
      c.lateral_mm;
  return coordinates;
}

}  // namespace vrda::inline model
