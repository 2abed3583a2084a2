#include "analysis/frame_contact.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "model/clinical.hpp"
#include "solve/rounded_contact.hpp"

namespace vrda::analysis {
namespace {

// Features up to a band beyond the nearest are constraints; contacts beyond the band are found in the next
// step. Six are active at most; congruent surfaces have thousands within tenths of a mm, which would be slow.
constexpr double least_band_mm = 1e-3, largest_band_mm = 0.3;
constexpr std::size_t few_features = 20, most_features = 60;
// Features of earlier steps are kept for some steps, so that the solution does not alternate between two
// features; older ones would be planes of faces that are no longer near.
constexpr int most_age = 3;
// Features further apart cannot be active after the next step.
constexpr double far_mm = 1.0;

constexpr double no_contact = std::numeric_limits<double>::infinity();

// Unit normal (reaction on the moving object) in S, and its derivative over a left rotation of the pose.
struct Normal {
  Eigen::Vector3d n;
  Eigen::Matrix3d change;
};

Normal normal_of(const FeatureConstraint& feature, const Eigen::Matrix3d& R)
{
  const solve::ContactConstraint& contact = feature.contact;
  const Eigen::Vector3d of_reference = contact.reference_direction, of_moving = R * contact.moving_direction;
  switch (contact.kind) {
    case solve::ContactConstraint::Kind::face_of_reference:
      return {of_reference, Eigen::Matrix3d::Zero()};
    case solve::ContactConstraint::Kind::face_of_moving:
      return {of_moving, -cross_matrix(of_moving)};
    default:
      break;
  }
  const Eigen::Vector3d across = feature.sign * of_reference.cross(of_moving);
  const double length = across.norm();
  const Eigen::Vector3d n = across / length;
  const Eigen::Matrix3d raw = -feature.sign * (cross_matrix(of_reference) * cross_matrix(of_moving));
  return {n, (raw - n * (n.transpose() * raw)) / length};
}

// The force acts at the nearest points; Delta turns with the moving object.
FeatureMeasure measured_rounded(const solve::ContactConstraint& contact, const Pose& X)
{
  const Eigen::Matrix3d R = X.linear();
  const Eigen::Vector3d delta = R.col(1);
  const solve::PlacedConstraint placed{
      contact.kind,          contact.offset_mm,           contact.reference_mm,
      X * contact.moving_mm, contact.reference_direction, R * contact.moving_direction};
  const solve::RoundedContact near = solve::rounded_distance(placed, delta);
  const solve::RoundedContact touch = solve::rounded_travel(placed, delta);
  FeatureMeasure out;
  out.separation = {near.mm, Vector6d::Zero()};
  out.travel = {touch.mm, Vector6d::Zero()};
  if (std::isfinite(near.mm))
    out.separation.gradient << (near.moving_mm - X.translation()).cross(near.normal), near.normal;
  if (!std::isfinite(touch.mm)) return out;
  const Eigen::Vector3d arm = touch.moving_mm - X.translation() + touch.mm * delta;
  out.travel.gradient << arm.cross(touch.normal), touch.normal;
  out.travel.gradient /= -touch.normal.dot(delta);
  return out;
}

}  // namespace

FeatureMeasure measured(const FeatureConstraint& feature, const Pose& X)
{
  if (feature.contact.offset_mm > 0.0) return measured_rounded(feature.contact, X);
  const Eigen::Matrix3d R = X.linear();
  const Normal normal = normal_of(feature, R);
  const Eigen::Vector3d arm = R * feature.contact.moving_mm;
  const Eigen::Vector3d apart = X.translation() + arm - feature.contact.reference_mm;
  FeatureMeasure out;
  out.separation.mm = normal.n.dot(apart);
  out.separation.gradient << arm.cross(normal.n) + normal.change.transpose() * apart, normal.n;
  const Eigen::Vector3d delta = R.col(1);
  const double slope = -normal.n.dot(delta);
  out.travel.mm = out.separation.mm / slope;
  Vector6d slope_gradient = Vector6d::Zero();
  slope_gradient.head<3>() = -(normal.change.transpose() * delta) - delta.cross(normal.n);
  out.travel.gradient = (out.separation.gradient - out.travel.mm * slope_gradient) / slope;
  return out;
}

PlacedPose placed(const Pose& X)
{
  const ClinicalCoordinates angles = clinical_coordinates(X, Side::right, Eigen::Vector3d::Zero());
  PlacedPose out;
  out.attitude = {angles.flexion_rad, angles.varus_rad};
  out.pose = {reference_rotation(out.attitude) * X.translation(), angles.internal_rotation_rad};
  return out;
}

ContactSampler::ContactSampler(const analysis::AuditScene& scene)
    : scene_(scene),
      query_(scene.reference_gap, scene.moving_gap),
      medial_query_(scene.reference_gap, scene.medial_gap),
      lateral_query_(scene.reference_gap, scene.lateral_gap),
      has_compartments_(!scene.medial_gap.is_empty() && !scene.lateral_gap.is_empty())
{
}

FeatureConstraint ContactSampler::constraint_of(const geometry::GapFeature& feature,
                                                const PlacedPose& at) const
{
  const solve::Configuration configuration{at.pose.translation_mm, at.pose.theta_rad, at.attitude.varus_rad};
  const solve::Rotations rotations(configuration, at.attitude.flexion_rad);
  FeatureConstraint out;
  out.contact = solve::contact_constraint_of(feature, {scene_.reference.mesh, scene_.moving.mesh, scale_},
                                             configuration, rotations);
  if (out.contact.kind == solve::ContactConstraint::Kind::edges) {
    const Eigen::Vector3d across = (rotations.of_reference * out.contact.reference_direction)
                                       .cross(rotations.of_moving * out.contact.moving_direction);
    out.sign = across.dot(feature.normal) < 0.0 ? -1.0 : 1.0;
  }
  return out;
}

Measure ContactSampler::nearest(geometry::GapQuery& query, const PlacedPose& at, const Pose& X)
{
  query.set_attitude(at.attitude);
  const geometry::GapResult& found = query.features(at.pose, 0.0);
  if (found.features.empty()) return {no_contact, Vector6d::Zero()};
  return measured(constraint_of(found.features.front(), at), X).travel;
}

FrameContact ContactSampler::sample(const Pose& X, FrameFeatures& known)
{
  const PlacedPose at = placed(X);
  query_.set_attitude(at.attitude);
  const geometry::GapResult& found = query_.features(at.pose, known.band_mm);
  std::vector<FeatureConstraint> features;
  for (const geometry::GapFeature& feature : found.features) {
    if (features.size() == most_features) break;
    features.push_back(constraint_of(feature, at));
  }
  if (found.features.size() < few_features) known.band_mm = std::min(2.0 * known.band_mm, largest_band_mm);
  if (found.features.size() > most_features) known.band_mm = std::max(0.5 * known.band_mm, least_band_mm);
  const std::size_t n_new = features.size();
  for (FeatureConstraint& old : known.kept) {
    const bool is_found = std::any_of(features.begin(), features.begin() + static_cast<std::ptrdiff_t>(n_new),
                                      [&old](const FeatureConstraint& feature) {
                                        return feature.contact.triangles == old.contact.triangles;
                                      });
    if (!is_found && ++old.age <= most_age) features.push_back(old);
  }
  FrameContact out;
  out.least_travel_mm = found.features.empty() ? no_contact : found.features.front().travel_mm;
  known.kept.clear();
  for (const FeatureConstraint& feature : features) {
    const FeatureMeasure at_pose = measured(feature, X);
    if (feature.age > 0 && !(at_pose.separation.mm < far_mm)) continue;
    out.separations.push_back(at_pose.separation);
    known.kept.push_back(feature);
  }
  if (has_compartments_) {
    out.travels = {nearest(medial_query_, at, X), nearest(lateral_query_, at, X)};
  } else {
    out.travels = {known.kept.empty() || found.features.empty() ? Measure{no_contact, Vector6d::Zero()}
                                                                : measured(known.kept.front(), X).travel};
  }
  return out;
}

}  // namespace vrda::analysis
