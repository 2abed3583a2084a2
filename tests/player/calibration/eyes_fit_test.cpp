#include "calibration/eyes_fit.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calibration/least_squares.hpp"
#include "core/units.hpp"
#include "player/bench/moves.hpp"
#include "player/calibration/fit_support.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::eyes_fit_test {

using test::input_error, test::Noise;

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

EyesPrior bench_prior()
{
  EyesPrior prior;
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
EyesPrior known_eyes()
{
  EyesPrior prior = bench_prior();
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

Pose X_true()
{
  return pose({40, 250, 800}, {rad_from_deg(-4), rad_from_deg(7), rad_from_deg(2)});
}

/// Numbers of the estimate after the pose.
Eigen::VectorXd eye_numbers(const EyesFit& fit)
{
  return fit.estimate.values.tail(19);
}

struct MarkNoise {
  double alignment_px = 0.0, tracker_mm = 0.0;
};

/// Nine positions for each eye, 600 to 1000 mm away, for the eyes of the prior.
std::vector<BullseyeMark> marks_of(const MarkNoise& of, Noise& noise)
{
  const view::EyePair eyes = bench_prior().eyes;
  std::vector<BullseyeMark> marks;
  for (const bool is_right : {false, true}) {
    const view::Eye& eye = view::side_of(eyes, is_right);
    for (int place = 0; place < 9; ++place) {
      const double depth_mm = 600.0 + 200.0 * (place % 3);
      const double across = 0.2 * (place / 3 - 1), up = 0.12 * ((place + place / 3) % 3 - 1);
      const Eigen::Vector3d p_head_mm = depth_mm * Eigen::Vector3d(across, up, -1.0);
      BullseyeMark mark;
      mark.is_right = is_right;
      mark.p_carrier_mm = X_true() * p_head_mm + of.tracker_mm * Eigen::Vector3d(noise.normals(3));
      mark.p_sd_mm = of.tracker_mm;
      mark.drawn_px = view::drawn_px(eye, p_head_mm) + of.alignment_px * Eigen::Vector2d(noise.normals(2));
      marks.push_back(mark);
    }
  }
  return marks;
}

EyesFit fitted(const std::vector<BullseyeMark>& marks, const EyesPrior& prior = bench_prior(),
               const Pose& X_start = pose({0, 200, 800}, {0, 0, 0}))
{
  return calibration::fit_eyes(marks, prior, X_start, "eyes", file);
}

TEST(EyesFits, MarksWithoutNoiseGiveTheEyesBack)
{
  Noise noise(1);
  const std::vector<BullseyeMark> marks = marks_of({}, noise);
  const EyesFit known = fitted(marks, known_eyes()), fit = fitted(marks, bench_prior());
  for (const EyesFit& each : {known, fit}) {
    EXPECT_LT(test::place_error(each.X_carrier_eyes, X_true()).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT((eye_numbers(each) - eye_numbers(known)).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT(each.noise_px, 1e-3);
  }
}

TEST(EyesFits, WhatIsKnownExactlyStays)
{
  Noise noise(3);
  const EyesFit exact = fitted(marks_of({}, noise), known_eyes());
  const EyesFit fit = fitted(marks_of({0.5, 0.1}, noise), known_eyes());
  EXPECT_EQ(eye_numbers(fit), eye_numbers(exact));
  EXPECT_EQ(fit.eyes.right.sight_px, bench_prior().eyes.right.sight_px);
  EXPECT_EQ(fit.estimate.covariance.bottomRightCorner(19, 19), Eigen::MatrixXd::Zero(19, 19));
  EXPECT_GT(fit.estimate.covariance(0, 0), 0.0);
}

TEST(EyesFits, MovingTheCarriersFrameMovesTheAnswer)
{
  Noise noise(4);
  const Pose X_other_carrier = pose({-300, 1200, 45}, {1.1, -0.7, 2.0});
  std::vector<BullseyeMark> marks = marks_of({0.5, 0.1}, noise);
  const Pose X_start = pose({0, 200, 800}, {0, 0, 0});
  const EyesFit here = fitted(marks, bench_prior(), X_start);
  for (BullseyeMark& mark : marks) mark.p_carrier_mm = X_other_carrier * mark.p_carrier_mm;
  const EyesFit there = fitted(marks, bench_prior(), X_other_carrier * X_start);
  constexpr double solver_tolerance = 1e-5;  // 1e-6 of a standard deviation of up to 9 px
  EXPECT_LT(test::place_error(there.X_carrier_eyes, X_other_carrier * here.X_carrier_eyes).norm(),
            solver_tolerance);
  EXPECT_LT((eye_numbers(there) - eye_numbers(here)).cwiseAbs().maxCoeff(), solver_tolerance);
  // The covariance rotates with the frame.
  const Eigen::Matrix3d R = X_other_carrier.linear();
  const Eigen::MatrixXd expected = propagated(R, here.estimate.covariance.block(3, 3, 3, 3));
  const Eigen::MatrixXd found = there.estimate.covariance.block(3, 3, 3, 3);
  EXPECT_LT((found - expected).norm(), 1e-4 * expected.norm());
}

TEST(EyesFits, TooFewBullseyesOfAnEyeAreRefused)
{
  Noise noise(7);
  std::vector<BullseyeMark> marks = marks_of({0.5, 0.1}, noise);
  marks.resize(9 + 5);
  EXPECT_THAT(input_error([&] { fitted(marks); }), test::refuses({file, "eyes: right eye", "5"}));
}

TEST(EyesFits, PositionsThatDoNotDetermineTheEyesAreRefusedWithThoseToAdd)
{
  Noise noise(8);
  const std::vector<BullseyeMark> marks = marks_of({0.5, 0.1}, noise);
  const Pose X = X_true();
  const auto refused = [&](const Eigen::Vector3d& kept) {
    std::vector<BullseyeMark> some = marks;
    for (BullseyeMark& mark : some) {
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
  std::vector<BullseyeMark> line = marks;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const double way = static_cast<double>(i) - 8.5;
    line[i].p_carrier_mm = X * Eigen::Vector3d(10 * way, 3 * way, -800 + 15 * way);
  }
  EXPECT_THAT(input_error([&] { fitted(line, bench_prior(), X); }),
              test::refuses({.field = "eyes: marker positions", .found = "line"}));
}

TEST(EyesFits, MarksThatNoEyesCanHaveMadeEndInAMessage)
{
  Noise noise(9);
  std::vector<BullseyeMark> marks = marks_of({0.5, 0.1}, noise);
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
    std::vector<BullseyeMark> marks;
    for (int k = 0; k < 9; ++k) {
      const double z_mm = -750.0 + 250.0 * part(random);
      const Eigen::Vector3d p_eyes_mm(-0.25 * z_mm * part(random), -0.2 * z_mm * part(random), z_mm);
      for (const bool is_right : {false, true}) {
        const view::Eye& eye = is_right ? true_eyes.right : true_eyes.left;
        BullseyeMark mark;
        mark.is_right = is_right;
        mark.p_carrier_mm = X_carrier_eyes * p_eyes_mm;
        mark.drawn_px = view::drawn_px(eye, p_eyes_mm) + 0.5 * Eigen::Vector2d(noise(random), noise(random));
        marks.push_back(mark);
      }
    }
    const Pose found = initial_eye_pose(marks, eyes);
    const Eigen::VectorXd apart = test::place_error(found, X_carrier_eyes);
    EXPECT_LT(apart.head<3>().norm(), most_mm);
    EXPECT_LT(apart.tail<3>().norm(), most_deg);
  }
}

TEST(EyesStart, OfTwoMarksIsNowhere)
{
  const Pose X = initial_eye_pose(std::vector<BullseyeMark>(2), some_eyes());
  EXPECT_EQ(X.matrix(), Pose::Identity().matrix());
}

}  // namespace vrda::calibration::eyes_fit_test
