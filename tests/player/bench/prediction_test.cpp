#include "bench/motion_filter.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"
#include "player/bench/moves.hpp"
#include "support/allocation_count.hpp"

namespace vrda::prediction_test {

TEST(PlacePredictor, ConstantTwistIsPredictedExactly)
{
  std::mt19937_64 random(61);
  for (int i = 0; i < 100; ++i) {
    const bench::Screw twist{test::random_vector(random, 3.0), test::random_vector(random, 600.0)};
    const Pose X_start = test::random_pose(random);
    bench::PosePredictor predictor;
    std::uniform_real_distribution<double> step(0.005, 0.015);
    double time_s = 100.0;
    for (int k = 0; k < 12; ++k) {
      time_s += step(random);
      predictor.add({time_s, X_start * bench::pose_of(bench::scaled(twist, time_s - 100.0))});
    }
    const Pose then = X_start * bench::pose_of(bench::scaled(twist, time_s + 0.06 - 100.0));
    EXPECT_LT(test::distance_mm(predictor.at(time_s + 0.06), then), 1e-8);
    EXPECT_LT(test::turn_between_rad(predictor.at(time_s + 0.06), then), 1e-10);
    EXPECT_LT((predictor.velocity().turn_rad - twist.turn_rad).norm(), 1e-9);
    EXPECT_LT((predictor.velocity().shift_mm - twist.shift_mm).norm(), 1e-7);
  }
}

TEST(PlacePredictor, HoldsWhatItCannotCarryOn)
{
  bench::PosePredictor predictor;
  EXPECT_FALSE(predictor.has_sample());
  const auto at_x = [](double x_mm) { return Pose(Eigen::Translation3d(x_mm, 0, 0)); };
  predictor.add({1.0, at_x(5)});
  EXPECT_EQ(predictor.at(1.05).translation().x(), 5.0);
  predictor.add({1.01, at_x(6)});
  EXPECT_NEAR(predictor.at(1.03).translation().x(), 8.0, 1e-9);
  EXPECT_EQ(predictor.at(0.5).translation().x(), 6.0);
  // At most 0.1 s ahead.
  EXPECT_NEAR(predictor.at(7.0).translation().x(), 16.0, 1e-9);
  // Samples before a gap longer than the window are ignored.
  predictor.add({2.0, at_x(100)});
  EXPECT_EQ(predictor.at(2.05).translation().x(), 100.0);
  // Samples too close together would amplify their noise.
  predictor.start_over();
  predictor.add({3.0, at_x(1)});
  predictor.add({3.0001, at_x(2)});
  EXPECT_EQ(predictor.at(3.05).translation().x(), 2.0);
  // A clock that steps back restarts the predictor, as does a repeated time.
  predictor.add({0.2, at_x(7)});
  EXPECT_EQ(predictor.at(0.25).translation().x(), 7.0);
  predictor.start_over();
  EXPECT_FALSE(predictor.has_sample());
}

TEST(PlacePredictor, AWindowTooSmallForTheRateKeepsTheNewest)
{
  bench::PosePredictor predictor({.window_s = 10.0});
  for (int i = 0; i <= 200; ++i) {
    // Reverses long before the last 32 samples.
    const double x_mm = i < 100 ? -i : i - 200.0;
    predictor.add({0.01 * i, Pose(Eigen::Translation3d(x_mm, 0, 0))});
  }
  EXPECT_NEAR(predictor.velocity().shift_mm.x(), 100.0, 1e-9);
}

TEST(PlacePredictor, NoiseOfTheVelocityIsThatOfALeastSquaresSlope)
{
  // n samples d apart: variance noise^2 12 / (d^2 n (n^2 - 1)). m trials: the mean square spreads by
  // sqrt(2 / m); five of that.
  constexpr int m = 4000, n = 9;
  constexpr double noise = 0.1, step_s = 0.01;
  std::mt19937_64 random(62);
  double square = 0.0;
  for (int i = 0; i < m; ++i) {
    bench::PosePredictor predictor({.window_s = 0.0801});
    for (int k = 0; k < n; ++k) {
      predictor.add({k * step_s, Pose(Eigen::Translation3d(test::noise_of(random, noise)))});
    }
    square += std::pow(predictor.velocity().shift_mm.y(), 2) / m;
  }
  const double expected = noise * noise * 12.0 / (step_s * step_s * n * (n * n - 1.0));
  EXPECT_NEAR(square / expected, 1.0, 5.0 * std::sqrt(2.0 / m));
}

TEST(AnglesPredictor, StraightLinesArePredictedExactly)
{
  bench::AnglesPredictor predictor;
  EXPECT_FALSE(predictor.has_sample());
  for (int i = 0; i < 20; ++i) predictor.add({0.01 * i, {0.1 + 0.8 * 0.01 * i, -0.05 * 0.01 * i, 0.3}});
  const bench::LegAngles then = predictor.at(0.25);
  EXPECT_NEAR(then.flexion_rad, 0.3, 1e-13);
  EXPECT_NEAR(then.varus_rad, -0.0125, 1e-13);
  EXPECT_NEAR(then.theta_rad, 0.3, 1e-13);
  EXPECT_NEAR(predictor.velocity().flexion_rad, 0.8, 1e-12);
  predictor.add({0.0, {1, 1, 1}});
  EXPECT_EQ(predictor.at(0.05).flexion_rad, 1.0);
  predictor.add({0.001, {2, 2, 2}});
  EXPECT_EQ(predictor.at(0.05).flexion_rad, 2.0);
  predictor.start_over();
  EXPECT_FALSE(predictor.has_sample());
}

TEST(ErrorSummary, IsThePlainDefinition)
{
  std::vector<double> errors;
  for (int i = 100; i >= 1; --i) errors.push_back(i);
  const bench::ErrorSummary summary = bench::summary_of(errors);
  EXPECT_EQ(summary.n, 100U);
  EXPECT_EQ(summary.percentile_95, 95.0);
  EXPECT_NEAR(summary.rms, std::sqrt(3383.5), 1e-12);  // mean of i^2: 101 * 201 / 6
  EXPECT_EQ(bench::summary_of({3.0}).percentile_95, 3.0);
  EXPECT_EQ(bench::summary_of({}).n, 0U);
}

TEST(PredictionError, OfASteadyMotionIsSpeedTimesHorizonHeldAndNothingPredicted)
{
  std::vector<bench::TimedPose> series;
  for (int i = 0; i <= 200; ++i) {
    const double time_s = 0.01 * i;
    series.push_back({time_s, Pose(Eigen::Translation3d(300.0 * time_s, 0, 0))});
  }
  const double horizon_s = 0.035;
  const bench::PosePredictionError place = bench::prediction_error(series, horizon_s);
  // Up to 2.0 s minus the horizon: 0 to 1.96 s.
  EXPECT_EQ(place.shift_mm.held.n, 197U);
  EXPECT_NEAR(place.shift_mm.held.rms, 300.0 * horizon_s, 1e-9);
  EXPECT_NEAR(place.turn_rad.held.rms, 0.0, 1e-12);
  // The first sample has no predecessor and is held: one in 197.
  EXPECT_NEAR(place.shift_mm.predicted.rms, 300.0 * horizon_s / std::sqrt(197.0), 1e-9);
  EXPECT_NEAR(place.shift_mm.predicted.percentile_95, 0.0, 1e-9);
}

TEST(PredictionError, OfASwingIsThatOfItsAcceleration)
{
  // x = a sin(w t). With a horizon h the held value is off by a w h at most; the predicted one by the
  // acceleration: the slope over a window T belongs to its centre, T / 2 earlier, so a w^2 h (h + T) / 2 at
  // most; the RMS of both is smaller by sqrt(2). The next term is w T = 0.13 of that.
  const double a_mm = 150.0, w = 1.6, h = 0.033, T = 0.08;
  std::vector<bench::TimedPose> series;
  for (int i = 0; i <= 4000; ++i) {
    series.push_back({0.01 * i, Pose(Eigen::Translation3d(a_mm * sine(w * 0.01 * i), 0, 0))});
  }
  const bench::PredictionError error = bench::prediction_error(series, h, {.window_s = T + 1e-6}).shift_mm;
  EXPECT_NEAR(error.held.rms / (a_mm * w * h / std::sqrt(2.0)), 1.0, 0.02);
  EXPECT_NEAR(error.predicted.rms / (a_mm * w * w * h * (h + T) / 2.0 / std::sqrt(2.0)), 1.0, 0.13);
}

}  // namespace vrda::prediction_test
