
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "bench/rigid_body.hpp"
#include "calibration/tracker_fits.hpp"
#include "core/units.hpp"
#include "player/calibration/fit_support.hpp"
#include "support/refusal.hpp"

namespace vrda::calibration::functional_fit_test {

using test::knee_curve;

/// The points of jobs/bench-desk.toml.
const std::vector<Eigen::Vector3d> femur_points{{-1, 4, -42.9}, {-2, 3, 41.7},   {27.7, 30, 4},
                                                {-25, -4, -22}, {-23.7, -4, 22}, {-8, 24, -19.8},
                                                {22.9, 100, 0}, {-4.9, 90, 2}};
const std::vector<Eigen::Vector3d> tibia_points{{24.6, -64, 1},    {3, -38, -39.6},  {1, -38, 39.1},
                                                {-21.1, -38, -20}, {-15, -50, 46.6}, {18.7, -125, 0}};

struct LegNoise {
  double landmark_mm = 5.0, tracker_mm = 0.3, tracker_deg = 0.3, model_mm = 1.0, model_deg = 2.0;
  double last_deg = 90.0;
  int n_trials = 4;
};

/// A leg of which the truth is known.
struct Leg {
  Pose X_thigh_femur, X_shank_tibia;
  BonePlacement femur, tibia;  ///< by landmarks
  std::vector<FlexionTrial> trials;
};

Pose noisy(const Pose& X, test::Noise& noise, double mm, double deg)
{
  Pose moved = X;
  moved.translation() += mm * noise.normals(3);
  moved.linear() = bench::rotation_of(rad_from_deg(deg) * noise.normals(3)) * X.linear();
  return moved;
}

BonePlacement by_landmarks(const std::vector<Eigen::Vector3d>& points, const Pose& X, test::Noise& noise,
                           double mm)
{
  std::optional<FiducialFit> found;
  // Points that a session refuses are touched again.
  while (!found) {
    std::vector<Fiducial> touched;
    for (const Eigen::Vector3d& p : points)
      touched.push_back({"point", p, X * p + mm * noise.normals(3), false});
    try {
      found = fit_fiducials(touched, "bone", "leg");
    } catch (const bench::FitError&) {
    }
  }
  const FiducialFit& fit = *found;
  Matrix6 C = fit.estimate.covariance;
  const double t = bench::t_95(fit.estimate.dof) / bench::t_95(std::numeric_limits<double>::infinity());
  Eigen::Matrix<double, 6, 1> unit = Eigen::Matrix<double, 6, 1>::Constant(t);
  unit.tail<3>() *= rad_from_deg(1.0);
  return {fit.X_body_model, unit.asDiagonal() * C * unit.asDiagonal()};
}

/// Deviation of the joint from its model: each coordinate is a random sinusoid of flexion about a random
/// offset, with equal variance at all flexions.
class Deviation {
 public:
  Deviation(test::Noise& noise, double mm, double deg)
  {
    const double third = std::sqrt(1.0 / 6.0);  // of a coordinate, of half the variance each
    for (Eigen::VectorXd& part : parts_) {
      part = noise.normals(6);
      part.head<3>() *= third * mm;
      part.tail<3>() *= third * rad_from_deg(deg);
    }
  }
  Pose at(double flexion_rad) const
  {
    const double phase = 2.0 * flexion_rad;  // half a wave in 90 degrees
    const Eigen::VectorXd six = parts_[0] + std::cos(phase) * parts_[1] + std::sin(phase) * parts_[2];
    Pose X = Pose::Identity();
    X.translation() = six.head<3>();
    X.linear() = bench::rotation_of(six.tail<3>());
    return X;
  }

 private:
  std::array<Eigen::VectorXd, 3> parts_;
};

Leg leg_of(std::uint64_t seed, const LegNoise& with, const JointCurve& curve)
{
  test::Noise noise(seed);
  Leg leg;
  leg.X_thigh_femur = noisy(Pose(Eigen::Translation3d(-60, -120, 0)), noise, 10.0, 20.0);
  leg.X_shank_tibia = noisy(Pose(Eigen::Translation3d(-60, 120, 0)), noise, 10.0, 20.0);
  leg.femur = by_landmarks(femur_points, leg.X_thigh_femur, noise, with.landmark_mm);
  leg.tibia = by_landmarks(tibia_points, leg.X_shank_tibia, noise, with.landmark_mm);
  const Deviation deviation(noise, with.model_mm, with.model_deg);
  const Pose X_centre(Eigen::Translation3d(curve.centre_mm));
  for (int trial = 0; trial < with.n_trials; ++trial) {
    leg.trials.push_back({"bend " + std::to_string(trial + 1), {}});
    for (int k = 0; k < 100; ++k) {
      const double flexion_rad = rad_from_deg(with.last_deg) * 0.5 * (1.0 - std::cos(2.0 * pi * k / 99.0));
      const Pose X_femur_tibia =
          curve.at(flexion_rad) * X_centre * deviation.at(flexion_rad) * X_centre.inverse();
      const Pose X_thigh_shank = leg.X_thigh_femur * X_femur_tibia * leg.X_shank_tibia.inverse();
      const Pose X_tracker_thigh = noisy(Pose::Identity(), noise, with.tracker_mm, with.tracker_deg);
      const Pose X_tracker_shank = noisy(X_thigh_shank, noise, with.tracker_mm, with.tracker_deg);
      leg.trials.back().X_thigh_shank.push_back(X_tracker_thigh.inverse() * X_tracker_shank);
    }
  }
  return leg;
}

FunctionalInput input_of(const Leg& leg, const JointCurve& curve)
{
  return {leg.trials, curve, leg.femur, leg.tibia, {}};
}

FunctionalFit fit_of(const Leg& leg, const JointCurve& curve)
{
  return calibration::fit_functional(input_of(leg, curve), "leg.toml");
}

/// Overlay error of both bones.
double joint_error_mm(const Pose& X_thigh_femur, const Pose& X_shank_tibia, const Leg& leg,
                      const JointCurve& curve)
{
  return std::hypot(calibration::joint_error_mm(X_thigh_femur, leg.X_thigh_femur, curve.centre_mm),
                    calibration::joint_error_mm(X_shank_tibia, leg.X_shank_tibia, curve.centre_mm)) /
         std::sqrt(2.0);
}

TEST(JointCurve, PassesItsKnotsSmoothlyAndSurvivesItsRecord)
{
  const JointCurve curve = knee_curve();
  constexpr double rounding = 1e-12;
  for (std::size_t k = 0; k < curve.knots.size(); ++k) {
    const Pose X = curve.at(curve.first_rad + static_cast<double>(k) * curve.step_rad);
    EXPECT_LT((X.translation() - curve.knots[k].head<3>()).norm(), rounding);
    EXPECT_LT((bench::turn_of(X.linear()) - curve.knots[k].tail<3>()).norm(), rounding);
  }
  // No kink at a knot, and beyond the ends: equal differences on both sides, up to the curvature.
  constexpr double step_rad = 1e-6, curvature = 1e-3;
  for (const double at_rad : {curve.first_rad, curve.first_rad + curve.step_rad, curve.last_rad()}) {
    const Eigen::Vector3d before = curve.at(at_rad - step_rad).translation(),
                          here = curve.at(at_rad).translation(),
                          after = curve.at(at_rad + step_rad).translation();
    EXPECT_LT((after - 2.0 * here + before).norm() / step_rad, curvature);
  }
  const std::vector<double> numbers = numbers_of(curve);
  const JointCurve read = calibration::joint_curve_of(numbers, "made_with", "leg.toml");
  EXPECT_TRUE(read.at(0.7).isApprox(curve.at(0.7), rounding));
  EXPECT_EQ(read.centre_mm, curve.centre_mm);
  EXPECT_TRUE(
      calibration::scaled(curve, 2.0).at(0.7).translation().isApprox(2.0 * curve.at(0.7).translation()));
  for (const std::size_t n : {std::size_t{0}, std::size_t{11}, numbers.size() - 1}) {
    EXPECT_THAT(test::input_error([&] {
                  calibration::joint_curve_of({numbers.data(), n}, "made_with", "leg.toml");
                }),
                test::refuses({"leg.toml", "made_with", std::to_string(n)}));
  }
}

/// With exact landmarks and an exact motion nothing moves.
TEST(FunctionalFit, ExactLandmarksAndMotionStay)
{
  const JointCurve curve = knee_curve();
  LegNoise exact{0.0, 0.0, 0.0, 0.0, 0.0};
  Leg leg = leg_of(1, exact, curve);
  leg.femur.covariance_mm_rad = leg.tibia.covariance_mm_rad = Matrix6::Identity();
  const FunctionalFit fit = fit_of(leg, curve);
  constexpr double converged_mm = 1e-6;
  EXPECT_LT(joint_error_mm(fit.X_thigh_femur, fit.X_shank_tibia, leg, curve), converged_mm);
  EXPECT_LT(fit.held_out.mm, converged_mm);
  EXPECT_NEAR(deg_from_rad(fit.flexion_range_rad), 90.0, 1.0);
}

/// Turning both bodies' frames turns the placements with them.
TEST(FunctionalFit, DoesNotDependOnTheBodiesAxes)
{
  const JointCurve curve = knee_curve();
  const Leg leg = leg_of(4, {}, curve);
  const FunctionalFit fit = fit_of(leg, curve);
  const Eigen::Matrix3d R_thigh = bench::rotation_of({0.4, -1.0, 0.7});
  Pose X_turn = Pose::Identity();
  X_turn.linear() = R_thigh;
  Leg turned = leg;
  for (FlexionTrial& trial : turned.trials)
    for (Pose& X : trial.X_thigh_shank) X = X_turn * X;
  turned.femur.X_body_bone = X_turn * leg.femur.X_body_bone;
  Matrix6 A = Matrix6::Zero();
  A.topLeftCorner<3, 3>() = A.bottomRightCorner<3, 3>() = R_thigh;
  turned.femur.covariance_mm_rad = A * leg.femur.covariance_mm_rad * A.transpose();
  const FunctionalFit moved = fit_of(turned, curve);
  constexpr double converged_mm = 1e-4;
  EXPECT_LT(calibration::joint_error_mm(moved.X_thigh_femur, X_turn * fit.X_thigh_femur, curve.centre_mm),
            converged_mm);
  EXPECT_LT(calibration::joint_error_mm(moved.X_shank_tibia, fit.X_shank_tibia, curve.centre_mm),
            converged_mm);
  EXPECT_NEAR(moved.held_out.mm, fit.held_out.mm, converged_mm);
}

/// Legs with landmarks of 5 mm, tracking of 0.3 mm and 0.3 degrees, and joints 1 mm and 2 degrees off the
/// model.
TEST(FunctionalFit, HalvesTheRootMeanSquareErrorAtTheJointAndItsIntervalsHold)
{
  const JointCurve curve = knee_curve();
  constexpr int n_legs = 24;
  int n_halved = 0, n_within = 0, n_numbers = 0;
  double expected_mm2 = 0.0, found_mm2 = 0.0, landmarks_mm2 = 0.0;
  for (std::uint64_t seed = 1; seed <= n_legs; ++seed) {
    const Leg leg = leg_of(seed, {}, curve);
    const FunctionalFit fit = fit_of(leg, curve);
    const double before_mm = joint_error_mm(leg.femur.X_body_bone, leg.tibia.X_body_bone, leg, curve);
    const double after_mm = joint_error_mm(fit.X_thigh_femur, fit.X_shank_tibia, leg, curve);
    n_halved += after_mm <= 0.5 * before_mm ? 1 : 0;
    expected_mm2 += fit.joint_mm * fit.joint_mm / n_legs;
    found_mm2 += after_mm * after_mm / n_legs;
    landmarks_mm2 += before_mm * before_mm / n_legs;
    // Held-out trials fit to the tracker's noise, 0.3 mm and 0.3 degrees of two bodies 120 mm from the joint.
    EXPECT_LT(fit.held_out.mm, 3.0) << seed;
    EXPECT_LT(fit.held_out.rad, rad_from_deg(1.0)) << seed;
    EXPECT_LT(fit.held_out.mm, fit.by_landmarks.mm) << seed;
    Eigen::VectorXd error(12);
    error << test::place_error(fit.X_thigh_femur, leg.X_thigh_femur),
        test::place_error(fit.X_shank_tibia, leg.X_shank_tibia);
    for (Eigen::Index k = 0; k < error.size(); ++k)
      n_within += std::abs(error[k]) <= bench::half_width_95(fit.estimate, k) ? 1 : 0;
    n_numbers += static_cast<int>(error.size());
  }
  RecordProperty("halved", n_halved);
  RecordProperty("within", n_within);
  RecordProperty("rms_um_by_landmarks", static_cast<int>(1000.0 * std::sqrt(landmarks_mm2)));
  RecordProperty("rms_um_by_motion", static_cast<int>(1000.0 * std::sqrt(found_mm2)));
  EXPECT_LE(std::sqrt(found_mm2), 0.5 * std::sqrt(landmarks_mm2));
  EXPECT_GE(n_within, 0.90 * n_numbers);
  EXPECT_LE(n_within, 0.98 * n_numbers);
  // The errors of 24 legs have some 100 independent numbers: 15 % of their root mean square is two
  // deviations.
  EXPECT_NEAR(std::sqrt(found_mm2 / expected_mm2), 1.0, 0.15);
}

TEST(FunctionalFit, SaysWhatItCannotUse)
{
  const JointCurve curve = knee_curve();
  const auto refuses = [&](const Leg& leg, const test::Refusal& wanted, std::vector<std::size_t> marks) {
    try {
      fit_of(leg, curve);
      ADD_FAILURE() << "not refused: " << wanted.field;
    } catch (const bench::FitError& error) {
      EXPECT_THAT(error.facts(), test::refuses(wanted));
      EXPECT_EQ(error.marks(), marks);
    }
  };
  LegNoise once;
  once.n_trials = 1;
  refuses(leg_of(11, once, curve), {.field = "bends", .found = "1 bends"}, {});
  LegNoise small;
  small.last_deg = 30.0;
  refuses(leg_of(11, small, curve), {.field = "bends", .wanted = "40 degrees"}, {});
  const Leg good = leg_of(11, {}, curve);
  Leg beyond = good;
  for (Pose& X : beyond.trials[1].X_thigh_shank) {
    const Eigen::Matrix3d R = rotation_z(rad_from_deg(-125.0));
    X = good.X_thigh_femur * Pose(R) * good.X_shank_tibia.inverse();
  }
  refuses(beyond, {.field = "bend 2", .found = "0 samples within"}, {1});
  // Each body on the other bone.
  Leg exchanged = good;
  for (FlexionTrial& trial : exchanged.trials)
    for (Pose& X : trial.X_thigh_shank) X = X.inverse();
  refuses(exchanged, {.field = "bend 1"}, {0});
  // The shank's body slipped before the third trial.
  Leg slipped = good;
  Pose X_slip = Pose::Identity();
  X_slip.translation() = Eigen::Vector3d(10.0, -8.0, 12.0);
  X_slip.linear() = bench::rotation_of({0.05, 0.1, -0.05});
  for (Pose& X : slipped.trials[2].X_thigh_shank) X = X * X_slip;
  refuses(slipped, {.field = "bend 3", .found = "tracker"}, {2});
  // Landmarks that are better than any motion of a deviating joint.
  Leg exact = good;
  for (BonePlacement* bone : {&exact.femur, &exact.tibia}) bone->covariance_mm_rad *= 1e-4;
  exact.femur.X_body_bone = exact.X_thigh_femur;
  exact.tibia.X_body_bone = exact.X_shank_tibia;
  refuses(exact, {.field = "bends", .found = "expected error at the joint"}, {});
  Leg missing = good;
  missing.trials[3].X_thigh_shank[5].translation().x() = std::nan("");
  refuses(missing, {.field = "bend 4", .found = "not finite"}, {3});
}

}  // namespace vrda::calibration::functional_fit_test
