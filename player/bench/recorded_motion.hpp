/// Motion of the tracked bodies in a recording, and the error that prediction would have had on it. Poses
/// take points of the tool to the tracker's frame, mm; times are ns of the local clock. An unseen body gives
/// an empty list.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bench/body_tracker.hpp"
#include "bench_files/bench_file.hpp"
#include "recording/recording.hpp"
#include "tracking/prediction.hpp"

namespace vrda::bench {

/// Collects the poses of all bodies from the frames of a recording, in order, up to a bound.
class MotionCollector {
 public:
  static constexpr std::size_t most_poses = 36'000;  ///< 10 minutes at 60 Hz; 5 MB a body

  explicit MotionCollector(const bench_files::BenchFile& bench);
  void take(const recording::RecordedFrame& frame);
  bool is_full() const;
  /// Poses with their device times mapped to the local clock. Ends the last message.
  const std::vector<tracking::TimedPose>& motion(bench_files::BodyRole role);

 private:
  void end_message(BodyTracker& tracker);

  TrackedBodies bodies_;
  std::array<std::vector<tracking::TimedPose>, bench_files::n_body_roles> motions_;
};

/// All recorded poses of a body with their device times mapped to the local clock.
std::vector<tracking::TimedPose> recorded_motion(const recording::Recording& recording,
                                                 const bench_files::BenchFile& bench,
                                                 bench_files::BodyRole role);

struct BodyPrediction {
  bench_files::BodyRole role = bench_files::BodyRole::leg;
  double horizon_ms = 0.0;
  tracking::PosePredictionError error;
};

/// Prediction errors of every body, 16, 33 and 50 ms ahead.
std::vector<BodyPrediction> predictions_of(MotionCollector& collector);
std::vector<BodyPrediction> recorded_predictions(const recording::Recording& recording,
                                                 const bench_files::BenchFile& bench);

/// One line each: error of the held and of the predicted pose.
std::string prediction_text(const std::vector<BodyPrediction>& predictions);

}  // namespace vrda::bench
