/// How much of a step of motion a compartment rolls, and how much it slides.
#pragma once

#include "core/mesh.hpp"

namespace vrda {

/// A compartment at one pose. The two points are one place of contact.
struct Bearing {
  Pose X_reference_moving = Pose::Identity();
  Eigen::Vector3d p_reference_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_moving_mm = Eigen::Vector3d::Zero();
};

/// Travels are signed lengths in the sagittal plane (X anterior, Y proximal) of the moving body, anterior
/// positive.
struct Rolling {
  double reference_mm = 0.0;  ///< travel of the contact over the reference body
  double moving_mm = 0.0;     ///< travel of the contact over the moving body
  double rolling_mm = 0.0;    ///< what both share: the shorter where they go the same way, else 0
  double sliding_mm = 0.0;    ///< moving_mm - reference_mm: the reference's surface slides forward so far
};

/// From one bearing to the next. The reference's travel is brought into the moving body's axes midway between
/// both poses. Straight lines stand for arcs: of a circle turned by a they are short by a^2 / 24.
/// Source: rolling of two bodies upon each other; schemas/clinical.md writes it out.
Rolling rolling_between(const Bearing& start, const Bearing& end);

}  // namespace vrda
