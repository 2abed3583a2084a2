/// The One-Euro filter: strong smoothing at rest, little delay in motion.
/// Source: Casiez, Roussel, Vogel (2012) CHI, 2527-2530. Differs: the speed is computed from raw values
/// instead of filtered ones, which gives the delay a closed form.
#pragma once

#include <array>
#include <cstddef>

#include "bench/rigid_body.hpp"

namespace vrda::bench {

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

}  // namespace vrda::bench
