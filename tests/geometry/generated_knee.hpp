/// The generated knee as a subject and as a template.
#pragma once

#include "geometry/knee_fit.hpp"
#include "geometry/shapes.hpp"

namespace vrda::test {

/// Bones without menisci and fibula, shafts included.
inline geometry::KneeSurfaces generated_knee()
{
  const geometry::Shape shape = geometry::generate_shape({"knee", {}, {}});
  geometry::KneeSurfaces knee;
  for (const geometry::ShapePart& part : shape.reference) append(knee.femur.bone, part.mesh);
  for (const geometry::ShapePart& part : shape.moving) {
    if (part.name.starts_with("tibia")) append(knee.tibia.bone, part.mesh);
  }
  return knee;
}

inline geometry::TemplateKnee generated_template()
{
  return {generated_knee(), Eigen::Vector3d::Zero()};
}

inline geometry::KneeSurfaces moved(geometry::KneeSurfaces knee, const Pose& X_femur, const Pose& X_tibia,
                                    double unit_mm = 1.0)
{
  knee.femur.bone = transformed(knee.femur.bone, X_femur);
  knee.tibia.bone = transformed(knee.tibia.bone, X_tibia);
  knee.femur.bone.vertices_mm /= unit_mm;
  knee.tibia.bone.vertices_mm /= unit_mm;
  return knee;
}

/// A pose from whole numbers: the quaternion is normalised.
inline Pose pose(const Eigen::Vector4d& quaternion, const Eigen::Vector3d& t_mm)
{
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(quaternion).normalized().toRotationMatrix();
  X.translation() = t_mm;
  return X;
}

inline double angle_between_rad(const Pose& a, const Pose& b)
{
  const Eigen::Matrix3d R = a.linear().transpose() * b.linear();
  return (R - Eigen::Matrix3d::Identity()).norm() / std::sqrt(2.0);  // small angles
}

}  // namespace vrda::test
