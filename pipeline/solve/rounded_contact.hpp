/// A contact constraint between objects rounded by an offset: distance along its own normal and travel into
/// contact, with the points where the force acts. Derivatives follow from these points alone: the distance of
/// two bodies changes as that of their nearest points, with the normal held.
#pragma once

#include "solve/contact_constraint.hpp"

namespace vrda::solve {

/// The bare features of both objects in one frame; directions as in ContactConstraint.
struct PlacedConstraint {
  ContactConstraint::Kind kind = ContactConstraint::Kind::face_of_reference;
  double offset_mm = 0.0;
  Eigen::Vector3d reference_mm, moving_mm, reference_direction, moving_direction;
};

struct RoundedContact {
  double mm = 0.0;               ///< distance or travel; infinite where they pass, the rest is then undefined
  Eigen::Vector3d normal;        ///< unit, reaction on the moving object, against Delta
  Eigen::Vector3d reference_mm;  ///< nearest point of the bare reference
  Eigen::Vector3d moving_mm;     ///< nearest point of the bare moving object, where it is now
};

/// Distance of the rounded features; negative: overlap.
RoundedContact rounded_distance(const PlacedConstraint& constraint, const Eigen::Vector3d& delta);

/// Travel along `delta` until they touch.
RoundedContact rounded_travel(const PlacedConstraint& constraint, const Eigen::Vector3d& delta);

}  // namespace vrda::solve
