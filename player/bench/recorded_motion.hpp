/// How the tracked bodies moved in a recording, and how well their motion could have been predicted.
#pragma once

#include <string>
#include <vector>

#include "recording/recording.hpp"
#include "setup/bench_file.hpp"
#include "tracking/prediction.hpp"

namespace vrda {

/// Every pose of one body of the bench that was recorded, at its device's time.
std::vector<TimedPose> recorded_motion(const Recording& recording, const BenchFile& bench, BodyRole role);

struct BodyPrediction {
  BodyRole role = BodyRole::leg;
  double horizon_ms = 0.0;
  PlacePredictionError error;
};

/// Of every body, 16, 33 and 50 ms ahead.
std::vector<BodyPrediction> recorded_predictions(const Recording& recording, const BenchFile& bench);

/// A line each: how far off the pose is that is held, and the predicted one.
std::string prediction_text(const std::vector<BodyPrediction>& predictions);

}  // namespace vrda
