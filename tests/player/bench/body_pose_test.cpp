#include "bench/rigid_body.hpp"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "player/bench/moves.hpp"
#include "support/allocation_count.hpp"

namespace vrda::body_pose_test {

using test::distance_mm;
using test::leg_body;
using test::seen_at;
using test::turn_between_rad;

/// Sums of a few products of 1000 mm, over a spread of 100 mm.
constexpr double rounding_mm = 1e-11;
constexpr double rounding_rad = 1e-13;

TEST(FitPose, FindsTheExactPoseFromAnyThreeOrMore)
{
  std::mt19937_64 random(21);
  const bench::RigidBody body = leg_body();
  int n_of_three = 0;
  for (int i = 0; i < 500; ++i) {
    const Pose X = test::random_pose(random);
    bench::MarkerRow seen = seen_at(body, X);
    const int n_hidden = i % 4;
    for (int hidden = 0; hidden < n_hidden; ++hidden) seen[static_cast<std::size_t>(i + hidden) % 6].reset();
    const bench::PoseFit fit = bench::fit_pose(body, seen);
    n_of_three += fit.cloud.n == 3 ? 1 : 0;
    ASSERT_EQ(fit.status, bench::FitStatus::fitted);
    EXPECT_EQ(fit.cloud.n, 6 - n_hidden);
    EXPECT_LT(distance_mm(fit.X_tracker_body, X), 20 * rounding_mm);
    EXPECT_LT(turn_between_rad(fit.X_tracker_body, X), rounding_rad);
    EXPECT_GT(fit.X_tracker_body.linear().determinant(), 0.0);
    EXPECT_LT(fit.residual_rms_mm, rounding_mm);
  }
  EXPECT_EQ(n_of_three, 125);
}

TEST(FitPose, MovingTheTrackerMovesThePose)
{
  std::mt19937_64 random(22);
  const bench::RigidBody body = leg_body();
  for (int i = 0; i < 100; ++i) {
    bench::MarkerRow seen = seen_at(body, test::random_pose(random));
    for (auto& p : seen) *p += test::noise_of(random, 0.3);
    const bench::PoseFit here = bench::fit_pose(body, seen);
    const Pose X_there_here = test::random_pose(random);
    for (auto& p : seen) p = X_there_here * *p;
    const bench::PoseFit there = bench::fit_pose(body, seen);
    EXPECT_LT(distance_mm(there.X_tracker_body, X_there_here * here.X_tracker_body), 100 * rounding_mm);
    EXPECT_NEAR(there.residual_rms_mm, here.residual_rms_mm, rounding_mm);
  }
}

TEST(FitPose, RefusesWhatHoldsNoPose)
{
  const bench::RigidBody body = leg_body();
  bench::MarkerRow two = seen_at(body, Pose::Identity());
  for (std::size_t k = 2; k < 6; ++k) two[k].reset();
  EXPECT_EQ(bench::fit_pose(body, two).status, bench::FitStatus::too_few_markers);
  bench::MarkerRow not_finite = two;
  for (const double value : {std::numeric_limits<double>::quiet_NaN(),
                             -std::numeric_limits<double>::infinity(), 1e300, bench::farthest_mm}) {
    not_finite[3] = Eigen::Vector3d(0, value, 0);
    EXPECT_EQ(bench::fit_pose(body, not_finite).status, bench::FitStatus::too_few_markers);
  }

  // Markers at (-a, 0), (a, 0), (0, h): the sum of squared heights about their mean is 2/3 h^2.
  for (const double above : {-1e-6, 1e-6}) {
    bench::RigidBody flat;
    flat.markers_mm.resize(3, 3);
    flat.markers_mm << -50, 0, 0, 50, 0, 0, 0, (bench::least_spread_mm + above) * std::sqrt(1.5), 0;
    const bench::PoseFit fit = bench::fit_pose(flat, seen_at(flat, Pose::Identity()));
    EXPECT_EQ(fit.status, above < 0.0 ? bench::FitStatus::collinear : bench::FitStatus::fitted);
    EXPECT_NEAR(fit.cloud.spread_mm(1), bench::least_spread_mm + above, 1e-9);
  }
}

TEST(FitPose, DropsOutliersWhileTheRestAgrees)
{
  std::mt19937_64 random(23);
  const bench::RigidBody body = leg_body();
  for (int i = 0; i < 60; ++i) {
    const Pose X = test::random_pose(random);
    bench::MarkerRow seen = seen_at(body, X);
    const int n_wrong = 1 + i % 2;
    for (int k = 0; k < n_wrong; ++k)
      *seen[static_cast<std::size_t>(i + 2 * k) % 6] += 25.0 * test::random_vector(random, 1.0).normalized();
    const bench::PoseFit fit = bench::fit_pose(body, seen);
    ASSERT_EQ(fit.status, bench::FitStatus::fitted);
    EXPECT_EQ(fit.n_outliers, n_wrong);
    EXPECT_EQ(fit.cloud.n, 6 - n_wrong);
    EXPECT_LT(distance_mm(fit.X_tracker_body, X), 100 * rounding_mm);
  }
  // Three of six are too many, and fewer than four that agree prove nothing.
  bench::MarkerRow seen = seen_at(body, Pose::Identity());
  for (std::size_t k : {0U, 2U, 4U}) *seen[k] += Eigen::Vector3d(10.0 + 15.0 * static_cast<double>(k), 20, 0);
  EXPECT_EQ(bench::fit_pose(body, seen).status, bench::FitStatus::residual_too_large);
  for (const std::size_t n_hidden : {1U, 2U}) {
    seen = seen_at(body, Pose::Identity());
    seen[0]->x() += 20.0;
    for (std::size_t k = 1; k <= n_hidden; ++k) seen[k].reset();
    EXPECT_EQ(bench::fit_pose(body, seen).status,
              n_hidden == 1 ? bench::FitStatus::fitted : bench::FitStatus::residual_too_large);
  }
}

TEST(FitPose, WhateverIsSeenGivesARotationOrARefusal)
{
  // Markers anywhere: coincident, collinear, far away, not finite, some missing.
  std::mt19937_64 random(26);
  const bench::RigidBody body = leg_body();
  int n_of_status[4] = {0, 0, 0, 0};
  for (int i = 0; i < 4000; ++i) {
    const double size_mm = std::array{0.0, 1e-150, 1.0, 1e5}[static_cast<std::size_t>(i) % 4];
    bench::MarkerRow seen = i % 5 == 0 ? seen_at(body, test::random_pose(random)) : bench::MarkerRow(6);
    for (std::size_t k = 0; k < 6; ++k) {
      const std::uint64_t what = random() % 8;
      if (what == 0) seen[k].reset();
      if (what == 1) seen[k] = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
      if (what == 2 || (i % 5 != 0 && what > 2)) seen[k] = test::random_vector(random, size_mm);
    }
    const bench::PoseFit fit = bench::fit_pose(body, seen);
    ++n_of_status[static_cast<std::size_t>(fit.status)];
    const Eigen::Matrix3d R = fit.X_tracker_body.linear();
    EXPECT_LT((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-12);
    EXPECT_GT(R.determinant(), 0.0);
    EXPECT_TRUE(fit.X_tracker_body.translation().allFinite());
  }
  // No three of the leg's markers are collinear.
  EXPECT_GT(n_of_status[static_cast<std::size_t>(bench::FitStatus::fitted)], 100);
  EXPECT_GT(n_of_status[static_cast<std::size_t>(bench::FitStatus::too_few_markers)], 10);
  EXPECT_EQ(n_of_status[static_cast<std::size_t>(bench::FitStatus::collinear)], 0);
  EXPECT_GT(n_of_status[static_cast<std::size_t>(bench::FitStatus::residual_too_large)], 1000);
}

TEST(FitPose, AllocatesNothing)
{
  const bench::RigidBody body = leg_body();
  const bench::MarkerRow seen = seen_at(body, Pose::Identity());
  const bench::BodyMotion before{{0.0, Pose(Eigen::Translation3d(1, 0, 0))}, {}};
  const long n_before = test::allocations_of_thread();
  const bench::PoseFit fit = bench::fit_pose(body, seen);
  const bench::FiredFit fired = bench::fit_fired(body, seen, 0.01, before, {.interval_s = 2e-4});
  EXPECT_EQ(test::allocations_of_thread(), n_before);
  EXPECT_EQ(fit.status, bench::FitStatus::fitted);
  EXPECT_TRUE(fired.is_corrected);
}

TEST(ExpectedError, OfARegularCrossIsTheClosedForm)
{
  // Four markers at +-a on X and Y: spreads sqrt(2) a, sqrt(2) a, 0.
  bench::RigidBody cross;
  const double a = 50.0, noise = 0.1;
  cross.markers_mm.resize(4, 3);
  cross.markers_mm << a, 0, 0, -a, 0, 0, 0, a, 0, 0, -a, 0;
  const bench::MarkerCloud cloud = bench::cloud_of(cross, seen_at(cross, Pose::Identity()));
  const bench::PoseError error = bench::expected_error(cloud, noise);
  EXPECT_NEAR(error.turn_rad(2), noise / (2.0 * a), 1e-15);
  EXPECT_NEAR(error.turn_rad(0), noise / (std::sqrt(2.0) * a), 1e-15);
  EXPECT_NEAR(error.centre_mm, noise * std::sqrt(3.0 / 4.0), 1e-15);
  // On the normal at distance d: both rotations perpendicular to it, d noise / (sqrt(2) a) each.
  const double d = 200.0;
  EXPECT_NEAR(bench::target_error_mm(cloud, noise, {0, 0, d}), noise * std::sqrt(0.75 + d * d / (a * a)),
              1e-12);
}

/// Positions as the markers fire while the body moves along `twist` per second, in the tracker's frame.
bench::MarkerRow fired_at(const bench::RigidBody& body, const Pose& X_at_time, const bench::Screw& twist,
                          double interval_s)
{
  bench::MarkerRow row;
  for (Eigen::Index k = 0; k < body.markers_mm.rows(); ++k) {
    const Pose X = bench::pose_of(bench::scaled(twist, interval_s * static_cast<double>(k))) * X_at_time;
    row.emplace_back(X * Eigen::Vector3d(body.markers_mm.row(k).transpose()));
  }
  return row;
}

TEST(FitFired, ConstantTwistIsCorrectedExactly)
{
  std::mt19937_64 random(25);
  const bench::RigidBody body = leg_body();
  double largest_uncorrected_mm = 0.0;
  for (int i = 0; i < 200; ++i) {
    // Hands: up to 1 m/s and 5 rad/s at the body; markers fill a third of the 10 ms between frames.
    const Pose X_before = test::random_pose(random);
    const bench::Screw at_body{test::random_vector(random, 3.0), test::random_vector(random, 600.0)};
    bench::Screw twist = at_body;
    twist.shift_mm -= at_body.turn_rad.cross(X_before.translation());
    const double gap_s = 0.01, interval_s = 6e-4;
    const Pose X_now = bench::pose_of(bench::scaled(twist, gap_s)) * X_before;
    const bench::MarkerRow seen = fired_at(body, X_now, twist, interval_s);
    const bench::FiredFit fired = bench::fit_fired(
        body, seen, 5.0 + gap_s, bench::BodyMotion{{5.0, X_before}, {}}, {.interval_s = interval_s});
    ASSERT_TRUE(fired.is_corrected);
    EXPECT_LT(distance_mm(fired.fit.X_tracker_body, X_now), 1e-8);
    EXPECT_LT(turn_between_rad(fired.fit.X_tracker_body, X_now), 1e-10);
    EXPECT_LT((fired.velocity.turn_rad - twist.turn_rad).norm(), 1e-7);
    largest_uncorrected_mm =
        std::max(largest_uncorrected_mm, distance_mm(bench::fit_pose(body, seen).X_tracker_body, X_now));
  }
  EXPECT_GT(largest_uncorrected_mm, 0.8);
}

TEST(FitFired, KnownSpeedKeepsFastMarkersFromLookingLikeOutliers)
{
  // 10 m/s and intervals of 1 ms: 10 mm between one marker and the next.
  const bench::RigidBody body = leg_body();
  const bench::Screw twist{{0, 0.5, 0}, {10000, 0, 0}};
  const double gap_s = 0.01, interval_s = 1e-3;
  const Pose X_before(Eigen::Translation3d(0, 0, -1500));
  const Pose X_now = bench::pose_of(bench::scaled(twist, gap_s)) * X_before;
  bench::MarkerRow seen = fired_at(body, X_now, twist, interval_s);
  const bench::Firing firing{.interval_s = interval_s};
  EXPECT_EQ(bench::fit_fired(body, seen, gap_s, bench::BodyMotion{{0.0, X_before}, {}}, firing).fit.status,
            bench::FitStatus::residual_too_large);
  const bench::FiredFit fired =
      bench::fit_fired(body, seen, gap_s, bench::BodyMotion{{0.0, X_before}, twist}, firing);
  ASSERT_EQ(fired.fit.status, bench::FitStatus::fitted);
  EXPECT_TRUE(fired.is_corrected);
  EXPECT_LT(distance_mm(fired.fit.X_tracker_body, X_now), 1e-8);
  // A true outlier is still detected.
  seen[2]->y() += 30.0;
  const bench::FiredFit without =
      bench::fit_fired(body, seen, gap_s, bench::BodyMotion{{0.0, X_before}, twist}, firing);
  EXPECT_EQ(without.fit.n_outliers, 1);
  EXPECT_LT(distance_mm(without.fit.X_tracker_body, X_now), 1e-8);
}

TEST(FitFired, WithoutARecentPoseItIsThePlainFit)
{
  const bench::RigidBody body = leg_body();
  const bench::MarkerRow seen = fired_at(body, Pose::Identity(), {{0, 0, 1}, {100, 0, 0}}, 3e-4);
  const bench::PoseFit plain = bench::fit_pose(body, seen);
  const bench::Firing firing{.interval_s = 3e-4};
  // No previous pose; gap too long; same time; later; shorter than the firing of six markers.
  const auto at = [](double time_s) {
    return std::optional(bench::BodyMotion{{time_s, Pose::Identity()}, {}});
  };
  for (const std::optional<bench::BodyMotion>& before :
       {std::optional<bench::BodyMotion>{}, at(0.7), at(1.0), at(2.0), at(1.0 - 5 * 3e-4)}) {
    const bench::FiredFit fired = bench::fit_fired(body, seen, 1.0, before, firing);
    EXPECT_FALSE(fired.is_corrected);
    EXPECT_EQ(fired.fit.X_tracker_body.matrix(), plain.X_tracker_body.matrix());
  }
}

}  // namespace vrda::body_pose_test
