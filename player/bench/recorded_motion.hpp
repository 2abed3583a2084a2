/// Motion of the tracked bodies in a recording, and the error that prediction would have had on it. Poses
/// take points of the tool to the tracker's frame, mm; times are ns of the local clock. An unseen body gives
/// an empty list.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "bench/body_tracker.hpp"
#include "bench/bench_file.hpp"
#include "bench/recording.hpp"
#include "bench/prediction.hpp"

namespace vrda::bench {

/// Collects the poses of all bodies from the frames of a recording, in order, up to a bound.
class MotionCollector {
 public:
  static constexpr std::size_t most_poses = 36'000;  ///< 10 minutes at 60 Hz; 5 MB a body

  explicit MotionCollector(const bench::BenchFile& bench);
  void take(const bench::RecordedFrame& frame);
  bool is_full() const;
  /// Poses with their device times mapped to the local clock. Ends the last message.
  const std::vector<bench::TimedPose>& motion(bench::BodyRole role);

 private:
  void end_message(BodyTracker& tracker);

  TrackedBodies bodies_;
  std::array<std::vector<bench::TimedPose>, bench::n_body_roles> motions_;
};

/// All recorded poses of a body with their device times mapped to the local clock.
std::vector<bench::TimedPose> recorded_motion(const bench::Recording& recording,
                                                 const bench::BenchFile& bench,
                                                 bench::BodyRole role);

struct BodyPrediction {
  bench::BodyRole role = bench::BodyRole::leg;
  double horizon_ms = 0.0;
  bench::PosePredictionError error;
};

/// Prediction errors of every body, 16, 33 and 50 ms ahead.
std::vector<BodyPrediction> predictions_of(MotionCollector& collector);
std::vector<BodyPrediction> recorded_predictions(const bench::Recording& recording,
                                                 const bench::BenchFile& bench);

/// One line each: error of the held and of the predicted pose.
std::string prediction_text(const std::vector<BodyPrediction>& predictions);

}  // namespace vrda::bench
