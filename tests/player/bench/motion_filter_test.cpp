#include <gtest/gtest.h>

#include "bench/body_tracker.hpp"
#include "core/units.hpp"
#include "player/bench/moves.hpp"
#include "support/allocation_count.hpp"

namespace vrda::motion_filter_test {

/// Of the header: 1 / (2 pi cutoff(speed)).
double delay_s(const bench::OneEuroOptions& options, double speed)
{
  return 1.0 / (2.0 * pi * (options.least_cutoff_hz + options.hz_by_speed * speed));
}

TEST(OneEuro, LagsARampByTheStatedDelayAtAnyRate)
{
  // 30 s are 180 times the slowest time constant, 1 / (2 pi 1 Hz) = 0.16 s.
  const bench::OneEuroOptions options{1.0, 5.0, 1.0};
  for (const double rate_hz : {30.0, 100.0, 1000.0}) {
    for (const double speed : {0.0, 0.2, -0.2, 1.5}) {
      SCOPED_TRACE(speed);
      bench::OneEuroFilter filter(options);
      double value = 0.0, time_s = 0.0;
      for (int i = 0; i <= 30 * static_cast<int>(rate_hz); ++i) {
        time_s = i / rate_hz;
        value = filter.filtered(0.7 + speed * time_s, time_s);
      }
      const double lag = 0.7 + speed * time_s - value;
      EXPECT_NEAR(lag, speed * delay_s(options, std::abs(speed)), 1e-9);
    }
  }
}

TEST(OneEuro, AtRestNoiseFallsByTheFirstOrderFilter)
{
  // Without gain the variance of white noise falls to a / (2 - a). The mean square of n values that are
  // correlated over 1 / a steps spreads relatively by sqrt(2 / (a n)); five of that.
  const bench::OneEuroOptions options{1.5, 0.0, 1.0};
  const double step_s = 0.01, a = 1.0 / (1.0 + 1.0 / (2.0 * pi * 1.5 * step_s));
  std::mt19937_64 random(51);
  bench::OneEuroFilter filter(options);
  constexpr int n = 200000;
  double square = 0.0;
  for (int i = 0; i < n; ++i) {
    const double value = filter.filtered(test::noise_of(random, 1.0).x(), i * step_s);
    square += i < 1000 ? 0.0 : value * value / (n - 1000);
  }
  EXPECT_NEAR(square / (a / (2.0 - a)), 1.0, 5.0 * std::sqrt(2.0 / (a * n)));
}

TEST(OneEuro, TimesThatDoNotAscend)
{
  bench::OneEuroFilter filter({1.0, 0.0, 1.0});
  EXPECT_EQ(filter.filtered(1.0, 10.0), 1.0);
  const double second = filter.filtered(2.0, 10.1);
  EXPECT_GT(second, 1.0);
  EXPECT_LT(second, 2.0);
  EXPECT_EQ(filter.filtered(50.0, 10.1), second);
  EXPECT_EQ(filter.filtered(3.0, 4.0), 3.0);
  filter.start_over();
  EXPECT_EQ(filter.filtered(7.0, 4.0), 7.0);
}

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

}  // namespace vrda::motion_filter_test
