/// Tracked bodies over time: the One-Euro filter, prediction, the pose of a body at a time of the local clock
/// from samples of its tool or markers.
#pragma once

#include <cstddef>

#include <array>

#include "bench/bench_file.hpp"
#include "bench/rigid_body.hpp"
#include "show/loop.hpp"
#include "store/motion.hpp"

namespace vrda::bench {

// The One-Euro filter: strong smoothing at rest, little delay in motion.
// Source: Casiez, Roussel, Vogel (2012) CHI, 2527-2530. Differs: the speed is computed from raw values
// instead of filtered ones, which gives the delay a closed form.

struct OneEuroOptions {
  double least_cutoff_hz = 1.0;  ///< at rest
  double hz_by_speed = 0.0;      ///< cutoff gained per unit of speed: rad/s, or counts/s
  double speed_cutoff_hz = 1.0;  ///< of the speed estimate
};

/// The delay at constant speed is 1 / (2 pi cutoff(speed)), at any sampling rate: 0.1 s at rest, 8 ms at 1
/// rad/s.
inline constexpr OneEuroOptions default_angle_filter{1.5, 18.0, 1.0};

/// Filter of a scalar. A repeated time changes nothing; an earlier time restarts the filter.
class OneEuroFilter {
 public:
  explicit OneEuroFilter(const OneEuroOptions& options) : options_(options) {}
  /// The filtered value at `time_s`, in the unit of `value`.
  double filtered(double value, double time_s);
  void start_over() { has_last_ = false; }

 private:
  OneEuroOptions options_;
  bool has_last_ = false;
  double time_s_ = 0.0, raw_ = 0.0, speed_ = 0.0, value_ = 0.0;
};

/// Filters each of a leg's angles.
class OneEuroAngles {
 public:
  explicit OneEuroAngles(const OneEuroOptions& options = default_angle_filter)
      : flexion_(options), varus_(options), theta_(options)
  {
  }
  LegAngles filtered(const LegAngles& angles, double time_s);
  void start_over();

 private:
  OneEuroFilter flexion_, varus_, theta_;
};

// Short-term extrapolation of poses and angles to compensate latency (thesis 8: prediction).

struct PredictionOptions {
  double window_s = 0.08;  ///< of samples used for the velocity
  /// Over shorter spans the velocity is dominated by noise: 0.1 mm over 8 ms, extrapolated by 33 ms, is 0.6
  /// mm.
  double shortest_span_s = 0.008;
  double longest_s = 0.1;  ///< limit of the extrapolation
};

struct TimedAngles {
  double time_s = 0.0;
  LegAngles angles;
};

/// Capacity; the oldest samples are dropped if the window holds more.
inline constexpr std::size_t max_window_samples = 32;

/// The samples in the window before the last one, by time. A time not after the last restarts.
template <typename Sample>
class SampleWindow {
 public:
  explicit SampleWindow(const PredictionOptions& options = {}) : options_(options) {}
  /// Appends the newest sample; drops those before the window.
  void add(const Sample& sample);
  void start_over() { n_ = 0; }
  bool has_sample() const { return n_ > 0; }

 protected:
  const Sample& last() const { return samples_[n_ - 1]; }
  /// Whether the samples span enough time for a velocity. Requires a sample.
  bool has_velocity() const;

  PredictionOptions options_;
  std::array<Sample, max_window_samples> samples_;
  std::size_t n_ = 0;
};

/// Extrapolates the last pose by the least-squares twist of the samples in the window (over their screws
/// relative to the last). Without a sufficient span the pose is held.
class PosePredictor : public SampleWindow<TimedPose> {
 public:
  using SampleWindow::SampleWindow;
  /// Requires a sample. Before the last sample's time: the last pose. Does not allocate.
  Pose at(double time_s) const;
  /// Per second, in the body's axes about its origin; zero if held.
  Screw velocity() const;
};

/// The same for a leg's angles, with the slope of a fitted line.
class AnglesPredictor : public SampleWindow<TimedAngles> {
 public:
  using SampleWindow::SampleWindow;
  /// Requires a sample. At most `longest_s` ahead of the last sample.
  LegAngles at(double time_s) const;
  LegAngles velocity() const;  ///< rad per second
};

/// Error statistics; the 95th percentile is the smallest error that 95 % do not exceed.
struct ErrorSummary {
  double rms = 0.0;
  double percentile_95 = 0.0;
  std::size_t n = 0;
};
/// `errors`: in any order and unit, not negative.
ErrorSummary summary_of(std::vector<double> errors);

struct PredictionError {
  ErrorSummary held, predicted;
};
struct PosePredictionError {
  PredictionError shift_mm, turn_rad;
};

/// Compares, for each sample, the prediction for `horizon_s` later with the series at that time,
/// interpolated along the screw between samples. Samples too near the end are left out. Times must
/// ascend.
PosePredictionError prediction_error(std::span<const TimedPose> series, double horizon_s,
                                     const PredictionOptions& options = {});

// Pose of a tracked body.

/// Maps device time stamps to the local clock. The offset is the smallest observed arrival delay; it is
/// relaxed by 0.1 ms a second to follow clock drift.
class ClockMap {
 public:
  /// Sampling time, s of the local clock; not later than the arrival and not earlier than the previous
  /// result. The offset is reset if the device clock steps back, or ahead by more than 1 s. Stamp 0 (no
  /// clock): the arrival.
  double time_s(std::int64_t device_ns, std::int64_t arrival_ns);

 private:
  bool has_offset_ = false;
  std::int64_t offset_ns_ = 0;  ///< local minus device clock
  std::int64_t device_ns_ = 0, arrival_ns_ = 0;
  double time_s_ = 0.0;
};

class BodyTracker {
 public:
  /// `first_tool`: index of the body's first tool in the order of BenchFile.
  BodyTracker(const BodySettings& settings, std::size_t first_tool);

  bool has_markers() const { return has_markers_; }
  bool has_tool(std::size_t tool) const { return tool >= first_tool_ && tool < first_tool_ + n_tools_; }
  /// Whether the tool was received since the last end_message(); its next sample starts a new message.
  bool has_received(std::size_t tool) const { return has_come_[tool - first_tool_]; }
  /// Adds a sample of one of the body's tools, measured at `time_s` of the local clock.
  void take(const Sample& sample, double time_s);
  /// Ends a message: fits the markers received since the last call. Returns true if there is a new pose.
  bool end_message();
  /// The tracker is disconnected.
  void disconnect();

  bool was_seen() const { return has_last_; }
  bool is_live() const { return is_live_; }
  ToolVisibility state() const { return state_; }
  /// Time of the last pose, s of the local clock.
  double seen_s() const { return last_.time_s; }
  /// Last pose; identity before the first one.
  const Pose& last() const { return last_.X; }
  /// Pose extrapolated to `time_s`; the last pose if the body is hidden.
  Pose at(double time_s) const;
  /// Last fit of the markers.
  const PoseFit& fit() const { return fit_; }

 private:
  void see(const TimedPose& pose);
  bool settle_markers();

  std::size_t first_tool_ = 0, n_tools_ = 1;
  std::vector<bool> has_come_;
  bool has_markers_ = false;
  RigidBody body_;
  Firing firing_;
  MarkerRow row_;  ///< markers since the last end_message()
  bool has_row_ = false;
  double row_time_s_ = 0.0;
  bool has_new_pose_ = false;  ///< tool only
  PoseFit fit_;
  Screw velocity_;  ///< of the last marker fit: start value of the next
  PosePredictor predictor_;
  TimedPose last_;
  bool has_last_ = false, is_live_ = false;
  ToolVisibility state_ = ToolVisibility::missing;
};

/// The trackers of a bench's bodies, by role, and the clock of the tracker.
class TrackedBodies {
 public:
  /// Without bodies of markers whose positions are unknown.
  explicit TrackedBodies(const BenchFile& bench);

  std::optional<BodyTracker>& operator[](BodyRole role) { return trackers_[role]; }
  const std::optional<BodyTracker>& operator[](BodyRole role) const { return trackers_[role]; }

  /// Passes a tool's sample to its body; calls `end_message(role)` before a sample that starts the body's
  /// next message. Returns the time of the sample on the local clock; hidden tools do not update the clock.
  template <typename EndMessage>
  double take(const Sample& sample, EndMessage end_message)
  {
    const double time_s = sample.is(ToolVisibility::seen) ? clock_.time_s(sample.device_ns, sample.arrival_ns)
                                                          : static_cast<double>(sample.arrival_ns) * s_per_ns;
    for (const BodyRole role : body_roles) {
      std::optional<BodyTracker>& tracker = trackers_[role];
      if (!tracker || !tracker->has_tool(sample.source)) continue;
      if (tracker->has_received(sample.source)) end_message(role);
      tracker->take(sample, time_s);
    }
    return time_s;
  }
  /// The tracker is disconnected.
  void disconnect();

 private:
  ByRole<std::optional<BodyTracker>> trackers_;
  ClockMap clock_;
};

// Command `vrda-player body`: measures a rigid body of markers with the bench's tracker. In: positions of
// the markers in the tracker's frame, mm. Out: their positions in the body's own frame, for the bench file.
// Throws InputError if too few markers are seen together.

/// Groups marker samples by message.
class MarkerFrames {
 public:
  /// `first_tool`: index of the first marker in the order of BenchFile.
  MarkerFrames(std::size_t first_tool, std::size_t n_markers);

  /// Adds a sample, in order of arrival; ignores other tools.
  void take(const Sample& sample);

  /// Frames with at least one visible marker; at most `most`, evenly selected.
  std::vector<MarkerRow> frames(std::size_t most) const;

 private:
  void end_row();

  std::size_t first_tool_, n_markers_;
  std::vector<bool> has_come_;  ///< received in the current row
  MarkerRow row_;
  std::vector<MarkerRow> rows_;
};

/// Expected pose error for the noise estimated from the fit's residual; zero without a fit.
struct FitQuality {
  double residual_mm = 0.0;      ///< root mean square at the used markers
  int n_markers = 0;             ///< used markers
  double rotation_sd_rad = 0.0;  ///< standard deviation of the rotation about the least certain axis
  double centroid_sd_mm = 0.0;   ///< standard deviation of the centroid of the markers
};
/// `fit`: of the markers of one message.
FitQuality quality_of(const PoseFit& fit);

/// "residual 0.12 mm at 4 markers, rotation sd 0.06 deg"; without a fit the reason.
std::string fit_text(const PoseFit& fit);

struct MeasureBodyOptions {
  std::string role, bench;
  double seconds = 10.0;
  bool is_quiet = false;
};

/// Measures the body and writes its lines for the bench file, with residual and expected error as comments.
/// Throws InputError, also for markers that do not form a valid body.
void measure_body(const MeasureBodyOptions& options, const show::Streams& streams);

/// Builds the body from `frames`, in the frame of the file's markers_mm if present. Throws InputError with
/// the bench file, the body and its markers.
BuiltBody build_measured_body(const std::vector<MarkerRow>& frames, const BenchFile& bench, BodyRole role);

/// Lines of the body for the bench file.
std::string bench_file_lines(const BuiltBody& built, const BenchFile& bench, BodyRole role);

// Whether the model shows the tracked leg: angles beyond its range, angles that no knee has, exchanged
// bodies.

/// Distance of a measured angle from the model's range; 0 within a degree of it, the noise of a tracked leg.
struct BeyondRange {
  double measured_rad = 0.0, nearest_rad = 0.0;  ///< `nearest`: at which the model is drawn
  bool is_beyond = false;
};

struct LegCheck {
  BeyondRange flexion, varus;
  /// Flexion 20 degrees before the model's range or 75 after it, varus 30 beside it, or 60 of rotation.
  bool is_implausible = false;
  /// With the bodies of femur and tibia exchanged the leg would be bent within the range, and it is not.
  bool are_bodies_exchanged = false;
  double rotation_rad = 0.0;

  bool is_wrong() const { return flexion.is_beyond || varus.is_beyond || is_implausible; }
};

/// `exchanged`: the angles if each body is on the other bone.
LegCheck check_leg(const store::Motion& motion, const LegAngles& measured, const LegAngles& exchanged);

/// "flexion 120, model ends at 90"; empty if nothing is wrong. Degrees.
std::string leg_check_text(const LegCheck& check);

}  // namespace vrda::bench
