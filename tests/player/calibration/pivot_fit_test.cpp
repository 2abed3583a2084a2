#include "calibration/table_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/units.hpp"
#include "coverage.hpp"
#include "player/tracking/moves.hpp"
#include "support/input_error.hpp"

namespace vrda::pivot_fit_test {

using test::input_error;

const Eigen::Vector3d true_tip_mm(3.0, -172.0, 12.0);
const Eigen::Vector3d true_pivot_mm(120.0, 40.0, -1500.0);

struct Sweep {
  int n = 300;
  double tilt_rad = rad_from_deg(35.0);
  double position_mm = 0.1, turn_rad = rad_from_deg(0.03);
  double slip_mm = 0.0;
};

/// Tilted to all sides about the shaft's axis, and turned about it by as much.
std::vector<Pose> poses_of(const Sweep& sweep, std::mt19937_64& random,
                           const Pose& X_moved = Pose::Identity())
{
  std::vector<Pose> poses;
  for (int k = 0; k < sweep.n; ++k) {
    const double around = 2.0 * pi * 7.3 * k / sweep.n, out = sweep.tilt_rad * std::sqrt((k + 0.5) / sweep.n);
    Pose X = Pose::Identity();
    X.linear() = rotation_of({out * std::cos(around), 0.0, out * std::sin(around)}) *
                 rotation_of({0.0, out * std::sin(3.1 * around), 0.0});
    const Eigen::Vector3d slip = sweep.slip_mm * std::sin(around) * Eigen::Vector3d::UnitX();
    X.translation() = true_pivot_mm + slip - X.linear() * true_tip_mm;
    X = X_moved * X;
    X.linear() = (rotation_of(test::noise_of(random, sweep.turn_rad)) * X.linear()).eval();
    X.translation() += test::noise_of(random, sweep.position_mm);
    poses.push_back(X);
  }
  return poses;
}

Sweep without_noise()
{
  Sweep sweep;
  sweep.position_mm = sweep.turn_rad = 0.0;
  return sweep;
}

TEST(PivotFit, RoundTripWithoutNoise)
{
  std::mt19937_64 random(31);
  const PivotFit fit = fit_pivot(poses_of(without_noise(), random), "marks");
  constexpr double rounding_mm = 1e-9;
  EXPECT_LT((fit.tip_probe_mm - true_tip_mm).norm(), rounding_mm);
  EXPECT_LT((fit.pivot_tracker_mm - true_pivot_mm).norm(), rounding_mm);
  EXPECT_LT(fit.estimate.residual_rms, rounding_mm);
}

TEST(PivotFit, MovingTheTrackerLeavesTheTipAndMovesThePivot)
{
  std::mt19937_64 random(32);
  const Pose X_moved = test::random_pose(random);
  std::vector<Pose> poses = poses_of({}, random), moved;
  moved.reserve(poses.size());
  for (const Pose& X : poses) moved.push_back(X_moved * X);
  const PivotFit fit = fit_pivot(poses, "marks"), there = fit_pivot(moved, "marks");
  constexpr double rounding_mm = 1e-9;
  EXPECT_LT((there.tip_probe_mm - fit.tip_probe_mm).norm(), rounding_mm);
  EXPECT_LT((there.pivot_tracker_mm - X_moved * fit.pivot_tracker_mm).norm(), rounding_mm);
  EXPECT_TRUE(there.estimate.covariance.isApprox(fit.estimate.covariance, rounding_mm));
}

TEST(PivotFit, IntervalsAreHonest)
{
  std::mt19937_64 random(33);
  for (const int n : {30, 300}) {
    SCOPED_TRACE(n);
    test::Coverage coverage;
    for (int bench = 0; bench < 600; ++bench) {
      Sweep sweep;
      sweep.n = n;
      const PivotFit fit = fit_pivot(poses_of(sweep, random, test::random_pose(random)), "marks");
      coverage.add(fit.estimate, fit.tip_probe_mm - true_tip_mm);
    }
    coverage.expect_honest();
  }
}

TEST(PivotFit, ASpreadIsTheHalfAngleOfACone)
{
  // Poses round a cone of 30 degrees, each turned about its axis all the way: the axis itself swings least.
  std::vector<Pose> poses;
  const double half_rad = rad_from_deg(30.0);
  for (int k = 0; k < 36; ++k) {
    for (int turn = 0; turn < 4; ++turn) {
      const double around = 2.0 * pi * k / 36.0;
      Pose X = Pose::Identity();
      X.linear() = rotation_of({half_rad * std::cos(around), 0.0, half_rad * std::sin(around)}) *
                   rotation_of({0.0, 0.5 * pi * turn, 0.0});
      X.translation() = -(X.linear() * true_tip_mm);
      poses.push_back(X);
    }
  }
  EXPECT_NEAR(fit_pivot(poses, "marks").spread_rad, half_rad, 1e-9);
}

TEST(PivotFit, SaysWhatItsNumberOfDegreesIs)
{
  // To 35 degrees on every side: that many the probe was turned by, but its swing is less.
  std::mt19937_64 random(35);
  const PivotFit fit = fit_pivot(poses_of({}, random), "marks");
  const std::string swing = std::to_string(std::lround(deg_from_rad(fit.spread_rad)));
  ASSERT_EQ(fit.estimate.remarks.size(), 1u);
  EXPECT_TRUE(fit.estimate.remarks[0].starts_with(
      "the probe swung by " + swing + " deg (rms) about the axis it turned about least; 10 are wanted"))
      << fit.estimate.remarks[0];
}

TEST(PivotFit, Refuses)
{
  std::mt19937_64 random(34);
  const auto refusal = [&](const Sweep& sweep) {
    return input_error([&] { fit_pivot(poses_of(sweep, random), "marks"); });
  };
  Sweep few;
  few.n = 19;
  EXPECT_EQ(refusal(few).found, "19 poses");
  Sweep still;
  still.tilt_rad = 0.0;
  EXPECT_NE(refusal(still).found.find("swings of 0 deg (rms)"), std::string::npos) << refusal(still).found;
  Sweep little;
  little.tilt_rad = rad_from_deg(8.0);
  EXPECT_NE(refusal(little).wanted.find("tilt the probe"), std::string::npos);
  Sweep slipped;
  slipped.slip_mm = 6.0;
  EXPECT_NE(refusal(slipped).wanted.find("slipped"), std::string::npos) << refusal(slipped).wanted;
  EXPECT_EQ(refusal(slipped).field, "probe");
}

TEST(PivotFit, RefusesTurnsAboutOneAxis)
{
  std::vector<Pose> poses;
  for (int k = 0; k < 100; ++k) {
    Pose X = Pose::Identity();
    X.linear() = rotation_of({0.01 * k, 0.0, 0.0});
    X.translation() = true_pivot_mm - X.linear() * true_tip_mm;
    poses.push_back(X);
  }
  EXPECT_NE(input_error([&] { fit_pivot(poses, "marks"); }).found.find("swings of 0 deg (rms)"),
            std::string::npos);
}

}  // namespace vrda::pivot_fit_test
