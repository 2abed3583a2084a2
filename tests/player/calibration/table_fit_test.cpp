#include "calibration/table_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/units.hpp"
#include "coverage.hpp"
#include "player/tracking/moves.hpp"
#include "support/input_error.hpp"

namespace vrda::table_fit_test {

using test::input_error;
using test::place_error;

/// A bench as it is: rails nearly square, one above the other.
struct Bench {
  Pose X_tracker_table = Pose::Identity();
  double apart_rad = rad_from_deg(89.8);
  double height_mm = 35.0;  ///< of the second rail
  double noise_mm = 0.1;
  int n = 200;
  double length_mm = 400.0;
};

struct Sweeps {
  RailSweep x, z;
};

Sweeps sweeps_of(const Bench& bench, std::mt19937_64& random)
{
  Sweeps sweeps;
  const Eigen::Vector3d z_direction(std::cos(bench.apart_rad), 0.0, std::sin(bench.apart_rad));
  for (int k = 0; k < bench.n; ++k) {
    const double share = static_cast<double>(k) / (bench.n - 1);
    const double x_mm = (share - 0.3) * bench.length_mm;
    const Eigen::Vector3d on_z =
        Eigen::Vector3d(0.0, bench.height_mm, 0.0) + (100.0 + share * bench.length_mm) * z_direction;
    sweeps.x.p_tracker_mm.emplace_back(bench.X_tracker_table * Eigen::Vector3d(x_mm, 0.0, 0.0) +
                                       test::noise_of(random, bench.noise_mm));
    sweeps.x.stage_mm.push_back(x_mm + 17.0);
    sweeps.z.p_tracker_mm.emplace_back(bench.X_tracker_table * on_z + test::noise_of(random, bench.noise_mm));
  }
  return sweeps;
}

TEST(TableFit, RoundTripWithoutNoise)
{
  std::mt19937_64 random(41);
  Bench bench;
  bench.noise_mm = 0.0;
  bench.X_tracker_table = test::random_pose(random);
  const Sweeps sweeps = sweeps_of(bench, random);
  const TableFit fit = fit_table(sweeps.x, sweeps.z, "marks");
  constexpr double rounding = 1e-9;
  EXPECT_LT(place_error(fit.X_tracker_table, bench.X_tracker_table).norm(), rounding);
  EXPECT_NEAR(fit.rails_apart_rad, bench.apart_rad, rounding);
  EXPECT_NEAR(fit.stage_scale, 1.0, rounding);
  EXPECT_NEAR(fit.X_tracker_table.linear().determinant(), 1.0, rounding);
  EXPECT_EQ(fit.estimate.names.front(), "table.shift_x");
  EXPECT_NE(fit.estimate.remarks.front().find("the rails are 89.8 deg apart"), std::string::npos);
}

TEST(TableFit, UpIsUpWhenXGoesRightAndZTowardsTheViewer)
{
  std::mt19937_64 random(42);
  const Sweeps sweeps = sweeps_of({}, random);
  const TableFit fit = fit_table(sweeps.x, sweeps.z, "marks");
  EXPECT_GT(fit.X_tracker_table.linear()(1, 1), 0.99);
}

TEST(TableFit, MovingTheTrackerMovesTheTable)
{
  std::mt19937_64 random(43);
  const Pose X_moved = test::random_pose(random);
  const Sweeps sweeps = sweeps_of({}, random);
  Sweeps moved = sweeps;
  for (RailSweep* sweep : {&moved.x, &moved.z}) {
    for (Eigen::Vector3d& p : sweep->p_tracker_mm) p = X_moved * p;
  }
  const TableFit fit = fit_table(sweeps.x, sweeps.z, "marks"), there = fit_table(moved.x, moved.z, "marks");
  constexpr double rounding = 1e-9;
  EXPECT_LT(place_error(there.X_tracker_table, X_moved * fit.X_tracker_table).norm(), rounding);
  Eigen::MatrixXd turned = Eigen::MatrixXd::Zero(6, 6);
  turned.topLeftCorner<3, 3>() = turned.bottomRightCorner<3, 3>() = X_moved.linear();
  constexpr double differences = 1e-5;  // central ones, of a step of 1e-5
  EXPECT_TRUE(
      there.estimate.covariance.isApprox(turned * fit.estimate.covariance * turned.transpose(), differences));
}

TEST(TableFit, IntervalsAreHonest)
{
  std::mt19937_64 random(44);
  for (const int n : {12, 200}) {
    SCOPED_TRACE(n);
    test::Coverage coverage;
    for (int set = 0; set < 600; ++set) {
      Bench bench;
      bench.n = n;
      bench.X_tracker_table = test::random_pose(random);
      bench.apart_rad += rad_from_deg(test::random_vector(random, 1.0).x());
      const Sweeps sweeps = sweeps_of(bench, random);
      const TableFit fit = fit_table(sweeps.x, sweeps.z, "marks");
      coverage.add(fit.estimate, place_error(fit.X_tracker_table, bench.X_tracker_table));
      coverage.add("apart", fit.rails_apart_rad - bench.apart_rad,
                   t_95(fit.estimate.dof) * fit.rails_apart_sd_rad);
    }
    coverage.expect_honest();
  }
}

InputError::Facts refusal(const Sweeps& sweeps)
{
  return input_error([&] { fit_table(sweeps.x, sweeps.z, "marks"); });
}

TEST(TableFit, RefusesSweepsThatAreNone)
{
  std::mt19937_64 random(45);
  Bench few;
  few.n = 9;
  EXPECT_EQ(refusal(sweeps_of(few, random)).found, "9 places");
  Bench still;
  still.length_mm = 45.0;
  EXPECT_NE(refusal(sweeps_of(still, random)).found.find("a sweep of 4"), std::string::npos);
  Sweeps bent = sweeps_of({}, random);
  for (std::size_t k = 0; k < bent.z.p_tracker_mm.size(); ++k)
    bent.z.p_tracker_mm[k].y() += 12.0 * std::sin(pi * static_cast<double>(k) / 200.0);
  EXPECT_EQ(refusal(bent).field, "z_rail");
  EXPECT_NE(refusal(bent).found.find("off any line"), std::string::npos);
  Sweeps nowhere = sweeps_of({}, random);
  nowhere.x.p_tracker_mm[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(nowhere).field, "x_rail");
}

TEST(TableFit, RefusesAnOutlierByItsPlace)
{
  std::mt19937_64 random(46);
  for (const int n : {10, 200}) {
    Bench bench;
    bench.n = n;
    for (const std::size_t k : {std::size_t{0}, std::size_t{6}}) {
      Sweeps sweeps = sweeps_of(bench, random);
      sweeps.x.p_tracker_mm[k].y() += 8.0;
      EXPECT_NE(refusal(sweeps).found.find("place " + std::to_string(k + 1) + " "), std::string::npos)
          << refusal(sweeps).found;
    }
  }
}

TEST(TableFit, RefusesParallelRails)
{
  std::mt19937_64 random(47);
  for (const double apart_deg : {0.5, 40.0, 140.0, 179.5}) {
    Bench bench;
    bench.apart_rad = rad_from_deg(apart_deg);
    EXPECT_EQ(refusal(sweeps_of(bench, random)).field, "z_rail");
    EXPECT_NE(refusal(sweeps_of(bench, random)).found.find("apart"), std::string::npos);
  }
}

TEST(TableFit, RefusesAnEncoderThatCountsOtherwise)
{
  std::mt19937_64 random(48);
  for (const double scale : {-1.0, 0.0, 0.96, 1.04}) {
    SCOPED_TRACE(scale);
    Sweeps sweeps = sweeps_of({}, random);
    for (double& s : sweeps.x.stage_mm) s *= scale;
    EXPECT_NE(refusal(sweeps).wanted.find("stage_mm_per_count"), std::string::npos);
  }
  Sweeps unknown = sweeps_of({}, random);
  unknown.x.stage_mm.clear();
  EXPECT_EQ(fit_table(unknown.x, unknown.z, "marks").stage_scale, 0.0);
}

}  // namespace vrda::table_fit_test
