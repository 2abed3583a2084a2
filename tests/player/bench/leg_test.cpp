#include "bench/rigid_body.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "player/bench/moves.hpp"

namespace vrda::leg_test {

constexpr double rounding_rad = 1e-14;

bench::LegAngles random_angles(std::mt19937_64& random)
{
  const Eigen::Vector3d part = test::random_vector(random, 1.0);
  return {rad_from_deg(60.0 + 75.0 * part.x()), rad_from_deg(25.0 * part.y()), rad_from_deg(40.0 * part.z())};
}

void expect_equal(const bench::LegAngles& a, const bench::LegAngles& b, double tolerance_rad)
{
  EXPECT_NEAR(a.flexion_rad, b.flexion_rad, tolerance_rad);
  EXPECT_NEAR(a.varus_rad, b.varus_rad, tolerance_rad);
  EXPECT_NEAR(a.theta_rad, b.theta_rad, tolerance_rad);
}

TEST(LegAngles, AreTheAttitudeOfAnyDeltaAndGroodSuntaysOfItsOwn)
{
  std::mt19937_64 random(31);
  for (int i = 0; i < 600; ++i) {
    SolverFrame frame{i % 2 == 0 ? Side::right : Side::left, test::random_vector(random, 300.0),
                      Eigen::Vector3d::UnitY()};
    const bench::LegAngles wanted = random_angles(random);
    const Pose X = bench::X_femur_tibia(wanted, frame, test::random_vector(random, 20.0));
    expect_equal(bench::leg_angles(X, frame), wanted, rounding_rad);
    const ClinicalCoordinates c = clinical_coordinates(X, frame.side, frame.rotation_centre_mm);
    expect_equal({c.flexion_rad, c.varus_rad, c.internal_rotation_rad}, wanted, rounding_rad);
    frame.delta = (Eigen::Vector3d::UnitY() + test::random_vector(random, 0.4)).normalized();
    expect_equal(bench::leg_angles(bench::X_femur_tibia(wanted, frame), frame), wanted, rounding_rad);
  }
}

TEST(LegAngles, FlexionTakesTheFootBackwardsOnBothSides)
{
  for (const Side side : {Side::right, Side::left}) {
    const SolverFrame frame{side, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY()};
    const Pose X = bench::X_femur_tibia({rad_from_deg(90.0), 0.0, 0.0}, frame);
    // The foot, 400 mm below the knee, points backwards: -X.
    EXPECT_LT((X * Eigen::Vector3d(0, -400, 0) - Eigen::Vector3d(-400, 0, 0)).norm(), 1e-12);
    // Varus moves it towards the other leg: to the left, -Z, for a right leg.
    const Pose X_varus = bench::X_femur_tibia({0.0, rad_from_deg(10.0), 0.0}, frame);
    EXPECT_EQ((X_varus * Eigen::Vector3d(0, -400, 0)).z() < 0.0, side == Side::right);
  }
}

TEST(LegAngles, DoNotDependOnThePosesOfTrackerAndBodies)
{
  std::mt19937_64 random(33);
  const SolverFrame frame{Side::left, {5, 6, 7}, Eigen::Vector3d::UnitY()};
  for (int i = 0; i < 200; ++i) {
    const bench::LegAngles wanted = random_angles(random);
    const bench::LegBodies bodies{test::random_pose(random), test::random_pose(random)};
    const Pose X_tracker_femur = test::random_pose(random);
    const Pose X_tracker_tibia = X_tracker_femur * bench::X_femur_tibia(wanted, frame, {1, 2, 3});
    const Pose X_thigh = X_tracker_femur * bodies.X_thigh_femur.inverse();
    const Pose X_shank = X_tracker_tibia * bodies.X_shank_tibia.inverse();
    expect_equal(bench::leg_angles(bench::X_femur_tibia(bodies, X_thigh, X_shank), frame), wanted,
                 10 * rounding_rad);
  }
}

}  // namespace vrda::leg_test
