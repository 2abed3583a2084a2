/// Where something will be a little later if it goes on as it does (thesis 8: prediction).
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "tracking/leg.hpp"
#include "tracking/screw.hpp"

namespace vrda {

struct PredictionOptions {
  double window_s = 0.08;  ///< of the samples that the velocity comes from
  /// Samples closer together say nothing of a velocity but their noise: 0.1 mm of it over 8 ms, carried on by
  /// 33 ms, is 0.6 mm.
  double shortest_span_s = 0.008;
  double longest_s = 0.1;  ///< no prediction goes further ahead
};

struct TimedAngles {
  double time_s = 0.0;
  LegAngles angles;
};

/// Samples kept; older ones of a window that holds more are left out.
inline constexpr std::size_t most_window_samples = 32;

/// The last place, carried on by the twist that the samples of the window fit best (least squares over their
/// screws from the last). Samples that span too little are held. A time that is not after the last starts
/// over.
class PlacePredictor {
 public:
  explicit PlacePredictor(const PredictionOptions& options = {}) : options_(options) {}
  void add(const TimedPose& sample);
  void start_over() { n_ = 0; }
  bool has_sample() const { return n_ > 0; }
  /// At `time_s`; needs a sample. Before the last sample: the last. Allocates nothing.
  Pose at(double time_s) const;
  /// In the axes and about the origin of the body, a second; zero where it is held.
  Screw velocity() const;

 private:
  PredictionOptions options_;
  std::array<TimedPose, most_window_samples> samples_;  ///< by time
  std::size_t n_ = 0;
};

/// The same for a leg's angles, by the slopes of straight lines.
class AnglesPredictor {
 public:
  explicit AnglesPredictor(const PredictionOptions& options = {}) : options_(options) {}
  void add(const TimedAngles& sample);
  void start_over() { n_ = 0; }
  bool has_sample() const { return n_ > 0; }
  LegAngles at(double time_s) const;
  LegAngles velocity() const;  ///< rad a second

 private:
  PredictionOptions options_;
  std::array<TimedAngles, most_window_samples> samples_;
  std::size_t n_ = 0;
};

/// Over a series; the 95th percentile is the smallest error that 95 % do not exceed.
struct ErrorSummary {
  double rms = 0.0;
  double percentile_95 = 0.0;
  std::size_t n = 0;
};
ErrorSummary summary_of(std::vector<double> errors);

struct PredictionError {
  ErrorSummary held, predicted;
};
struct PlacePredictionError {
  PredictionError shift_mm, turn_rad;
};
struct AnglesPredictionError {
  PredictionError flexion_rad, varus_rad;
};

/// At each sample: what is said of `horizon_s` later against what the series says of it, between two samples
/// along the screw or line between them; samples too near the end are left out. Times must ascend.
PlacePredictionError prediction_error(std::span<const TimedPose> series, double horizon_s,
                                      const PredictionOptions& options = {});
AnglesPredictionError prediction_error(std::span<const TimedAngles> series, double horizon_s,
                                       const PredictionOptions& options = {});

}  // namespace vrda
