/// The simulated leg processed by the room tracking, as in a bench session.
#include <gtest/gtest.h>

#include "bench/motion_filter.hpp"
#include "bench/rigid_body.hpp"
#include "bench/simulation.hpp"
#include "core/units.hpp"

namespace vrda::tracked_leg_test {

const SolverFrame right_leg{Side::right, Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitY()};

std::vector<Eigen::Vector3d> shank_markers()
{
  return {{40, -100, 0}, {-30, -120, 45}, {20, -260, -35}, {-35, -280, 10}, {30, -330, 40}, {0, -200, 60}};
}

bench::MarkerRow markers_of(const bench::SimulatedFrame& frame, std::size_t first, std::size_t n)
{
  bench::MarkerRow row(n);
  for (std::size_t k = 0; k < n; ++k) {
    const bench::SimulatedTool& tool = frame.tools[first + k];
    if (tool.is_seen) row[k] = tool.X_tracker_tool.translation();
  }
  return row;
}

TEST(TrackedLeg, AnglesFromNoisyBodiesStayWithinTheirNoise)
{
  // Each body's rotation about each axis has a standard deviation of 0.03 degrees, their difference sqrt(2)
  // of it; a tilted axis adds at most a factor 1 / cos(2 degrees). The relative spread of the mean square
  // over n frames is sqrt(2 / n).
  bench::SimulationScript script;
  script.occlusions.clear();
  const bench::Simulation simulation{script};
  constexpr int n = 800;
  double square_rad2 = 0.0;
  for (std::uint64_t k = 0; k < n; ++k) {
    const bench::SimulatedFrame frame = simulation.frame(k);
    const Pose X = bench::X_femur_tibia(bench::LegBodies{}, frame.tools[0].X_tracker_tool,
                                        frame.tools[1].X_tracker_tool);
    const double off =
        bench::leg_angles(X, right_leg).flexion_rad - simulation.truth(frame.time_s).angles.flexion_rad;
    square_rad2 += off * off / n;
  }
  const double expected = 2.0 * rad_from_deg(0.03) * rad_from_deg(0.03);
  EXPECT_NEAR(square_rad2 / expected, 1.0, 5.0 * std::sqrt(2.0 / n) + 2e-3);
}

TEST(TrackedLeg, ABodyIsBuiltFromTheMarkersOfARun)
{
  bench::SimulationScript script;
  script.noise_mm = 0.1;
  script.firing_interval_ms = 0.0;
  script.tibia.markers_mm = shank_markers();
  script.occlusions = {{"tibia-2", 0.0, 4.0, 0.0}, {"tibia-5", 3.0, 8.0, 0.0}, {"tibia", 5.0, 6.0, 0.0}};
  const bench::Simulation simulation{script};
  std::vector<bench::MarkerRow> frames;
  for (std::uint64_t k = 0; k < 800; k += 4) frames.push_back(markers_of(simulation.frame(k), 2, 6));
  bench::BodyOptions options;
  for (const Eigen::Vector3d& p : shank_markers()) options.given_mm.emplace_back(p);
  const bench::BuiltBody built = bench::build_body(frames, "tibia", options);
  EXPECT_EQ(built.status, bench::BuildStatus::converged);
  EXPECT_EQ(built.n_refused, 25);
  // 75 frames or more show each marker: its mean has a standard deviation of 0.1 / sqrt(75) per coordinate,
  // and the fitted frame no more; five of both.
  const std::vector<Eigen::Vector3d> wanted = shank_markers();
  for (std::size_t k = 0; k < 6; ++k) {
    EXPECT_GE(built.markers[k].n_frames, 75);
    const Eigen::Vector3d p = built.body.markers_mm.row(static_cast<Eigen::Index>(k)).transpose();
    EXPECT_LT((p - wanted[k]).norm(), 5.0 * std::sqrt(2.0 * 3.0 / 75) * 0.1);
  }
}

TEST(TrackedLeg, FiringInTurnIsCorrectedOnAMovingShank)
{
  bench::SimulationScript script;
  script.noise_mm = script.noise_rad = 0.0;
  script.firing_interval_ms = 1.0;
  script.tibia.markers_mm = shank_markers();
  script.occlusions.clear();
  const bench::Simulation simulation{script};
  bench::RigidBody body;
  body.markers_mm.resize(6, 3);
  for (Eigen::Index k = 0; k < 6; ++k)
    body.markers_mm.row(k) = shank_markers()[static_cast<std::size_t>(k)].transpose();
  const Eigen::Vector3d middle_mm = body.markers_mm.colwise().mean().transpose();
  double worst_plain_mm = 0.0, worst_corrected_mm = 0.0;
  std::optional<bench::BodyMotion> before;
  for (std::uint64_t k = 0; k < 800; ++k) {
    const bench::SimulatedFrame frame = simulation.frame(k);
    const bench::MarkerRow seen = markers_of(frame, 2, 6);
    const bench::FiredFit fired = bench::fit_fired(body, seen, frame.time_s, before, {.interval_s = 1e-3});
    ASSERT_EQ(fired.fit.status, bench::FitStatus::fitted);
    const Eigen::Vector3d truth_mm = simulation.truth(frame.time_s).X_tracker_tibia * middle_mm;
    worst_plain_mm =
        std::max(worst_plain_mm, (bench::fit_pose(body, seen).X_tracker_body * middle_mm - truth_mm).norm());
    if (k > 10) {
      worst_corrected_mm =
          std::max(worst_corrected_mm, (fired.fit.X_tracker_body * middle_mm - truth_mm).norm());
    }
    before = bench::BodyMotion{{frame.time_s, fired.fit.X_tracker_body}, fired.velocity};
  }
  // The shank's centre, 215 mm from the knee, moves at up to 23 to 30 degrees/s; mean delay 2.5 ms.
  EXPECT_GT(worst_plain_mm, 0.8 * rad_from_deg(25.0) * 215.0 * 0.0025);
  // The remaining error is due to acceleration: a twist taken (T + wait) / 2 too early, 0.5 a (T + wait)
  // wait with a = 6 * 45 deg / 4 s^2 * 215 mm. Deviations from the mean delay contribute the same again.
  const double acceleration = rad_from_deg(6.0 * 45.0 / 4.0) * 215.0;
  EXPECT_LT(worst_corrected_mm, acceleration * (0.01 + 0.005) * 0.005);
  EXPECT_LT(worst_corrected_mm, 0.1 * worst_plain_mm);
}

TEST(TrackedLeg, PredictionHelpsAtTheBenchsLatency)
{
  bench::SimulationScript script;
  script.occlusions.clear();
  const bench::Simulation simulation{script};
  std::vector<bench::TimedPose> places;
  for (std::uint64_t k = 0; k < 1600; ++k) {
    const bench::SimulatedFrame frame = simulation.frame(k);
    if (frame.is_dropped) continue;
    places.push_back({frame.time_s, frame.tools[1].X_tracker_tool});
  }
  EXPECT_LT(places.size(), 1600U);
  const bench::PosePredictionError place = bench::prediction_error(places, 0.033);
  EXPECT_LT(place.turn_rad.predicted.rms, 0.4 * place.turn_rad.held.rms);
}

TEST(TrackedLeg, TheFilterLagsByItsDelayAndTakesNoiseAway)
{
  bench::SimulationScript script;
  script.occlusions.clear();
  script.drop_rate = 0.0;
  // Constant flexion rate from 1 to 3 s.
  script.is_looped = false;
  script.leg = {{0, 0, 0}, {1, 20, 0}, {2, 40, 0}, {3, 60, 0}, {4, 80, 0}};
  const bench::Simulation simulation{script};
  bench::OneEuroAngles filter;
  double raw_sq = 0.0, filtered_sq = 0.0, lag_sum = 0.0;
  constexpr int n = 100;
  const double speed_rad_s = rad_from_deg(20.0),
               delay_s = 1.0 / (2.0 * pi * (1.5 + 18.0 * speed_rad_s));  // of the default filter
  for (std::uint64_t k = 0; k < 300; ++k) {
    const bench::SimulatedFrame frame = simulation.frame(k);
    const Pose X = bench::X_femur_tibia(bench::LegBodies{}, frame.tools[0].X_tracker_tool,
                                        frame.tools[1].X_tracker_tool);
    const bench::LegAngles raw = bench::leg_angles(X, right_leg),
                           filtered = filter.filtered(raw, frame.time_s);
    const double truth = simulation.truth(frame.time_s).angles.flexion_rad;
    const double is_counted = k >= 200 ? 1.0 / n : 0.0;
    raw_sq += is_counted * (raw.flexion_rad - truth) * (raw.flexion_rad - truth);
    const double off = filtered.flexion_rad - (truth - speed_rad_s * delay_s);
    filtered_sq += is_counted * off * off;
    lag_sum += is_counted * (truth - filtered.flexion_rad);
  }
  // The cutoff follows the noise of the speed: within a tenth.
  EXPECT_NEAR(lag_sum / speed_rad_s / delay_s, 1.0, 0.1);
  EXPECT_LT(filtered_sq, 0.5 * raw_sq);
}

}  // namespace vrda::tracked_leg_test
