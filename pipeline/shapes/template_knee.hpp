/// The right knee that `vrda prepare` registers: closer to real knees than the generic knee, whose surfaces
/// are made for contact. Origin: the flexion axis; extension.
#pragma once

#include "shapes/shapes.hpp"

namespace vrda::shapes {

/// Femur and tibia with 50 and 95 mm of bone, cartilage included, and the fibula.
Shape right_template_knee();
std::vector<ShapeFibre> right_template_knee_fibres();
extern const char* const template_knee_fibre_sources;  ///< comment lines of the fibre table

/// Whether a point of its surface is covered by cartilage.
bool is_articular_femur(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& normal);
bool is_articular_tibia(const Eigen::Vector3d& p_mm, const Eigen::Vector3d& normal);

}  // namespace vrda::shapes
