#include "analysis/sequence_program.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "analysis/repair.hpp"
#include "analysis/scenes.hpp"
#include "core/units.hpp"
#include "support/meshes.hpp"

namespace vrda::analysis::repair_smoothness_test {

// Some hundred operations on numbers near 1; weights near 1 keep the condition below 100.
constexpr double rounding = 1e-11;

Eigen::MatrixXd second_difference_matrix(Eigen::Index n)
{
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(n - 2, n);
  for (Eigen::Index k = 0; k + 2 < n; ++k) D.row(k).segment<3>(k) << 1, -2, 1;
  return D;
}

// A ball far below a plate: nothing limits it.
RepairedMotion smoothed(const MeasuredMotion& motion, double mm, double period_frames)
{
  RepairOptions options;
  options.noise = test::isotropic_noise(mm, 1.0);
  options.gap_limit = GapLimit::none;
  options.smoothing = period_frames > 0 ? Smoothing::of_period : Smoothing::from_noise;
  options.period_frames = period_frames;
  return repair(make_audit_scene(test::box({0, 60, 0}, {60, 10, 60}), test::ball(10), {}), motion, options);
}

TEST(Smoothness, TranslationsAreSmoothedByTheKnownMatrix)
{
  // (I + w D^T D)^-1: white noise of n frames keeps the share trace((I + w D^T D)^-2) / n of its variance.
  constexpr std::size_t n = 40;
  constexpr double period = 9.0;
  std::mt19937_64 generator(4);
  MeasuredMotion motion = test::resting_motion(n, {0, 0, 0});
  Eigen::MatrixXd measured(n, 3);
  for (std::size_t k = 0; k < n; ++k) {
    for (Eigen::Index c = 0; c < 3; ++c)
      measured(static_cast<Eigen::Index>(k), c) = 0.3 * test::normal_number(generator);
    motion.X_reference_moving[k].translation() = measured.row(static_cast<Eigen::Index>(k)).transpose();
  }
  const Eigen::MatrixXd D = second_difference_matrix(n);
  const double weight = weight_of_period(period);
  const Eigen::MatrixXd smoother = (Eigen::MatrixXd::Identity(n, n) + weight * D.transpose() * D).inverse();
  const Eigen::MatrixXd expected = smoother * measured;
  const RepairedMotion found = smoothed(motion, 0.3, period);
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Vector3d error = found.frames[k].X_reference_moving.translation() -
                                  expected.row(static_cast<Eigen::Index>(k)).transpose();
    EXPECT_LT(error.norm(), 1e-6) << k;  // steps end below 1e-3 standard deviations, here after the second
  }
  // 120 numbers: the share is known within 4 standard errors, sqrt(2 / 120) each of the smoothed third.
  const double share = (smoother * smoother).trace() / n;
  EXPECT_NEAR(expected.squaredNorm() / measured.squaredNorm(), share, 0.5 * share);
}

TEST(Smoothness, AnOscillationOfTheStatedPeriodKeepsHalfItsAmplitude)
{
  constexpr std::size_t n = 120;
  constexpr double period = 12.0;
  MeasuredMotion motion = test::resting_motion(n, {0, 0, 0});
  for (std::size_t k = 0; k < n; ++k) {
    const double wave = std::sin(2 * pi * static_cast<double>(k) / period);
    motion.X_reference_moving[k].translation().x() = wave;
    motion.X_reference_moving[k].linear() = rotation_z(0.02 * wave);
  }
  const RepairedMotion found = smoothed(motion, 1.0, period);
  // The ends change the amplitude over about a period.
  for (std::size_t k = 36; k < 84; ++k) {
    const Pose& X = found.frames[k].X_reference_moving;
    EXPECT_NEAR(X.translation().x(), 0.5 * motion.X_reference_moving[k].translation().x(), 1e-3) << k;
    EXPECT_NEAR(X.linear()(1, 0), 0.5 * motion.X_reference_moving[k].linear()(1, 0), 2e-5) << k;
  }
  EXPECT_NEAR(period_of_weight(weight_of_period(period)), period, rounding);
  EXPECT_EQ(period_of_weight(0.0), 2.0);
}

TEST(Smoothness, AScrewMotionOfConstantSpeedStaysAsItIs)
{
  MeasuredMotion motion = test::resting_motion(30, {0, 0, 0});
  for (std::size_t k = 0; k < 30; ++k) {
    motion.key[k] = k < 10 ? 0.5 * static_cast<double>(k) : static_cast<double>(k) - 5.0;
    motion.X_reference_moving[k].linear() = rotation_z(0.03 * motion.key[k]);
    motion.X_reference_moving[k].translation() << 0.2 * motion.key[k], 0, -0.1 * motion.key[k];
  }
  for (const RepairedFrame& frame : smoothed(motion, 1.0, 20.0).frames)
    EXPECT_LT(frame.displacement.norm(), 1e-8);
}

TEST(Smoothness, TheNoiseChoosesAWeightThatBringsTheMotionNearerToTheTruth)
{
  constexpr std::size_t n = 80;
  constexpr double noise_mm = 0.3;
  std::mt19937_64 generator(8);
  const MeasurementNoise noise = test::isotropic_noise(noise_mm, 0.5);
  std::vector<Pose> X_true;
  MeasuredMotion motion = test::resting_motion(n, {0, 0, 0});
  for (std::size_t k = 0; k < n; ++k) {
    const double wave = std::sin(2 * pi * static_cast<double>(k) / 40.0);
    Pose X = Pose::Identity();
    X.linear() = rotation_z(0.3 * wave) * rotation_x(0.05 * wave);
    X.translation() << 5 * wave, 0, 2;
    X_true.push_back(X);
  }
  motion.X_reference_moving = test::with_noise(X_true, noise, generator);
  RepairOptions options;
  options.noise = noise;
  options.gap_limit = GapLimit::none;
  const RepairedMotion found =
      repair(make_audit_scene(test::box({0, 60, 0}, {60, 10, 60}), test::ball(10), {}), motion, options);
  // A wave of 40 frames needs about 8 numbers of 80, a constant 2: below half of the noise remains.
  EXPECT_LT(test::distance_from(X_true, test::poses_of(found), noise),
            0.5 * test::distance_from(X_true, motion.X_reference_moving, noise));
  EXPECT_LT(found.period_frames(3), found.period_frames(5));  // x moves, z rests
  EXPECT_GT(found.period_frames(3), 4.0);
  EXPECT_LT(found.period_frames(3), 40.0);
}

TEST(Smoothness, DerivativesMatchDifferences)
{
  const NoiseScale scale = noise_scale({}, test::isotropic_noise(0.5, 1.0));
  std::mt19937_64 generator(9);
  const std::vector<double> key{0.0, 1.0, 1.5, 3.0};
  std::vector<Pose> X_measured;
  std::vector<Vector6d> twist;
  for (std::size_t k = 0; k < 4; ++k) {
    Pose X = Pose::Identity();
    X.linear() = rotation_z(0.05 * static_cast<double>(k)) * rotation_x(0.03 * static_cast<double>(k * k));
    X_measured.push_back(X);
    Vector6d t;
    for (Eigen::Index c = 0; c < 6; ++c) t(c) = test::normal_number(generator);
    twist.push_back(t);
  }
  const auto differences = [&](const std::vector<Vector6d>& at) {
    std::vector<Pose> X;
    for (std::size_t k = 0; k < 4; ++k) X.push_back(displaced(X_measured[k], at[k], scale));
    return second_differences(key, X, at, scale);
  };
  const std::vector<SecondDifference> found = differences(twist);
  ASSERT_EQ(found.size(), 2U);
  constexpr double step = 1e-4;
  for (std::size_t r = 0; r < 2; ++r) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (Eigen::Index c = 0; c < 6; ++c) {
        std::vector<Vector6d> low = twist, high = twist;
        low[r + i](c) -= step;
        high[r + i](c) += step;
        const Vector6d slope = (differences(high)[r].value - differences(low)[r].value) / (2 * step);
        // Angles are 0.1 rad: the expansions' errors are 0.1^3 / 24 of the turn and 0.1^4 / 720.
        EXPECT_LT((found[r].jacobian[i].col(c) - slope).cwiseAbs().maxCoeff(), 3e-4) << r << i << c;
      }
    }
  }
}

TEST(SupportedGap, NoiseIsNoSpreadAndSmoothChangeIs)
{
  std::vector<MeasuredGap> constant, noisy, smooth;
  std::mt19937_64 generator(12);
  for (int k = 0; k < 400; ++k) {
    constant.push_back({0.3, 0.1});
    noisy.push_back({0.3 + 0.1 * test::normal_number(generator), 0.1});
    smooth.push_back({0.3 + 0.1 * std::sin(2 * pi * k / 100.0), 0.5});
  }
  EXPECT_NEAR(supported_gap_mm(constant), 0.3, rounding);
  // The spread of 400 numbers is known within 5 %, its noise likewise: 2 sqrt(0.1^2 0.2) remains at most.
  EXPECT_NEAR(supported_gap_mm(noisy), 0.3, 0.1);
  // Median absolute deviation of a sine: sin(45 degrees).
  EXPECT_NEAR(supported_gap_mm(smooth), 0.3 + 2 * 1.4826 * 0.1 * std::sqrt(0.5), 0.01);
  EXPECT_TRUE(std::isinf(supported_gap_mm({})));
  EXPECT_EQ(supported_gap_mm({{-2.0, 0.1}, {-2.0, 0.1}}), 0.0);
}

}  // namespace vrda::analysis::repair_smoothness_test
