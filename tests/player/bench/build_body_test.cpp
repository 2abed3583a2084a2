#include <gtest/gtest.h>

#include <limits>

#include "bench/rigid_body.hpp"
#include "player/bench/moves.hpp"
#include "support/refusal.hpp"

namespace vrda::build_body_test {

using test::input_error;
using test::leg_body;
using test::seen_at;

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

}  // namespace vrda::build_body_test
