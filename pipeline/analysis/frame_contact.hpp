/// Contact constraints of one frame: distances of the features of a directional gap query, extended to
/// planes and lines, with their derivatives over a general displacement of the moving object.
#pragma once

#include <vector>

#include "analysis/pose_meter.hpp"
#include "analysis/pose_path.hpp"
#include "solve/contact_constraint.hpp"

namespace vrda::analysis {

/// A length and its derivative over a left rotation of the pose (rad) and a translation (mm), both in S.
struct Measure {
  double mm = 0.0;
  Vector6d gradient = Vector6d::Zero();
};

/// Distance of a feature along its normal (negative: overlap) and along Delta.
struct FeatureMeasure {
  Measure separation, travel;
};

/// A feature, fixed in both bodies.
struct FeatureConstraint {
  solve::ContactConstraint contact;
  double sign = 1.0;  ///< of the edges' cross product, so that it is the reaction on the moving object
  int age = 0;        ///< iterations since it was found
};

/// The features of a frame that matter near its pose.
struct FrameFeatures {
  std::vector<FeatureConstraint> kept;
  double band_mm = 0.1;  ///< of the query: widened or narrowed by the number of features found
};

/// Exact at every pose for the extended face or lines. `X`: moving to reference, S at zero attitude; Delta
/// moves with the moving object, whose +Y it is.
FeatureMeasure measured(const FeatureConstraint& feature, const Pose& X);

/// The attitude at which X is a rotation about Delta alone, and that pose: R = Rz(-flexion) Rx(varus)
/// Ry(theta).
struct PlacedPose {
  Attitude attitude;
  MovingPose pose;
};
PlacedPose placed(const Pose& X);

/// What a frame's constraints need of the current pose.
struct FrameContact {
  std::vector<Measure> separations;  ///< of the features near contact: at least 0
  /// Nearest travel of the whole pair, or of the medial and the lateral compartment; infinite without any.
  std::vector<Measure> travels;
  double least_travel_mm = 0.0;  ///< of the whole pair
};

/// Queries of one thread. Their cached state affects the time, not the results.
class ContactSampler {
 public:
  /// `scene` must outlive it.
  explicit ContactSampler(const analysis::AuditScene& scene);

  /// Updates `known` with the features near contact at the pose.
  FrameContact sample(const Pose& X, FrameFeatures& known);

 private:
  Measure nearest(geometry::GapQuery& query, const PlacedPose& at, const Pose& X);
  FeatureConstraint constraint_of(const geometry::GapFeature& feature, const PlacedPose& at) const;

  const analysis::AuditScene& scene_;
  solve::RotationScale scale_;  // pivot at the origin
  geometry::GapQuery query_, medial_query_, lateral_query_;
  bool has_compartments_ = false;
};

}  // namespace vrda::analysis
