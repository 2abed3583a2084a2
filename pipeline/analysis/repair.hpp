/// The motion nearest to a measured one in units of the measurement's noise in which the bodies neither
/// overlap nor separate, smooth over the key.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/pose_meter.hpp"
#include "analysis/pose_path.hpp"
#include "store/derived.hpp"

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
  from_noise,  ///< for each coordinate from the noise (repair/smoothness.hpp)
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
  analysis::PoseAudit audit;               ///< narrow phase: independent of the queries that guide the repair
  analysis::CompartmentGaps compartments;  ///< NaN without compartments
};

struct RepairedFrame {
  Pose X_reference_moving = Pose::Identity();
  Attitude attitude;  ///< at which the pose is a rotation about Delta alone
  MovingPose pose;    ///< in S, at that attitude
  /// Repaired from measured in units of the noise: rotations, then translations, about and along the
  /// canonical axes (of a left joint: of its mirror image). Its norm is the Mahalanobis distance; that of pure
  /// noise has a mean square of the number of coordinates with noise.
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
/// the limit along Delta. Sequential quadratic programmes over all frames (repair/sequence_program.hpp) from
/// the measured motion: a local minimum. Same bits for any number of threads.
/// Throws InputError for noise that is missing (all zero), negative or not a number; poses that are not
/// finite or not rigid; keys that do not ascend; neighbouring frames more than 90 degrees apart; a period
/// that is not above 2 frames; a limit that is negative or not a number; no frame.
RepairedMotion repair(const analysis::AuditScene& scene, const MeasuredMotion& measured,
                      const RepairOptions& options);

}  // namespace vrda::analysis
