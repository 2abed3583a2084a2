#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "player/bench/moves.hpp"
#include "support/allocation_count.hpp"
#include "support/refusal.hpp"

namespace vrda::rigid_body_test {

using test::distance_mm, test::leg_body, test::seen_at, test::turn_between_rad;

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

using test::input_error;

/// Remaining error of the iteration: its tolerance times the steps that slow convergence needs.
constexpr double built_mm = 1e-6;

std::vector<bench::MarkerRow> frames_of(const bench::RigidBody& body, int n, std::mt19937_64& random)
{
  std::vector<bench::MarkerRow> frames;
  for (int i = 0; i < n; ++i) frames.push_back(seen_at(body, test::random_pose(random)));
  return frames;
}

/// Distances between markers, which are independent of the frame.
void expect_same_shape(const bench::RigidBody& a, const bench::RigidBody& b, double tolerance_mm)
{
  ASSERT_EQ(a.markers_mm.rows(), b.markers_mm.rows());
  for (Eigen::Index i = 0; i < a.markers_mm.rows(); ++i) {
    for (Eigen::Index j = 0; j < i; ++j) {
      EXPECT_NEAR((a.markers_mm.row(i) - a.markers_mm.row(j)).norm(),
                  (b.markers_mm.row(i) - b.markers_mm.row(j)).norm(), tolerance_mm);
    }
  }
}

TEST(BuildBody, ItsFrameIsTheOneStated)
{
  std::mt19937_64 random(42);
  const Points p = bench::build_body(frames_of(leg_body(), 5, random), "body").body.markers_mm;
  EXPECT_LT(p.colwise().mean().norm(), built_mm);
  const Eigen::Vector3d along = (p.row(1) - p.row(0)).transpose();
  EXPECT_GT(along.x(), 0.0);
  EXPECT_LT(along.tail<2>().norm(), built_mm);
  // The leg's fourth marker, on the shank, is the first that is far from the line of the first two.
  EXPECT_GT(p(3, 1), p(0, 1));
  EXPECT_NEAR(p(3, 2), p(0, 2), built_mm);
}

TEST(BuildBody, IsPutWhereCoordinatesAreGiven)
{
  std::mt19937_64 random(43);
  bench::BodyOptions options;
  options.given_mm = seen_at(leg_body(), Pose::Identity());
  options.given_mm[4].reset();
  const bench::BuiltBody built = bench::build_body(frames_of(leg_body(), 5, random), "body", options);
  EXPECT_LT((built.body.markers_mm - leg_body().markers_mm).norm(), built_mm);
  EXPECT_LT(built.given_rms_mm, built_mm);
  *options.given_mm[0] += Eigen::Vector3d(3, 0, 0);
  EXPECT_GT(bench::build_body(frames_of(leg_body(), 5, random), "body", options).given_rms_mm, 0.3);
}

TEST(BuildBody, GapsAreLeftOut)
{
  // No frame shows more than four of the six markers, some too few.
  std::mt19937_64 random(44);
  std::vector<bench::MarkerRow> frames = frames_of(leg_body(), 60, random);
  std::vector<int> n_seen(6, 0);
  int n_short = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const bool is_short = i % 10 == 9;
    n_short += is_short ? 1 : 0;
    // Every pair in turn; of the short ones four in a row.
    frames[i][i % 6].reset();
    frames[i][(i % 6 + 1 + i / 6 % 5) % 6].reset();
    for (std::size_t hidden = 1; is_short && hidden < 4; ++hidden) frames[i][(i % 6 + hidden) % 6].reset();
    for (std::size_t k = 0; k < 6; ++k) n_seen[k] += !is_short && frames[i][k] ? 1 : 0;
  }
  const bench::BuiltBody built = bench::build_body(frames, "body");
  EXPECT_EQ(built.status, bench::BuildStatus::converged);
  EXPECT_EQ(built.n_refused, n_short);
  EXPECT_EQ(built.n_frames, 60 - n_short);
  expect_same_shape(built.body, leg_body(), built_mm);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(built.markers[k].n_frames, n_seen[k]);
}

TEST(BuildBody, NoiseAveragesOut)
{
  // A coordinate of the mean shape of m frames has a standard deviation of noise / sqrt(m), a distance
  // sqrt(2) times that; five of them, over 15 distances. The residual has 3 n m numbers minus 6 m pose
  // parameters and the shape.
  constexpr int m = 400;
  constexpr double noise = 0.2;
  std::mt19937_64 random(45);
  std::vector<bench::MarkerRow> frames = frames_of(leg_body(), m, random);
  for (bench::MarkerRow& frame : frames) {
    for (auto& p : frame) *p += test::noise_of(random, noise);
  }
  const bench::BuiltBody built = bench::build_body(frames, "body");
  expect_same_shape(built.body, leg_body(), 5.0 * std::sqrt(2.0 / m) * noise);
  const double n_left = 18.0 * m - 6.0 * m - 12.0;
  const double expected_mm = noise * std::sqrt(n_left / (6.0 * m));
  EXPECT_NEAR(built.residual_rms_mm / expected_mm, 1.0, 5.0 / std::sqrt(2.0 * n_left));
}

TEST(BuildBody, MovingEveryFrameChangesNothing)
{
  std::mt19937_64 random(46);
  std::vector<bench::MarkerRow> frames = frames_of(leg_body(), 30, random);
  for (bench::MarkerRow& frame : frames) {
    for (auto& p : frame) *p += test::noise_of(random, 0.3);
  }
  const bench::BuiltBody here = bench::build_body(frames, "body");
  for (bench::MarkerRow& frame : frames) {
    const Pose X = test::random_pose(random);
    for (auto& p : frame) p = X * *p;
  }
  const bench::BuiltBody there = bench::build_body(frames, "body");
  EXPECT_LT((here.body.markers_mm - there.body.markers_mm).norm(), built_mm);
  EXPECT_NEAR(here.residual_rms_mm, there.residual_rms_mm, built_mm);
}

TEST(BuildBody, SaysWhatItCannotUse)
{
  std::mt19937_64 random(47);
  std::vector<bench::MarkerRow> frames = frames_of(leg_body(), 3, random);
  EXPECT_EQ(input_error([] { bench::build_body({}, "body.csv"); }).field, "frames");
  EXPECT_EQ(input_error([] { bench::build_body({bench::MarkerRow(2)}, "body.csv"); }).field, "markers");
  EXPECT_EQ(input_error([] { bench::build_body({bench::MarkerRow(3)}, "body.csv"); }).field, "markers");

  std::vector<bench::MarkerRow> uneven = frames;
  uneven[1].pop_back();
  EXPECT_EQ(input_error([&] { bench::build_body(uneven, "body.csv"); }).field, "frame 2");
  std::vector<bench::MarkerRow> not_finite = frames;
  not_finite[2][0]->x() = std::numeric_limits<double>::infinity();
  EXPECT_EQ(input_error([&] { bench::build_body(not_finite, "body.csv"); }).field, "frame 3");

  bench::RigidBody line = leg_body();
  line.markers_mm.col(0).setZero();
  line.markers_mm.col(2).setZero();
  const InputError::Facts collinear =
      input_error([&] { bench::build_body(frames_of(line, 3, random), "body.csv"); });
  EXPECT_EQ(collinear.file, "body.csv");
  EXPECT_EQ(collinear.found.substr(0, 9), "collinear");

  std::vector<bench::MarkerRow> apart = frames;
  for (bench::MarkerRow& frame : apart) frame[5].reset();
  apart.push_back(frames[0]);
  for (std::size_t k = 2; k < 6; ++k) apart.back()[k].reset();
  apart.back()[5] = frames[0][5];
  EXPECT_THAT(input_error([&] { bench::build_body(apart, "body.csv"); }),
              test::refuses({.field = "marker 6"}));

  bench::RigidBody same = leg_body();
  same.markers_mm.row(1) = same.markers_mm.row(0);
  EXPECT_EQ(input_error([&] { bench::build_body(frames_of(same, 3, random), "body.csv"); }).field,
            "markers 1 and 2");

  bench::BodyOptions options;
  options.given_mm = bench::MarkerRow(6);
  EXPECT_EQ(input_error([&] { bench::build_body(frames, "body.csv", options); }).field, "coordinates wanted");
  options.given_mm.pop_back();
  EXPECT_EQ(input_error([&] { bench::build_body(frames, "body.csv", options); }).field, "coordinates wanted");
}

TEST(BuildBody, AnIterationThatIsCutShortSaysSo)
{
  std::mt19937_64 random(48);
  std::vector<bench::MarkerRow> frames = frames_of(leg_body(), 4, random);
  for (bench::MarkerRow& frame : frames) {
    for (auto& p : frame) *p += test::noise_of(random, 1.0);
  }
  bench::BodyOptions options;
  options.most_iterations = 1;
  EXPECT_EQ(bench::build_body(frames, "body", options).status, bench::BuildStatus::iteration_limit);
}

constexpr double angle_rounding_rad = 1e-14;

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
    expect_equal(bench::leg_angles(X, frame), wanted, angle_rounding_rad);
    const ClinicalCoordinates c = clinical_coordinates(X, frame.side, frame.rotation_centre_mm);
    expect_equal({c.flexion_rad, c.varus_rad, c.internal_rotation_rad}, wanted, angle_rounding_rad);
    frame.delta = (Eigen::Vector3d::UnitY() + test::random_vector(random, 0.4)).normalized();
    expect_equal(bench::leg_angles(bench::X_femur_tibia(wanted, frame), frame), wanted, angle_rounding_rad);
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
                 10 * angle_rounding_rad);
  }
}

/// Rounding of a dozen operations on numbers of 1000 mm.
constexpr double screw_rounding_mm = 5e-12;
constexpr double screw_rounding_rad = 2e-15;

TEST(Screw, AQuarterTurnAboutALineIsTheClosedForm)
{
  // About the line through (10, 0, 0) along Z, rising by 8 mm: turn = pi/2 z, shift = -turn x point + rise.
  const Eigen::Vector3d turn(0, 0, pi / 2), point(10, 0, 0), rise(0, 0, 8);
  const Pose X = bench::pose_of(bench::Screw{turn, rise - turn.cross(point)});
  EXPECT_LT((X * Eigen::Vector3d(13, 0, 0) - Eigen::Vector3d(10, 3, 8)).norm(), screw_rounding_mm);
  EXPECT_LT((X * Eigen::Vector3d(10, 0, 5) - Eigen::Vector3d(10, 0, 13)).norm(), screw_rounding_mm);
}

TEST(Screw, LogarithmAndExponentialUndoEachOther)
{
  std::mt19937_64 random(11);
  // Both sides of each bound between a series and the closed form, up to half a turn.
  for (const double angle_rad :
       {0.0, 1e-12, 1e-8, 0.99e-4, 1.01e-4, 1e-3, 0.0999, 0.1001, 1.0, 3.0, pi - 1e-9}) {
    SCOPED_TRACE(angle_rad);
    for (int i = 0; i < 50; ++i) {
      const bench::Screw screw{angle_rad * test::random_vector(random, 1.0).normalized(),
                               test::random_vector(random, 1000.0)};
      const bench::Screw back = bench::screw_of(bench::pose_of(screw));
      EXPECT_LT((back.turn_rad - screw.turn_rad).norm(), 10 * screw_rounding_rad);
      EXPECT_LT((back.shift_mm - screw.shift_mm).norm(), 10 * screw_rounding_mm);
    }
  }
}

TEST(Screw, MidwayIsTheHelicalAxisOfCore)
{
  std::mt19937_64 random(13);
  for (int i = 0; i < 100; ++i) {
    const Pose start = test::random_pose(random), end = test::random_pose(random);
    const Pose midway = bench::between(start, end, 0.5);
    EXPECT_LT((midway.linear() - midpoint_orientation(start, end)).norm(), 1e-12);
    // The remaining motion is along the same screw.
    const Pose X_done = start.inverse() * midway, X_left = midway.inverse() * end;
    EXPECT_LT((X_done.matrix() - X_left.matrix()).norm(), 1e-9);
    EXPECT_LT(test::distance_mm(bench::between(start, end, 1.0), end), 1e-9);
  }
}

}  // namespace vrda::rigid_body_test
