/// Ligament bundles of a generated knee between its bones, given as level sets. In: attachments in mm,
/// canonical axes of the right knee, before projection. Out: fibres with slack lengths for the stated
/// reference strain.
#pragma once

#include "geometry/shapes.hpp"

namespace vrda::geometry {

/// Attachments of a bundle's fibres are evenly spaced between two points on the femur and two on the tibia
/// (or the fibula's head), projected onto the bone.
struct Bundle {
  const char* name;
  int n_fibres;
  double stiffness_n;       ///< of all its fibres together
  double reference_strain;  ///< of each in the pose of the fields
  Eigen::Vector3d first_femur_mm, last_femur_mm;
  Eigen::Vector3d first_tibia_mm, last_tibia_mm;
  double (*moving_field)(const Eigen::Vector3d&);
};

/// `clearance_mm`: distance of the moving parts below the pose of the fields, to which slack lengths refer.
std::vector<ShapeFibre> fibres_of(const std::vector<Bundle>& bundles,
                                  double (*femur_field)(const Eigen::Vector3d&), double clearance_mm);

}  // namespace vrda::geometry
