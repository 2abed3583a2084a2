/// Pose of a rigid body from its visible markers.
#pragma once

#include <cstdint>

#include "bench/rigid_body.hpp"
#include "bench/screw.hpp"

namespace vrda::bench {

enum class FitStatus {
  fitted,
  too_few_markers,    ///< fewer than three seen
  collinear,          ///< the visible markers are on a line, see least_spread_mm
  residual_too_large  ///< a marker exceeds outlier_mm, and dropping markers does not help
};
const char* name_of(FitStatus status);

inline constexpr int max_outliers = 2;

struct FitOptions {
  double least_spread_mm = vrda::bench::least_spread_mm;
  /// A fit with a residual above this drops the one marker, or else the two, whose removal gives the least
  /// residual, if at least four remaining markers agree (reflections, swapped labels).
  double outlier_mm = 2.0;
};

struct PoseFit {
  Pose X_tracker_body = Pose::Identity();  ///< identity if too few or collinear
  FitStatus status = FitStatus::too_few_markers;
  std::uint64_t used = 0;        ///< bit k: marker k
  int n_outliers = 0;            ///< visible and dropped
  double residual_rms_mm = 0.0;  ///< over the markers used
  MarkerCloud cloud;             ///< of the markers used, body frame
};

/// Rotation R with the largest trace of R^T H; H: sum of products target x source^T about the centre.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& H);

/// Least squares over proper rotations and translations, closed form. `seen` has one entry per marker; one
/// that is not finite, or farthest_mm away, counts as not visible. Does not allocate.
/// Source: Umeyama (1991) IEEE PAMI 13:376-380, without scale.
PoseFit fit_pose(const RigidBody& body, MarkerSpan seen, const FitOptions& options = {});

/// First-order error of a fitted pose for noise of `noise_mm` in every coordinate of every marker.
struct PoseError {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  ///< standard deviation about each of cloud.axes
  double centre_mm = 0.0;                              ///< of the cloud's centre, root mean square length
};
PoseError expected_error(const MarkerCloud& cloud, double noise_mm);

/// Target registration error at a point of the body, root mean square length.
/// Source: Fitzpatrick, West, Maurer (1998) IEEE Trans Med Imaging 17:694-702, eq. 46.
double target_error_mm(const MarkerCloud& cloud, double noise_mm, const Eigen::Vector3d& p_body_mm);

/// Noise per coordinate estimated from a fit's residual: 3 n coordinates minus six fitted parameters.
double noise_mm(const PoseFit& fit);

/// Timing of markers that fire one after another.
struct Firing {
  double interval_s = 0.0;     ///< marker k fires k intervals after the frame's time
  double longest_gap_s = 0.2;  ///< since the previous pose; after a longer gap the velocity is unknown
  FitOptions fit = {};
};

/// Pose and velocity of a body.
struct BodyMotion {
  TimedPose pose;
  Screw velocity;  ///< per second, tracker's frame; zero if unknown
};

struct FiredFit {
  PoseFit fit;     ///< at the frame's time
  Screw velocity;  ///< from the previous pose to this one; zero if not corrected
  bool is_corrected = false;
};

/// The pose at `time_s`, with markers moved to that time along the twist since the pose `before`; exact for
/// a constant twist. The previous velocity is the starting value: without it, markers of a fast body would
/// be outliers. Same as fit_pose() if there is no previous pose, the gap is too long, or it is shorter than
/// the firing of all markers.
FiredFit fit_fired(const RigidBody& body, MarkerSpan seen, double time_s,
                   const std::optional<BodyMotion>& before, const Firing& firing);

}  // namespace vrda::bench
