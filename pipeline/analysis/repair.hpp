/// The motion nearest to a measured one in units of the measurement's noise in which the bodies neither
/// overlap nor separate, smooth over the key.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/audit.hpp"
#include "analysis/sequence_program.hpp"
#include "solve/contact_constraint.hpp"
#include "store/motion_model.hpp"

namespace vrda::analysis {

/// A measured motion. Poses map stored moving vertices to stored reference vertices.
struct MeasuredMotion {
  std::string name;         ///< file, for messages
  std::vector<double> key;  ///< [n_frames] strictly ascending: time, percent or number of the frame
  std::vector<Pose> X_reference_moving;
};

/// Weight of the squared second differences over the key.
enum class Smoothing : std::int8_t {
  none,
  from_noise,  ///< for each coordinate from the noise (analysis/sequence_program.hpp)
  of_period,   ///< `period_frames`
};

/// The largest gap along Delta of the whole pair or, if the joint has compartments, of each of them.
enum class GapLimit : std::int8_t {
  none,
  /// Median of the measured gaps plus twice that part of their spread that the noise does not explain
  /// (normal-consistent median absolute deviation); at least 0.
  from_measurement,
  of_length,  ///< `gap_limit_mm`
};

struct RepairOptions {
  MeasurementNoise noise;  ///< must be stated
  Smoothing smoothing = Smoothing::from_noise;
  double period_frames = 0.0;  ///< oscillations of this period (in mean spacings) keep half their amplitude
  GapLimit gap_limit = GapLimit::from_measurement;
  double gap_limit_mm = 0.0;
  int n_threads = 1;
};

/// `repaired` and `unchanged` frames meet all limits; a `not_converged` one overlaps or has a gap beyond the
/// limit by more than repair_tolerance_mm; where nothing faces the moving object along Delta, contact limits
/// nothing.
using FrameStatus = store::RepairStatus;
const char* name_of(FrameStatus status);

/// Overlap, and gap beyond the limit, of a repaired frame.
inline constexpr double repair_tolerance_mm = 0.01;

struct FrameMeasurement {
  PoseAudit audit;               ///< narrow phase: independent of the queries that guide the repair
  CompartmentGaps compartments;  ///< NaN without compartments
};

struct RepairedFrame {
  Pose X_reference_moving = Pose::Identity();
  solve::SolverPosition at;
  /// Repaired from measured in units of the noise: rotations, then translations, about and along the
  /// canonical axes (of a left joint: of its mirror image). Its norm is the Mahalanobis distance; that of
  /// pure noise has a mean square of the number of coordinates with noise.
  Vector6d displacement = Vector6d::Zero();
  FrameStatus status = FrameStatus::unchanged;
  FrameMeasurement before, after;
};

struct RepairedMotion {
  std::vector<RepairedFrame> frames;
  std::vector<double> gap_limit_mm;           ///< of the whole pair, or medial and lateral; infinite: none
  Vector6d period_frames = Vector6d::Zero();  ///< of half amplitude for each coordinate; 2: not smoothed
  bool is_converged =
      false;  ///< false: the limit of iterations ended it; the frames are measured as they are
  int n_iterations = 0;
};

/// Minimises the sum over frames of squared distances from the measurement and of weighted squared second
/// differences, subject to: no overlap of features that face each other along Delta, and a contact within
/// the limit along Delta. Sequential quadratic programmes over all frames (sequence_program.hpp) from
/// the measured motion: a local minimum. Same bits for any number of threads.
/// Throws InputError for noise that is missing (all zero), negative or not a number; poses that are not
/// finite or not rigid; keys that do not ascend; neighbouring frames more than 90 degrees apart; a period
/// that is not above 2 frames; a limit that is negative or not a number; no frame.
RepairedMotion repair(const AuditScene& scene, const MeasuredMotion& measured, const RepairOptions& options);

// Repair of a motion model that is a sequence of frames.

/// The motion of a model, of a repaired one the measured motion, so that a repair can be repeated with other
/// options; `file` for messages. Throws InputError for a grid, a frame without a pose, and a
/// Delta that differs between frames.
MeasuredMotion measured_motion(const store::MotionModel& model, const std::string& file);

/// The bodies of that model for its Delta.
AuditScene scene_of(const store::MotionModel& model);

/// `model` with the repaired frames: attitudes, poses, gaps, contacts and clinical angles of the repaired
/// motion, and /repair with `measured`. Fibres and audits are left out: they belong to the measured poses.
store::MotionModel repaired_model(const store::MotionModel& model, const MeasuredMotion& measured,
                                  const RepairedMotion& motion, const MeasurementNoise& noise);

// Requirements on a measured motion, and the gap limit that follows from it.

/// Throws InputError as repair() says.
void require_repairable(const MeasuredMotion& measured, const RepairOptions& options);

/// A gap along Delta and its standard deviation by the noise of the pose.
struct MeasuredGap {
  double mm = 0.0;
  double noise_mm = 0.0;
};

/// The limit of GapLimit::from_measurement from the gaps of successive frames; infinite without gaps. The
/// noise of the gaps is what the poses' noise gives, or less if their second differences show less.
double supported_gap_mm(const std::vector<MeasuredGap>& gaps);

// Contact constraints of one frame: distances of the features of a directional gap query, extended to
// planes and lines, with their derivatives over a general displacement of the moving object.

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
  explicit ContactSampler(const AuditScene& scene);

  /// Updates `known` with the features near contact at the pose.
  FrameContact sample(const Pose& X, FrameFeatures& known);

 private:
  Measure nearest(geometry::GapQuery& query, const solve::SolverPosition& at, const Pose& X);
  FeatureConstraint constraint_of(const geometry::GapFeature& feature, const solve::SolverPosition& at) const;

  const AuditScene& scene_;
  solve::RotationScale scale_;  // pivot at the origin
  geometry::GapQuery query_;
  OfCompartments<geometry::GapQuery> compartment_queries_;
};

}  // namespace vrda::analysis
