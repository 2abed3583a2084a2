// Bodies of markers: what was seen of them, and how well they hold a pose.
#include "bench/measure_body.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "../setup/bench_texts.hpp"
#include "bench_samples.hpp"
#include "core/units.hpp"

namespace vrda::marker_frames_test {

using test::ms_in_ns;

Sample marker_sample(std::uint16_t tool, const Eigen::Vector3d& p_mm, std::int64_t arrival_ns)
{
  Pose marker = Pose::Identity();
  marker.translation() = p_mm;
  return test::place_sample(tool, marker, arrival_ns, arrival_ns);
}

TEST(MarkerFrames, AreTheMessagesAMarkerWasSeenIn)
{
  MarkerFrames heard(2, 3);
  for (int k = 1; k <= 10; ++k) {
    const std::int64_t now_ns = k * 10 * ms_in_ns;
    heard.take(marker_sample(1, {9.0, 9.0, 9.0}, now_ns));  // another body's
    heard.take(marker_sample(2, {1.0 * k, 0.0, 0.0}, now_ns));
    heard.take(k == 4 ? test::hidden_sample(3, now_ns) : marker_sample(3, {0.0, 1.0 * k, 0.0}, now_ns));
    heard.take(test::hidden_sample(4, now_ns));
    heard.take(test::potentiometer_sample(k, now_ns));
  }
  const std::vector<MarkerRow> frames = heard.frames(100);
  ASSERT_EQ(frames.size(), 10U);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    ASSERT_EQ(frames[k].size(), 3U);
    EXPECT_EQ(frames[k][0], Eigen::Vector3d(static_cast<double>(k) + 1.0, 0.0, 0.0));
    EXPECT_EQ(frames[k][1].has_value(), k != 3);
    EXPECT_FALSE(frames[k][2].has_value());
  }
  const std::vector<MarkerRow> some = heard.frames(5);
  ASSERT_EQ(some.size(), 5U);
  EXPECT_EQ(some[4][0], Eigen::Vector3d(9.0, 0.0, 0.0));
}

TEST(MarkerFrames, WithoutAMarkerThereIsNone)
{
  MarkerFrames heard(0, 3);
  for (int k = 1; k <= 10; ++k)
    for (std::uint16_t tool = 0; tool < 3; ++tool) heard.take(test::hidden_sample(tool, k * ms_in_ns));
  EXPECT_TRUE(heard.frames(100).empty());
}

/// Markers at the corners of a square with sides of 2 `half_mm` about the origin.
PoseFit square_fit(double half_mm, double residual_mm)
{
  RigidBody body;
  body.markers_mm.resize(4, 3);
  body.markers_mm << half_mm, half_mm, 0, -half_mm, half_mm, 0, -half_mm, -half_mm, 0, half_mm, -half_mm, 0;
  MarkerRow seen;
  for (Eigen::Index k = 0; k < 4; ++k) seen.emplace_back(body.markers_mm.row(k).transpose());
  PoseFit fit = fit_pose(body, seen);
  fit.residual_rms_mm = residual_mm;
  return fit;
}

TEST(FitWords, QualityIsWhatTheResidualsNoiseMakesOfThePose)
{
  // Lengths of 0.3 mm at four markers leave 12 - 6 numbers: noise of 0.3 sqrt(4 / 6) a coordinate. A turn
  // about an axis in the square's plane is held by the spread along the other one, 2 half.
  const FitQuality quality = quality_of(square_fit(50.0, 0.3));
  const double noise = 0.3 * std::sqrt(4.0 / 6.0);
  EXPECT_EQ(quality.n_markers, 4);
  EXPECT_EQ(quality.residual_mm, 0.3);
  EXPECT_NEAR(quality.turn_sd_deg, deg_from_rad(noise / 100.0), 1e-9);
  EXPECT_NEAR(quality.middle_sd_mm, noise * std::sqrt(3.0 / 4.0), 1e-9);
}

TEST(FitWords, AFitIsToldWithItsResidualAndItsConditioningOrWhyThereIsNone)
{
  EXPECT_EQ(fit_text(square_fit(50.0, 0.3)), "0.3 mm off at 4 markers, turns known to 0.14 deg");
  EXPECT_EQ(fit_text(PoseFit{}), "too few markers");
  PoseFit line;
  line.status = FitStatus::collinear;
  EXPECT_EQ(fit_text(line), "collinear");
}

TEST(BenchState, TellsTheFitOfABodyOfMarkersAlone)
{
  test::SmallBench tools(test::two_bodies_text());
  EXPECT_EQ(tools.state.fit(BodyRole::femur), nullptr);
  EXPECT_EQ(tools.state.fit(BodyRole::head), nullptr);
  test::SmallBench bench(test::bench_head("rigid") + test::display_table + test::tracker_table +
                         "[body.leg]\nmarkers = [\"a\", \"b\", \"c\", \"d\"]\n"
                         "markers_mm = [0, 0, 0, 80, 0, 0, 0, 60, 0, 0, 0, 50]\n");
  ASSERT_NE(bench.state.fit(BodyRole::leg), nullptr);
  EXPECT_EQ(bench.state.fit(BodyRole::leg)->status, FitStatus::too_few_markers);
  for (std::uint16_t m = 0; m < 4; ++m)
    bench.state.take(
        marker_sample(m, test::some_pose(2) * bench.bench.bodies[0]->markers_body_mm[m], ms_in_ns));
  bench.state.frame(ms_in_ns);
  EXPECT_EQ(bench.state.fit(BodyRole::leg)->status, FitStatus::fitted);
  EXPECT_LT(bench.state.fit(BodyRole::leg)->residual_rms_mm, 1e-9);
}

}  // namespace vrda::marker_frames_test
