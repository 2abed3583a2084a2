/// Bodies of labelled markers, and how they are built from tracker frames (thesis 8.5).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/text.hpp"
#include "model/frames.hpp"
#include "model/linear_algebra.hpp"
#include "model/mesh.hpp"

namespace vrda::bench {

/// Position of each marker of a body, by label; nullopt if not visible. mm, tracker's frame.
using MarkerRow = std::vector<std::optional<Eigen::Vector3d>>;
using MarkerSpan = std::span<const std::optional<Eigen::Vector3d>>;

/// Largest number of markers of a body.
inline constexpr Eigen::Index max_markers = 64;

/// Positions further from the tracker are treated as not visible.
inline constexpr double farthest_mm = 1e6;

struct RigidBody {
  Points markers_mm;  ///< [n, 3] body frame, by label
};

/// Principal axes of a set of markers.
struct MarkerCloud {
  int n = 0;
  Eigen::Vector3d centre_mm = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: principal axes
  /// Singular values of the centred positions, descending: root of the sum of squares along each axis. The
  /// second is 0 for collinear markers.
  Eigen::Vector3d spread_mm = Eigen::Vector3d::Zero();
};

/// Of the visible markers of `body`.
MarkerCloud cloud_of(const RigidBody& body, MarkerSpan seen);

/// Markers with a smaller second singular value count as collinear. With 0.1 mm of noise, typical of an
/// optical tracker, 5 mm leave the rotation about their line uncertain by 0.1 / 5 rad: a degree.
inline constexpr double least_spread_mm = 5.0;

struct BodyOptions {
  double least_spread_mm = vrda::bench::least_spread_mm;
  double tolerance_mm = 1e-9;  ///< convergence: largest motion of a marker in an iteration
  int most_iterations = 2000;
  /// Coordinates in the required frame, for three or more markers. Empty: origin at the mean of the
  /// markers, X from the first marker to the second, Y towards the first marker at least half as far from
  /// that line as the furthest.
  MarkerRow given_mm;
};

enum class BuildStatus { converged, iteration_limit };

struct BuiltMarker {
  double residual_rms_mm = 0.0;  ///< root mean square over `n_frames`
  int n_frames = 0;              ///< used frames in which it was visible
};

struct BuiltBody {
  RigidBody body;
  std::vector<BuiltMarker> markers;
  double residual_rms_mm = 0.0;  ///< over all markers and frames
  double given_rms_mm = 0.0;     ///< RMS distance from the given coordinates; 0 if none
  int n_frames = 0;              ///< used
  int n_refused = 0;             ///< frames with fewer than three markers, or collinear ones
  BuildStatus status = BuildStatus::iteration_limit;
};

/// Least-squares shape over all visible markers, each frame fitted by a rigid transform (generalised
/// Procrustes without scale, with missing markers). All frames have the same labels. Throws FitError
/// naming `file` for fewer than three markers, collinear ones, or one never visible with three others.
/// Source: Gower (1975) Psychometrika 40:33-51; missing points as in ten Berge, Kiers, Commandeur (1993) Br
/// J Math Stat Psychol 46:1-13.
BuiltBody build_body(const std::vector<MarkerRow>& frames, const std::string& file,
                     const BodyOptions& options = {});

/// A rejected fit, with the marks to repeat.
class FitError : public InputError {
 public:
  explicit FitError(Facts facts, std::vector<std::size_t> marks = {})
      : InputError(std::move(facts)), marks_(std::move(marks))
  {
  }
  /// Indices of the marks to repeat; empty if unknown.
  const std::vector<std::size_t>& marks() const { return marks_; }

 private:
  std::vector<std::size_t> marks_;
};

// Knee angles from the tracked poses of thigh and shank (left open in thesis 9).

/// Flexion +, varus (adduction) +, theta: internal rotation +, on both sides.
struct LegAngles {
  double flexion_rad = 0.0;
  double varus_rad = 0.0;
  double theta_rad = 0.0;
};

/// Poses of the bones in the bodies fixed to them; bones in canonical axes, as stored in a motion model.
struct LegBodies {
  Pose X_thigh_femur = Pose::Identity();
  Pose X_shank_tibia = Pose::Identity();
};

/// The tibia in the femur's frame, from the tracked poses of the bodies.
/// Arguments: bones in their bodies; thigh body and shank body in the tracker's frame.
Pose X_femur_tibia(const LegBodies& bodies, const Pose& X_tracker_thigh, const Pose& X_tracker_shank);

/// Attitude in a motion model's frame, and theta about its Delta, from the rotation of the tibia in the
/// femur's frame (canonical axes of its own side). With Delta = +Y these are the Grood-Suntay angles of
/// model/coordinates.hpp. If Delta depends on flexion, `frame` must be that of the current flexion. At 90
/// degrees of varus only a combination of flexion and theta is defined.
LegAngles leg_angles(const Pose& X_femur_tibia, const SolverFrame& frame);

/// The attitude at which to query the motion model, which gives theta itself.
Attitude attitude_of(const LegAngles& angles);

/// Inverse of leg_angles(): the tibia in the femur's frame, with `translation_mm` in the solver's frame S
/// (model/frames.hpp).
Pose X_femur_tibia(const LegAngles& angles, const SolverFrame& frame,
                   const Eigen::Vector3d& translation_mm = Eigen::Vector3d::Zero());

// Rigid motions as screws: the tangent space in which motions are averaged, scaled and extrapolated.

/// A constant twist over unit time: the velocity of point p is turn.cross(p) + shift.
struct Screw {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
};
/// The motion of `factor` units of time.
Screw scaled(const Screw& screw, double factor);

/// Exponential map.
Pose pose_of(const Screw& screw);
/// Logarithm, with a rotation of at most pi; for exactly pi one of the two solutions.
Screw screw_of(const Pose& pose);

/// Rotation about the axis of `turn_rad` by its length.
Eigen::Matrix3d rotation_of(const Eigen::Vector3d& turn_rad);
/// Rotation vector of length up to pi. `R` must be a rotation to rounding.
Eigen::Vector3d turn_of(const Eigen::Matrix3d& R);

/// X after `by`: shifted (mm), and rotated about the fixed axes through its origin (rotation vector, rad).
Pose moved(const Pose& X, const Eigen::Matrix<double, 6, 1>& by);

/// Root mean square; 0 without values.
double rms_of(std::span<const double> values);

/// Interpolates along the screw from `X_start` to `X_end`, at fraction `s`.
Pose between(const Pose& X_start, const Pose& X_end, double s);

/// A pose and its time.
struct TimedPose {
  double time_s = 0.0;
  Pose X = Pose::Identity();
};

/// Rotation about the fixed axes x, then y, then z, followed by a translation.
struct PoseParameters {
  Eigen::Vector3d shift_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
};
/// From six numbers in mm and degrees, as in files and on screen.
PoseParameters pose_parameters_of(std::span<const double> numbers);
/// First the rotations about x, y and z, then the translation.
Pose pose_of(const PoseParameters& numbers);
/// The inverse. With y at 90 degrees only a combination of x and z is defined: z is 0.
PoseParameters pose_parameters_of(const Pose& pose);

// Pose of a rigid body from its visible markers.

enum class FitStatus {
  fitted,
  too_few_markers,    ///< fewer than three seen
  collinear,          ///< the visible markers are on a line, see least_spread_mm
  residual_too_large  ///< a marker exceeds outlier_mm, and dropping markers does not help
};
/// As in reports: "too_few_markers".
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
