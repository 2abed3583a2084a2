#include "calibration/eyes_fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "bench/rigid_body.hpp"
#include "calibration/least_squares.hpp"
#include "core/units.hpp"
#include "coverage.hpp"
#include "noise.hpp"
#include "player/bench/moves.hpp"
#include "support/refusal.hpp"

namespace vrda::eyes_fit_test {

using test::Coverage;
using test::input_error;
using test::Noise;

const std::string file = "calibration.toml";

view::Eye bench_eye(int window_x, double x_mm)
{
  view::Eye eye;
  eye.window = {window_x, 0, 640, 480};
  eye.visible = {window_x + 18, 14, 600, 450};
  eye.distance_px = 880.0;
  eye.sight_px = {window_x + 318.0, 239.0};
  eye.position_head_mm = {x_mm, 0.0, 0.0};
  eye.distortion = {0.12, 0.02, eye.sight_px, 320.0, 1.0};
  return eye;
}

calibration::EyesPrior bench_prior()
{
  calibration::EyesPrior prior;
  prior.eyes.left = bench_eye(0, -32.0);
  prior.eyes.right = bench_eye(640, 32.0);
  Eigen::Matrix2d eyepoint;  // correlation of distance (px) and depth (mm): 0.97
  eyepoint << 81.0, 70.0, 70.0, 64.0;
  prior.eyepoint_covariance.topLeftCorner<2, 2>() = eyepoint;
  prior.eyepoint_covariance.bottomRightCorner<2, 2>() = eyepoint;
  Eigen::MatrixXd optics = Eigen::MatrixXd::Zero(5, 5);
  optics.diagonal() << 4e-5, 2.5e-5, 0.8, 0.8, 2.5e-7;
  optics(0, 1) = optics(1, 0) = -2.8e-5;
  prior.distortion_covariance = {optics, optics};
  return prior;
}

/// Everything known exactly except the pose.
calibration::EyesPrior known_eyes()
{
  calibration::EyesPrior prior = bench_prior();
  prior.eyepoint_covariance.setZero();
  prior.ipd_sd_mm = prior.sight_sd_px = prior.height_difference_sd_mm = 0.0;
  prior.distortion_covariance = {};
  return prior;
}

Pose pose(const Eigen::Vector3d& shift_mm, const Eigen::Vector3d& turn_rad)
{
  Pose X = Pose::Identity();
  X.linear() = bench::rotation_of(turn_rad);
  X.translation() = shift_mm;
  return X;
}

struct Truth {
  Pose X_carrier_eyes;
  view::EyePair eyes;
};

Truth sample_truth()
{
  Truth truth;
  truth.X_carrier_eyes = pose({40, 250, 800}, {rad_from_deg(-4), rad_from_deg(7), rad_from_deg(2)});
  truth.eyes = bench_prior().eyes;
  return truth;
}

/// Numbers 6 to 24 of the estimate, after the pose.
Eigen::VectorXd numbers_of(const view::EyePair& eyes)
{
  Eigen::VectorXd numbers(19);
  const Eigen::Vector3d apart = eyes.left.position_head_mm - eyes.right.position_head_mm;
  const auto optics = [](const view::Eye& eye) {
    Eigen::VectorXd five(5);
    five << eye.distortion.k1, eye.distortion.k2, eye.distortion.centre_px, eye.distortion.pixel_aspect;
    return five;
  };
  numbers << eyes.left.distance_px, eyes.right.distance_px, -apart.x(), apart.z(), apart.y(),
      eyes.left.sight_px, eyes.right.sight_px, optics(eyes.left), optics(eyes.right);
  return numbers;
}

/// Pose error with the conventions of Estimate.
Eigen::VectorXd errors_of(const calibration::EyesFit& fit, const Truth& truth)
{
  Eigen::VectorXd errors(25);
  errors << test::place_error(fit.X_carrier_eyes, truth.X_carrier_eyes),
      numbers_of(fit.eyes) - numbers_of(truth.eyes);
  return errors;
}

/// Eyes drawn at random from `prior`.
view::EyePair drawn_eyes(const calibration::EyesPrior& prior, Noise& noise)
{
  view::EyePair eyes = prior.eyes;
  const Eigen::VectorXd eyepoint = noise.correlated(prior.eyepoint_covariance);
  eyes.left.distance_px += eyepoint[0];
  eyes.right.distance_px += eyepoint[2];
  Eigen::Vector3d apart = eyes.left.position_head_mm - eyes.right.position_head_mm;
  apart += Eigen::Vector3d(prior.ipd_sd_mm * noise.normal(), prior.height_difference_sd_mm * noise.normal(),
                           eyepoint[1] - eyepoint[3]);
  eyes.left.position_head_mm = 0.5 * apart;
  eyes.right.position_head_mm = -0.5 * apart;
  for (std::size_t i = 0; i < 2; ++i) {
    view::Eye& eye = i == 0 ? eyes.left : eyes.right;
    eye.sight_px += prior.sight_sd_px * Eigen::Vector2d(noise.normals(2));
    const Eigen::VectorXd optics = noise.correlated(prior.distortion_covariance[i]);
    eye.distortion.k1 += optics[0];
    eye.distortion.k2 += optics[1];
    eye.distortion.centre_px += optics.segment<2>(2);
    eye.pixel_aspect = eye.distortion.pixel_aspect += optics[4];
  }
  return eyes;
}

struct MarkNoise {
  double alignment_px = 0.0, tracker_mm = 0.0;
};

/// Nine positions for each eye, 600 to 1000 mm away.
std::vector<calibration::BullseyeMark> marks_of(const Truth& truth, const MarkNoise& of, Noise& noise)
{
  std::vector<calibration::BullseyeMark> marks;
  for (const bool is_right : {false, true}) {
    const view::Eye& eye = is_right ? truth.eyes.right : truth.eyes.left;
    for (int place = 0; place < 9; ++place) {
      const double depth_mm = 600.0 + 200.0 * (place % 3);
      const double across = 0.2 * (place / 3 - 1), up = 0.12 * ((place + place / 3) % 3 - 1);
      const Eigen::Vector3d p_head_mm = depth_mm * Eigen::Vector3d(across, up, -1.0);
      calibration::BullseyeMark mark;
      mark.is_right = is_right;
      mark.p_carrier_mm =
          truth.X_carrier_eyes * p_head_mm + of.tracker_mm * Eigen::Vector3d(noise.normals(3));
      mark.p_sd_mm = of.tracker_mm;
      mark.drawn_px = view::drawn_px(eye, p_head_mm) + of.alignment_px * Eigen::Vector2d(noise.normals(2));
      marks.push_back(mark);
    }
  }
  return marks;
}

calibration::EyesFit fitted(const std::vector<calibration::BullseyeMark>& marks,
                            const calibration::EyesPrior& prior = bench_prior(),
                            const Pose& X_start = pose({0, 200, 800}, {0, 0, 0}))
{
  return calibration::fit_eyes(marks, prior, X_start, "eyes", file);
}

TEST(EyesFits, MarksWithoutNoiseGiveTheEyesBack)
{
  Noise noise(1);
  for (const calibration::EyesPrior& prior : {known_eyes(), bench_prior()}) {
    const Truth truth = sample_truth();
    const calibration::EyesFit fit = fitted(marks_of(truth, {}, noise), prior);
    EXPECT_LT(errors_of(fit, truth).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT(fit.noise_px, 1e-3);
  }
}

TEST(EyesFits, TheValuesAreInTheOrderOfTheHeader)
{
  Noise noise(2);
  Truth truth = sample_truth();
  truth.eyes = drawn_eyes(bench_prior(), noise);
  const calibration::EyesFit fit = fitted(marks_of(truth, {0.5, 0.1}, noise));
  const std::vector<std::string> expected = {"eyes.shift_x",      "eyes.shift_y",      "eyes.shift_z",
                                             "eyes.turn_x",       "eyes.turn_y",       "eyes.turn_z",
                                             "left.distance",     "right.distance",    "ipd",
                                             "depth_apart",       "height_apart",      "left.sight_x",
                                             "left.sight_y",      "right.sight_x",     "right.sight_y",
                                             "left.k1",           "left.k2",           "left.centre_x",
                                             "left.centre_y",     "left.pixel_aspect", "right.k1",
                                             "right.k2",          "right.centre_x",    "right.centre_y",
                                             "right.pixel_aspect"};
  EXPECT_EQ(fit.estimate.names, expected);
  ASSERT_EQ(fit.estimate.units.size(), 25U);
  EXPECT_EQ(fit.estimate.units[3], "deg");
  EXPECT_EQ(fit.estimate.units[9], "mm");
  EXPECT_EQ(fit.estimate.values.tail(19), numbers_of(fit.eyes));
  EXPECT_EQ(fit.eyes.left.pixel_aspect, fit.eyes.left.distortion.pixel_aspect);
  EXPECT_EQ(fit.estimate.values.head<3>(), fit.X_carrier_eyes.translation());
  EXPECT_EQ(fit.estimate.residuals.size(), 18U);
  EXPECT_EQ(fit.estimate.residual_unit, "px");
  EXPECT_EQ(fit.estimate.covariance.rows(), 25);
}

TEST(EyesFits, WhatIsKnownExactlyStays)
{
  Noise noise(3);
  const calibration::EyesFit fit = fitted(marks_of(sample_truth(), {0.5, 0.1}, noise), known_eyes());
  EXPECT_EQ(numbers_of(fit.eyes), numbers_of(known_eyes().eyes));
  EXPECT_EQ(fit.estimate.covariance.bottomRightCorner(19, 19), Eigen::MatrixXd::Zero(19, 19));
  EXPECT_GT(fit.estimate.covariance(0, 0), 0.0);
}

TEST(EyesFits, MovingTheCarriersFrameMovesTheAnswer)
{
  Noise noise(4);
  const Pose X_other_carrier = pose({-300, 1200, 45}, {1.1, -0.7, 2.0});
  Truth truth = sample_truth();
  truth.eyes = drawn_eyes(bench_prior(), noise);
  std::vector<calibration::BullseyeMark> marks = marks_of(truth, {0.5, 0.1}, noise);
  const Pose X_start = pose({0, 200, 800}, {0, 0, 0});
  const calibration::EyesFit here = fitted(marks, bench_prior(), X_start);
  for (calibration::BullseyeMark& mark : marks) mark.p_carrier_mm = X_other_carrier * mark.p_carrier_mm;
  const calibration::EyesFit there = fitted(marks, bench_prior(), X_other_carrier * X_start);
  constexpr double solver_tolerance = 1e-5;  // 1e-6 of a standard deviation of up to 9 px
  EXPECT_LT(test::place_error(there.X_carrier_eyes, X_other_carrier * here.X_carrier_eyes).norm(),
            solver_tolerance);
  EXPECT_LT((numbers_of(there.eyes) - numbers_of(here.eyes)).cwiseAbs().maxCoeff(), solver_tolerance);
  // The covariance rotates with the frame.
  const Eigen::Matrix3d R = X_other_carrier.linear();
  const Eigen::MatrixXd expected = calibration::propagated(R, here.estimate.covariance.block(3, 3, 3, 3));
  const Eigen::MatrixXd found = there.estimate.covariance.block(3, 3, 3, 3);
  EXPECT_LT((found - expected).norm(), 1e-4 * expected.norm());
}

TEST(EyesFits, AnyStartWithinHalfAMetreAndTwentyDegreesLeadsThere)
{
  Noise noise(5);
  Truth truth = sample_truth();
  truth.eyes = drawn_eyes(bench_prior(), noise);
  const std::vector<calibration::BullseyeMark> marks = marks_of(truth, {0.5, 0.1}, noise);
  const calibration::EyesFit expected = fitted(marks, bench_prior(), truth.X_carrier_eyes);
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d shift = Eigen::Vector3d(noise.normals(3)).normalized() * 500.0;
    const Eigen::Vector3d turn = Eigen::Vector3d(noise.normals(3)).normalized() * rad_from_deg(20.0);
    Pose X_start = truth.X_carrier_eyes;
    X_start.linear() *= bench::rotation_of(turn);
    X_start.translation() += shift;
    const calibration::EyesFit fit = fitted(marks, bench_prior(), X_start);
    constexpr double solver_tolerance = 1e-4;  // the noise iterations depend on the start
    EXPECT_LT(test::place_error(fit.X_carrier_eyes, expected.X_carrier_eyes).norm(), solver_tolerance);
    EXPECT_NEAR(fit.noise_px, expected.noise_px, 0.01);
  }
}

struct Setting {
  const char* name;
  MarkNoise noise;
};

/// The truth is drawn from the prior, so each interval must contain it in 95 % of cases (1500 seeds: 94 to 97
/// %). Numbers of the left and the right eye are pooled.
TEST(EyesFits, IntervalsAreHonest)
{
  for (const Setting& setting : {Setting{"the hand's noise", {0.5, 0.1}}, {"the tracker's", {0.3, 1.0}}}) {
    SCOPED_TRACE(setting.name);
    Coverage coverage;
    constexpr std::uint64_t n_sets = 200;
    double noise_sum_px = 0.0;
    for (std::uint64_t seed = 1; seed <= n_sets; ++seed) {
      Noise noise(seed);
      Truth truth = sample_truth();
      truth.eyes = drawn_eyes(bench_prior(), noise);
      const calibration::EyesFit fit = fitted(marks_of(truth, setting.noise, noise));
      coverage.add(fit.estimate, errors_of(fit, truth));
      noise_sum_px += fit.noise_px;
    }
    coverage.expect_honest();
    // With dominant tracker noise some estimates of the alignment noise are zero, which lowers the mean.
    EXPECT_NEAR(noise_sum_px / n_sets, setting.noise.alignment_px, 0.1);
  }
}

TEST(EyesFits, MarksOfThePositionReduceThePriorUncertainty)
{
  Noise noise(6);
  const calibration::EyesPrior prior = bench_prior();
  const calibration::EyesFit fit = fitted(marks_of(sample_truth(), {0.5, 0.1}, noise));
  EXPECT_LT(fit.estimate.covariance(6, 6), prior.eyepoint_covariance(0, 0));
  EXPECT_LT(fit.estimate.covariance(8, 8), prior.ipd_sd_mm * prior.ipd_sd_mm);
  EXPECT_LT(fit.estimate.covariance(11, 11), prior.sight_sd_px * prior.sight_sd_px);
  EXPECT_LT(fit.estimate.covariance(15, 15), prior.distortion_covariance[0](0, 0));
}

TEST(EyesFits, TooFewBullseyesOfAnEyeAreRefused)
{
  Noise noise(7);
  std::vector<calibration::BullseyeMark> marks = marks_of(sample_truth(), {0.5, 0.1}, noise);
  marks.resize(9 + 5);
  EXPECT_THAT(input_error([&] { fitted(marks); }), test::refuses({file, "eyes: right eye", "5"}));
}

TEST(EyesFits, PositionsThatDoNotDetermineTheEyesAreRefusedWithThoseToAdd)
{
  Noise noise(8);
  const std::vector<calibration::BullseyeMark> marks = marks_of(sample_truth(), {0.5, 0.1}, noise);
  const Pose X = sample_truth().X_carrier_eyes;
  const auto refused = [&](const Eigen::Vector3d& kept) {
    std::vector<calibration::BullseyeMark> some = marks;
    for (calibration::BullseyeMark& mark : some) {
      Eigen::Vector3d p =
          X.linear().transpose() * (mark.p_carrier_mm - X.translation()) - Eigen::Vector3d(0, 0, -800);
      p = kept.cwiseProduct(p) + Eigen::Vector3d(0, 0, -800);
      mark.p_carrier_mm = X * p;
    }
    return input_error([&] { fitted(some, bench_prior(), X); });
  };
  EXPECT_THAT(refused({1, 1, 0.1}),
              test::refuses({.field = "eyes: marker positions", .found = {"depth", "40"}}));
  EXPECT_THAT(refused({0.1, 0.1, 1}),
              test::refuses({.field = "eyes: marker positions", .found = "straight"}));
  EXPECT_EQ(refused({0.1, 0.1, 1}).field, "eyes: marker positions");
  std::vector<calibration::BullseyeMark> line = marks;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double way = static_cast<double>(i) - 8.5;
    line[i].p_carrier_mm = X * Eigen::Vector3d(10 * way, 3 * way, -800 + 15 * way);
  }
  EXPECT_THAT(input_error([&] { fitted(line, bench_prior(), X); }),
              test::refuses({.field = "eyes: marker positions", .found = "line"}));
}

TEST(EyesFits, ABullseyeThatWasAlignedWronglyIsNamed)
{
  for (std::size_t i = 0; i < 18; ++i) {
    Noise noise(i + 20);
    Truth truth = sample_truth();
    truth.eyes = drawn_eyes(bench_prior(), noise);
    std::vector<calibration::BullseyeMark> marks = marks_of(truth, {0.5, 0.1}, noise);
    marks[i].drawn_px += Eigen::Vector2d(20.0, -15.0);
    EXPECT_THAT(input_error([&] { fitted(marks); }),
                test::refuses({.field = "eyes: bull's-eye " + std::to_string(i % 9 + 1) + " of the " +
                                        (i < 9 ? "left" : "right") + " eye",
                               .found = "px"}));
  }
}

TEST(EyesFits, MarksThatNoEyesCanHaveMadeEndInAMessage)
{
  Noise noise(9);
  std::vector<calibration::BullseyeMark> marks = marks_of(sample_truth(), {0.5, 0.1}, noise);
  marks[4].drawn_px.setConstant(std::nan(""));
  EXPECT_THAT(input_error([&] { fitted(marks); }),
              test::refuses({.field = "eyes", .found = "iteration limit"}));
}

view::EyePair some_eyes()
{
  view::EyePair eyes;
  for (view::Eye* eye : {&eyes.left, &eyes.right}) {
    eye->sight_px = eye->distortion.centre_px = {320.0, 240.0};
    eye->distance_px = 870.0;
    eye->pixel_aspect = eye->distortion.pixel_aspect = 1.02;
    eye->distortion.k1 = 0.1;
  }
  view::set_ipd(eyes, 64.0);
  return eyes;
}

TEST(EyesStart, FindsEyesInAnyAttitudeNearEnoughForTheFit)
{
  // The fit needs a start within 20 degrees and 0.5 m; axis errors of 3 px and noise of 0.5 px rotate the
  // result by less than a degree and shift it by some centimetres.
  constexpr double most_deg = 5.0, most_mm = 60.0;
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> part(-1.0, 1.0);
  std::normal_distribution<double> noise;
  for (int trial = 0; trial < 60; ++trial) {
    const view::EyePair eyes = some_eyes();
    view::EyePair true_eyes = eyes;
    for (view::Eye* eye : {&true_eyes.left, &true_eyes.right})
      eye->sight_px += 3.0 * Eigen::Vector2d(noise(random), noise(random));
    const Pose X_carrier_eyes = test::random_pose(random);
    std::vector<calibration::BullseyeMark> marks;
    for (int k = 0; k < 9; ++k) {
      const double z_mm = -750.0 + 250.0 * part(random);
      const Eigen::Vector3d p_eyes_mm(-0.25 * z_mm * part(random), -0.2 * z_mm * part(random), z_mm);
      for (const bool is_right : {false, true}) {
        const view::Eye& eye = is_right ? true_eyes.right : true_eyes.left;
        calibration::BullseyeMark mark;
        mark.is_right = is_right;
        mark.p_carrier_mm = X_carrier_eyes * p_eyes_mm;
        mark.drawn_px = view::drawn_px(eye, p_eyes_mm) + 0.5 * Eigen::Vector2d(noise(random), noise(random));
        marks.push_back(mark);
      }
    }
    const Pose found = calibration::initial_eye_pose(marks, eyes);
    const Eigen::VectorXd apart = test::place_error(found, X_carrier_eyes);
    EXPECT_LT(apart.head<3>().norm(), most_mm);
    EXPECT_LT(apart.tail<3>().norm(), most_deg);
  }
}

TEST(EyesStart, OfTwoMarksIsNowhere)
{
  const Pose X = calibration::initial_eye_pose(std::vector<calibration::BullseyeMark>(2), some_eyes());
  EXPECT_EQ(X.matrix(), Pose::Identity().matrix());
}

}  // namespace vrda::eyes_fit_test
