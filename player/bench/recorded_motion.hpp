/// Motion of the tracked bodies in a recording, and the prediction error.
#pragma once

#include <string>
#include <vector>

#include "recording/recording.hpp"
#include "setup/bench_file.hpp"
#include "tracking/prediction.hpp"

namespace vrda {

/// All recorded poses of a body with their device times mapped to the local clock.
std::vector<TimedPose> recorded_motion(const Recording& recording, const BenchFile& bench, BodyRole role);

struct BodyPrediction {
  BodyRole role = BodyRole::leg;
  double horizon_ms = 0.0;
  PlacePredictionError error;
};

/// Prediction errors of every body, 16, 33 and 50 ms ahead.
std::vector<BodyPrediction> recorded_predictions(const Recording& recording, const BenchFile& bench);

/// One line each: error of the held and of the predicted pose.
std::string prediction_text(const std::vector<BodyPrediction>& predictions);

}  // namespace vrda
