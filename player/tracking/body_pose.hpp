/// Where a body stands, from the markers that are seen.
#pragma once

#include <cstdint>

#include "tracking/rigid_body.hpp"
#include "tracking/screw.hpp"

namespace vrda {

enum class FitStatus {
  fitted,
  too_few_markers,    ///< fewer than three seen
  collinear,          ///< those seen lie on a line, see least_spread_mm
  residual_too_large  ///< a marker is as far off as an outlier, and dropping does not help
};
const char* name_of(FitStatus status);

inline constexpr int most_outliers = 2;

struct FitOptions {
  double least_spread_mm = vrda::least_spread_mm;
  /// A marker further off than that makes an outlier of one (a reflection, a swapped label): the one, or else
  /// the two, whose absence leaves the least residual, as long as four markers agree without them.
  double outlier_mm = 2.0;
};

struct PoseFit {
  Pose X_tracker_body = Pose::Identity();  ///< identity without three markers that spread
  FitStatus status = FitStatus::too_few_markers;
  std::uint64_t used = 0;        ///< bit k: marker k
  int n_outliers = 0;            ///< seen and dropped
  double residual_rms_mm = 0.0;  ///< of the lengths left at the markers used
  MarkerCloud cloud;             ///< of the markers used, body frame
};

/// Least squares over proper rotations and translations, closed form. `seen` has an entry a marker; one that
/// is not finite, or farthest_mm away, counts as unseen. Allocates nothing.
/// Source: Umeyama (1991) IEEE PAMI 13:376-380, without scale.
PoseFit fit_pose(const RigidBody& body, MarkerSpan seen, const FitOptions& options = {});

/// What noise of `noise_mm` in every coordinate of every marker does to a fitted pose, to first order.
struct PoseError {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  ///< standard deviation about each of cloud.axes
  double centre_mm = 0.0;                              ///< of the cloud's centre, root mean square length
};
PoseError expected_error(const MarkerCloud& cloud, double noise_mm);

/// The same at a point of the body, root mean square length.
/// Source: Fitzpatrick, West, Maurer (1998) IEEE Trans Med Imaging 17:694-702, eq. 46.
double target_error_mm(const MarkerCloud& cloud, double noise_mm, const Eigen::Vector3d& p_body_mm);

/// Standard deviation of a coordinate that a fit's residual speaks for: 3 n numbers less the six fitted.
double noise_mm(const PoseFit& fit);

/// Markers that fire one after another.
struct Firing {
  double interval_s = 0.0;     ///< marker k fires k intervals after the frame's time
  double longest_gap_s = 0.2;  ///< since the pose before; after a longer one nothing is known of the velocity
  FitOptions fit = {};
};

/// A body on its way.
struct BodyMotion {
  TimedPose pose;
  Screw velocity;  ///< a second, tracker's frame; zero where not known
};

struct FiredFit {
  PoseFit fit;     ///< at the frame's time
  Screw velocity;  ///< from the pose before to this one; zero where not corrected
  bool is_corrected = false;
};

/// The pose at `time_s`, markers taken there along the twist that leads from the pose `before`: with a
/// constant twist exact, whatever it is. The velocity before is where the search begins: at high speed its
/// markers would look like outliers without. Without a pose before, too long after it, or sooner than all
/// markers can have fired since, as fit_pose().
FiredFit fit_fired(const RigidBody& body, MarkerSpan seen, double time_s,
                   const std::optional<BodyMotion>& before, const Firing& firing);

}  // namespace vrda
