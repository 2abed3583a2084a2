#include "calibration/fiducial_fit.hpp"

#include <gtest/gtest.h>

#include <random>

#include "bench/rigid_body.hpp"
#include "core/units.hpp"
#include "coverage.hpp"
#include "player/bench/moves.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::fiducial_fit_test {

using test::input_error;
using test::place_error;

/// Knee with six fiducials and two targets.
std::vector<Fiducial> knee_points()
{
  return {{"lateral epicondyle", {0, 20, 42}, {}, false},
          {"medial epicondyle", {-2, 18, -44}, {}, false},
          {"patella", {48, 5, 2}, {}, false},
          {"tubercle", {35, -60, 4}, {}, false},
          {"fibular head", {-20, -45, 45}, {}, false},
          {"thigh", {25, 110, 10}, {}, false},
          {"shank", {28, -120, -8}, {}, true},
          {"joint line", {30, -5, 38}, {}, true}};
}

std::vector<Fiducial> touched_at(std::vector<Fiducial> points, const Pose& X_body_model, double noise_mm,
                                 std::mt19937_64& random)
{
  for (Fiducial& p : points) p.p_body_mm = X_body_model * p.p_model_mm + test::noise_of(random, noise_mm);
  return points;
}

TEST(FiducialFit, RoundTripWithoutNoise)
{
  std::mt19937_64 random(51);
  const Pose X_body_model = test::random_pose(random);
  const FiducialFit fit =
      calibration::fit_fiducials(touched_at(knee_points(), X_body_model, 0.0, random), "leg", "marks");
  constexpr double rounding = 1e-9;
  EXPECT_LT(place_error(fit.X_body_model, X_body_model).norm(), rounding);
  EXPECT_LT(fit.fiducial_rms_mm + fit.target_rms_mm + fit.leave_one_out_rms_mm, rounding);
  EXPECT_EQ(fit.estimate.residuals.size(), knee_points().size());
  EXPECT_EQ(fit.estimate.names[0], "leg.shift_x");
}

TEST(FiducialFit, MovingTheBodysFrameMovesTheModel)
{
  std::mt19937_64 random(52);
  const std::vector<Fiducial> points = touched_at(knee_points(), test::random_pose(random), 0.5, random);
  const Pose X_moved = test::random_pose(random);
  std::vector<Fiducial> moved = points;
  for (Fiducial& p : moved) p.p_body_mm = X_moved * p.p_body_mm;
  const FiducialFit fit = calibration::fit_fiducials(points, "leg", "marks"),
                    there = calibration::fit_fiducials(moved, "leg", "marks");
  constexpr double rounding = 1e-9;
  EXPECT_LT(place_error(there.X_body_model, X_moved * fit.X_body_model).norm(), rounding);
  EXPECT_NEAR(there.target_rms_mm, fit.target_rms_mm, rounding);
  EXPECT_NEAR(there.leave_one_out_rms_mm, fit.leave_one_out_rms_mm, rounding);
}

TEST(FiducialFit, IntervalsAreHonestAndTargetsAsBadAsExpected)
{
  std::mt19937_64 random(53);
  test::Coverage coverage;
  double target_sq = 0.0, expected_sq = 0.0, fiducial_sq = 0.0;
  constexpr int n = 800;
  for (int set = 0; set < n; ++set) {
    const Pose X_body_model = test::random_pose(random);
    const FiducialFit fit =
        calibration::fit_fiducials(touched_at(knee_points(), X_body_model, 0.3, random), "leg", "marks");
    coverage.add(fit.estimate, place_error(fit.X_body_model, X_body_model));
    target_sq += fit.target_rms_mm * fit.target_rms_mm / n;
    expected_sq += fit.expected_target_rms_mm * fit.expected_target_rms_mm / n;
    fiducial_sq += fit.fiducial_rms_mm * fit.fiducial_rms_mm / n;
  }
  coverage.expect_honest();
  // Per set 6 target coordinates and 12 degrees of freedom of the noise: relative errors of the mean squares
  // sqrt(2 / 6 / 800) and sqrt(2 / 12 / 800), together 2.5 %; four times that.
  EXPECT_NEAR(target_sq / expected_sq, 1.0, 0.1);
  // Fiducial registration error: 3 (1 - 2 / n) variances of a coordinate. Source: Fitzpatrick (1998).
  EXPECT_NEAR(fiducial_sq / (3.0 * 0.09 * (1.0 - 2.0 / 6.0)), 1.0, 0.1);
}

InputError::Facts refusal(const std::vector<Fiducial>& points)
{
  return input_error([&] { calibration::fit_fiducials(points, "leg", "marks"); });
}

TEST(FiducialFit, RefusesSetsThatDoNotDetermineThePose)
{
  std::mt19937_64 random(54);
  const Pose X = test::random_pose(random);
  std::vector<Fiducial> few = touched_at(knee_points(), X, 0.1, random);
  for (std::size_t k = 0; k < 3; ++k) few[k].is_target = true;
  EXPECT_EQ(refusal(few).found.front(), '3');
  std::vector<Fiducial> line = knee_points();
  for (std::size_t k = 0; k < line.size(); ++k)
    line[k].p_model_mm = {1.0, 20.0 * static_cast<double>(k), 0.1};
  EXPECT_THAT(refusal(touched_at(line, X, 0.1, random)),
              test::refuses({.field = "fiducials", .found = "collinear"}));
  std::vector<Fiducial> plane = knee_points();
  for (Fiducial& p : plane) p.p_model_mm.x() = 0.3 * p.p_model_mm.y();
  EXPECT_THAT(refusal(touched_at(plane, X, 0.1, random)),
              test::refuses({.field = "fiducials", .found = "coplanar", .wanted = "plane"}));
  std::vector<Fiducial> one_place = touched_at(knee_points(), X, 0.1, random);
  for (Fiducial& p : one_place) p.p_body_mm = {1.0, 2.0, 3.0};
  EXPECT_THAT(refusal(one_place), test::refuses({.field = "fiducials", .found = "touched"}));
  std::vector<Fiducial> nowhere = touched_at(knee_points(), X, 0.1, random);
  nowhere[4].p_body_mm.z() = std::nan("");
  EXPECT_EQ(refusal(nowhere).field, "fibular head");
}

TEST(FiducialFit, RefusesTheOtherSide)
{
  std::mt19937_64 random(55);
  std::vector<Fiducial> points = touched_at(knee_points(), test::random_pose(random), 0.3, random);
  for (Fiducial& p : points) p.p_model_mm.z() *= -1.0;
  EXPECT_THAT(refusal(points), test::refuses({.field = "fiducials", .found = "mirrored"}));
}

TEST(FiducialFit, RefusesASetThatFitsItsMirrorImageAsWell)
{
  // 2.5 mm off a plane (singular value 5.6 mm) with 3 mm of noise: the side is undetermined.
  std::mt19937_64 random(56);
  std::vector<Fiducial> flat = knee_points();
  for (std::size_t k = 0; k < flat.size(); ++k) flat[k].p_model_mm.x() = k % 2 == 0 ? 2.5 : -2.5;
  int n_refused = 0;
  constexpr int n = 50;
  for (int set = 0; set < n; ++set) {
    const std::vector<Fiducial> points = touched_at(flat, test::random_pose(random), 3.0, random);
    try {
      calibration::fit_fiducials(points, "leg", "marks");
    } catch (const InputError& error) {
      n_refused += error.facts().found.find("mirrored") != std::string::npos ? 1 : 0;
    }
  }
  EXPECT_GT(n_refused, n / 2);
}

TEST(FiducialFit, SaysWhenTargetsAreWorseThanTouchingExplains)
{
  std::mt19937_64 random(58);
  std::vector<Fiducial> points = touched_at(knee_points(), test::random_pose(random), 0.1, random);
  points.back().p_body_mm.x() += 6.0;
  const FiducialFit fit = calibration::fit_fiducials(points, "leg", "marks");
  EXPECT_GT(fit.target_rms_mm, 4.0);
  EXPECT_NE(fit.estimate.remarks.back().find("twice"), std::string::npos);
}

TEST(MeanPlace, OfTwoIsHalfwayAndOfOneIsRefused)
{
  std::mt19937_64 random(60);
  const Pose first = test::random_pose(random);
  Pose second = first;
  second.linear() = bench::rotation_of({0.2, -0.1, 0.3}) * first.linear();
  second.translation() += Eigen::Vector3d(1.0, 2.0, 3.0);
  const std::vector<Pose> adjusted = {first, second};
  const FiducialFit fit = calibration::mean_adjusted_pose(adjusted, "leg", "marks");
  Pose half = first;
  half.linear() = bench::rotation_of({0.1, -0.05, 0.15}) * first.linear();
  half.translation() += Eigen::Vector3d(0.5, 1.0, 1.5);
  EXPECT_LT(place_error(fit.X_body_model, half).norm(), 1e-10);
  EXPECT_EQ(input_error([&] {
              calibration::mean_adjusted_pose({adjusted.data(), 1}, "leg", "marks");
            }).field,
            "leg");
}

std::vector<LandmarkDistance> distances_of(double scale)
{
  std::vector<LandmarkDistance> distances = {
      {"condyles", 85.0, 0.0}, {"plateau", 78.0, 0.0}, {"thigh", 410.0, 0.0}, {"shank", 370.0, 0.0}};
  for (LandmarkDistance& d : distances) d.subject_mm = scale * d.model_mm;
  return distances;
}

TEST(ScaleFit, ExactDistancesGiveTheirScale)
{
  const ScaleFit fit = fit_scale(distances_of(0.92), "marks");
  EXPECT_NEAR(fit.scale, 0.92, 1e-15);
  EXPECT_FALSE(fit.is_nonuniform);
  EXPECT_NEAR(fit.estimate.residual_rms, 0.0, 1e-12);
  EXPECT_EQ(fit.estimate.names.front(), "subject.scale");
  EXPECT_EQ(fit.estimate.dof, 3.0);
}

TEST(ScaleFit, UnevenDistancesAreCalledSo)
{
  std::vector<LandmarkDistance> distances = distances_of(1.0);
  for (LandmarkDistance& d : distances) d.subject_mm *= d.model_mm > 100.0 ? 1.06 : 0.95;
  const ScaleFit fit = fit_scale(distances, "marks");
  EXPECT_TRUE(fit.is_nonuniform);
  ASSERT_EQ(fit.estimate.remarks.size(), 1U);
  EXPECT_NE(fit.estimate.remarks[0].find("95 % to 106 %"), std::string::npos) << fit.estimate.remarks[0];
}

TEST(ScaleFit, Refuses)
{
  const auto refusal = [](const std::vector<LandmarkDistance>& distances) {
    return input_error([&] { fit_scale(distances, "marks"); });
  };
  std::vector<LandmarkDistance> few = distances_of(1.0);
  few.resize(2);
  EXPECT_THAT(refusal(few), test::refuses({.field = "landmarks", .found = "2"}));
  std::vector<LandmarkDistance> zero = distances_of(1.0);
  zero[1].subject_mm = 0.0;
  EXPECT_EQ(refusal(zero).field, "plateau");
  EXPECT_THAT(refusal(distances_of(0.45)), test::refuses({.field = "landmarks", .found = "0.45"}));
  EXPECT_EQ(refusal(distances_of(10.0)).field, "landmarks");
}

}  // namespace vrda::calibration::fiducial_fit_test
