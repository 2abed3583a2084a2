#include "analysis/coordinates.hpp"

#include "core/trig.hpp"

namespace vrda::analysis {
namespace {

const Eigen::Vector3d reflection(1.0, 1.0, -1.0);

/// From canonical axes to those of the coordinates, of a right joint.
Eigen::Matrix3d R_axes_canonical(const Convention& right)
{
  if (!right.long_axis) return Eigen::Matrix3d::Identity();
  return shortest_rotation(*right.long_axis, Eigen::Vector3d::UnitY());
}

/// The point whose displacement the translations are.
Eigen::Vector3d tracked_point_mm(const Convention& right)
{
  return right.translations == Translations::mesh_origin ? Eigen::Vector3d::Zero() : right.rotation_centre_mm;
}

}  // namespace

Pose reflected(const Pose& X)
{
  Pose result = Pose::Identity();
  result.linear() = reflection.asDiagonal() * X.linear() * reflection.asDiagonal();
  result.translation() = reflection.asDiagonal() * X.translation();
  return result;
}

Convention right_sided(Convention convention)
{
  if (convention.side == Side::right) return convention;
  convention.side = Side::right;
  convention.rotation_centre_mm.z() *= -1.0;
  if (convention.long_axis) convention.long_axis->z() *= -1.0;
  return convention;
}

Coordinates coordinates_of(const Pose& X_reference_moving, const Convention& convention)
{
  const Convention right = right_sided(convention);
  const Pose X = convention.side == Side::left ? reflected(X_reference_moving) : X_reference_moving;
  const Eigen::Vector3d p_mm = tracked_point_mm(right);
  // In axes whose origin is the point: its displacement is the translation.
  const Eigen::Matrix3d R = R_axes_canonical(right);
  Pose turned = Pose::Identity();
  turned.linear() = R * X.linear() * R.transpose();
  turned.translation() = R * (X * p_mm - p_mm);
  const ClinicalCoordinates c = clinical_coordinates(turned, Side::right, Eigen::Vector3d::Zero());
  Coordinates value{c.flexion_rad, c.varus_rad,   c.internal_rotation_rad,
                    c.anterior_mm, c.proximal_mm, c.lateral_mm};
  if (right.translations == Translations::mesh_origin) Eigen::Vector3d::Map(&value[3]) = turned.translation();
  return value;
}

Pose right_sided_pose(const Coordinates& value, const Convention& convention)
{
  const auto [flexion_rad, varus_rad, internal_rad, anterior_mm, proximal_mm, lateral_mm] = value;
  const Convention right = right_sided(convention);
  Pose turned = Pose::Identity();
  turned.linear() = rotation_z(-flexion_rad) * rotation_x(varus_rad) * rotation_y(internal_rad);
  turned.translation() << anterior_mm, proximal_mm, lateral_mm;
  if (right.translations == Translations::rotation_centre) {
    // The displacement from its components along axes that are not orthogonal: e1 . e3 = sin(varus);
    // schemas/clinical.md, remarks.
    const Eigen::Vector3d e1 = Eigen::Vector3d::UnitZ(), e3 = turned.linear().col(1);
    const Eigen::Vector3d e2 = e3.cross(e1).normalized();
    const double s = sine(varus_rad), cos_sq = (1.0 - s) * (1.0 + s);
    turned.translation() = anterior_mm * e2 + ((lateral_mm - proximal_mm * s) / cos_sq) * e1 +
                           ((proximal_mm - lateral_mm * s) / cos_sq) * e3;
  }
  const Eigen::Matrix3d R = R_axes_canonical(right);
  const Eigen::Vector3d p_mm = tracked_point_mm(right);
  Pose X = Pose::Identity();
  X.linear() = R.transpose() * turned.linear() * R;
  X.translation() = p_mm + R.transpose() * turned.translation() - X.linear() * p_mm;
  return X;
}

}  // namespace vrda::analysis
