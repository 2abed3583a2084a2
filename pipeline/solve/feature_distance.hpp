/// Distance of a contact constraint along its own normal, for every motion of the moving object.
#pragma once

#include "solve/contact_constraint.hpp"
#include "solve/joint_map.hpp"

namespace vrda::solve {

/// Positive: apart. `wrench` is the derivative over the twist, in (rad, mm): the moment and force of a unit
/// contact force.
struct FeatureDistance {
  double distance_mm = 0.0;
  Vector6d wrench = Vector6d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();    ///< unit, reaction on the moving object, S
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< on the reference, S
};

/// `pivot_mm` is RotationScale::pivot_mm, to which the constraint's moving point refers. Faces and edges are
/// extended without limit, as in clearance(). Infinite with a zero wrench for parallel edges.
FeatureDistance feature_distance(const ContactConstraint& constraint, const SolverPosition& at,
                                 const Eigen::Vector3d& pivot_mm);

}  // namespace vrda::solve
