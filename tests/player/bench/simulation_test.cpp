#include "bench/simulation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "support/models.hpp"
#include "support/refusal.hpp"

namespace vrda::simulation_test {

constexpr double rounding_mm = 1e-9;
constexpr double rounding_rad = 1e-12;

bench::SimulationScript exact_script()
{
  bench::SimulationScript script;
  script.noise_mm = script.noise_rad = script.drop_rate = script.jitter_ms =
      script.potentiometer_noise_counts = 0.0;
  script.occlusions.clear();
  return script;
}

bool is_equal(const bench::SimulatedFrame& a, const bench::SimulatedFrame& b)
{
  bool is_same = a.time_s == b.time_s && a.send_s == b.send_s && a.device_ns == b.device_ns &&
                 a.is_dropped == b.is_dropped && a.tools.size() == b.tools.size();
  for (std::size_t i = 0; is_same && i < a.tools.size(); ++i) {
    is_same = a.tools[i].is_seen == b.tools[i].is_seen &&
              a.tools[i].X_tracker_tool.matrix() == b.tools[i].X_tracker_tool.matrix();
  }
  return is_same;
}

TEST(Simulation, AFrameDoesNotDependOnTheOrderOfCalls)
{
  const bench::Simulation forwards{bench::SimulationScript{}}, backwards{bench::SimulationScript{}};
  bench::SimulationScript other_seed;
  other_seed.seed = 2;
  const bench::Simulation other{other_seed};
  std::vector<bench::SimulatedFrame> frames;
  for (std::uint64_t k = 0; k < 300; ++k) frames.push_back(forwards.frame(k));
  for (std::uint64_t k = 300; k-- > 0;) {
    EXPECT_TRUE(is_equal(backwards.frame(k), frames[k]));
    EXPECT_FALSE(is_equal(other.frame(k), frames[k]));
  }
}

test::ModelPlan turning_plan(const std::string& side)
{
  test::ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {10, -20, 30};
  plan.motion = [](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{0.05 * flexion_deg, -18.0 + 0.1 * varus_deg, 0.02 * flexion_deg,
                                  0.2 * flexion_deg};
  };
  return plan;
}

TEST(Simulation, TheTibiaFollowsTheMotionOnBothSides)
{
  for (const std::string side : {"right", "left"}) {
    const store::MotionModel model = test::model_of(turning_plan(side));
    const store::Motion motion(model, "raw");
    bench::SimulationScript script = exact_script();
    script.side = side == "left" ? Side::left : Side::right;
    const bench::Simulation simulation(script, motion);
    const SolverFrame frame{script.side, model.rotation_centre_mm, model.delta};
    std::vector<bench::PathPoint> keys;
    for (const bench::LegKey& key : script.leg) keys.push_back({key.time_s, rad_from_deg(key.flexion_deg)});
    const bench::KeyPath flexion_rad(keys, true);
    double largest_theta_rad = 0.0;
    for (double time_s = 0.0; time_s < 8.0; time_s += 0.13) {
      const bench::SimulatedTruth truth = simulation.truth(time_s);
      // From key to key the angles follow their paths.
      EXPECT_NEAR(truth.angles.flexion_rad, flexion_rad.at(time_s), rounding_rad);
      const store::JointPose joint = motion.at(bench::attitude_of(truth.angles));
      EXPECT_LT((truth.X_femur_tibia.matrix() - joint.X_reference_moving.matrix()).norm(), rounding_mm);
      const bench::LegAngles angles = bench::leg_angles(truth.X_femur_tibia, frame);
      EXPECT_NEAR(angles.flexion_rad, truth.angles.flexion_rad, rounding_rad);
      EXPECT_NEAR(angles.varus_rad, truth.angles.varus_rad, rounding_rad);
      EXPECT_NEAR(angles.theta_rad, truth.angles.theta_rad, rounding_rad);
      largest_theta_rad = std::max(largest_theta_rad, angles.theta_rad);
    }
    EXPECT_GT(largest_theta_rad, rad_from_deg(10.0));
  }
}

TEST(Simulation, AScriptThatLeavesTheSolvedMotionIsRefused)
{
  store::MotionModel model = test::model_of({});
  test::unsolve(model, 3, 2);
  EXPECT_THAT(
      test::input_error([&] { bench::Simulation simulation({}, store::Motion(model, "raw"), "bench.toml"); }),
      test::refuses({"bench.toml", "leg"}));
}

TEST(Simulation, AScriptBeyondTheMotionIsReportedWithTheMotionsRange)
{
  struct Row {
    std::vector<double> flexion_deg, varus_deg;
    std::function<double(double)> free_varus_deg;
    const char* found;
    const char* wanted;
  };
  // The script bends to 90 degrees by way of 45 with a varus of 2.
  const std::vector<Row> rows{
      {{0, 45, 90}, {-2, 0, 2}, {}, nullptr, nullptr},
      {{0, 45}, {-2, 0, 2}, {}, "flexion 45", "flexion 0 to 45 degrees, varus -2 to 2 degrees"},
      {{0, 45, 90}, {-1, 0, 1}, {}, "varus 1", "flexion 0 to 90 degrees, varus -1 to 1 degrees"},
      {{0, 45, 90}, {0}, [](double) { return 0.5; }, nullptr, nullptr},
  };
  for (const Row& row : rows) {
    test::ModelPlan plan;
    plan.flexion_deg = row.flexion_deg;
    plan.varus_deg = row.varus_deg;
    plan.free_varus_deg = row.free_varus_deg;
    const bench::Simulation simulation({}, store::Motion(test::model_of(plan), "raw"), "bench.toml");
    const std::optional<InputError::Facts> beyond = simulation.beyond_motion("bench.toml");
    ASSERT_EQ(beyond.has_value(), row.found != nullptr);
    if (!beyond) continue;
    EXPECT_EQ(beyond->field, "leg");
    EXPECT_THAT(beyond->found, testing::HasSubstr(row.found));
    EXPECT_THAT(beyond->wanted, testing::HasSubstr(row.wanted));
  }
  EXPECT_FALSE(bench::Simulation(exact_script()).beyond_motion("bench.toml"));
}

TEST(Simulation, BodiesSitOnTheirBonesAndTheHeadOnTheStage)
{
  bench::SimulationScript script = exact_script();
  script.head = bench::SimulatedBody{"head", {}};
  script.X_tracker_head = bench::pose_of(bench::Screw{{0.1, 0.2, 0.3}, {0, 400, 200}});
  const bench::Simulation simulation{script};
  for (std::uint64_t k = 0; k < 1000; k += 37) {
    const bench::SimulatedFrame frame = simulation.frame(k);
    const bench::SimulatedTruth truth = simulation.truth(frame.time_s);
    ASSERT_EQ(frame.tools.size(), 3U);
    EXPECT_LT((frame.tools[0].X_tracker_tool.matrix() - truth.X_tracker_femur.matrix()).norm(), rounding_mm);
    EXPECT_LT((frame.tools[1].X_tracker_tool.matrix() - truth.X_tracker_tibia.matrix()).norm(), rounding_mm);
    const Pose X_stage = script.X_tracker_head.inverse() * frame.tools[2].X_tracker_tool;
    EXPECT_LT((X_stage.translation() - Eigen::Vector3d(truth.stage_mm, 0, 0)).norm(), rounding_mm);
  }
}

TEST(Simulation, MarkersFireOneAfterAnother)
{
  bench::SimulationScript script = exact_script();
  script.tibia.markers_mm = {{0, -200, 0}, {30, -250, 0}, {0, -300, 40}};
  script.firing_interval_ms = 3.0;
  const bench::Simulation simulation{script};
  EXPECT_EQ(simulation.tools()[4], "tibia-3");
  const bench::SimulatedFrame frame = simulation.frame(130);
  for (std::size_t k = 0; k < 3; ++k) {
    const bench::SimulatedTruth then = simulation.truth(frame.time_s + 0.003 * static_cast<double>(k));
    EXPECT_LT(
        (frame.tools[2 + k].X_tracker_tool.translation() - then.X_tracker_tibia * script.tibia.markers_mm[k])
            .norm(),
        rounding_mm);
  }
  const Eigen::Vector3d at_tick = simulation.truth(frame.time_s).X_tracker_tibia * script.tibia.markers_mm[2];
  EXPECT_GT((frame.tools[4].X_tracker_tool.translation() - at_tick).norm(), 0.5);
}

TEST(Simulation, NoiseHasTheRequestedDeviation)
{
  // Mean squares of 3 n numbers whose fourth moment is below 3: five standard errors.
  bench::SimulationScript script = exact_script();
  script.noise_mm = 0.3;
  script.noise_rad = rad_from_deg(0.1);
  const bench::Simulation simulation{script};
  constexpr int n = 3000;
  double square_mm2 = 0.0, square_rad2 = 0.0;
  for (std::uint64_t k = 0; k < n; ++k) {
    const bench::SimulatedFrame frame = simulation.frame(k);
    const Pose X_truth = simulation.truth(frame.time_s).X_tracker_femur;
    const Pose& X = frame.tools[0].X_tracker_tool;
    square_mm2 += (X.translation() - X_truth.translation()).squaredNorm() / (3 * n);
    square_rad2 += bench::turn_of(X_truth.linear().transpose() * X.linear()).squaredNorm() / (3 * n);
  }
  const double bound = 5.0 * std::sqrt(2.0 / (3 * n));
  EXPECT_NEAR(square_mm2 / (0.3 * 0.3), 1.0, bound);
  EXPECT_NEAR(square_rad2 / (rad_from_deg(0.1) * rad_from_deg(0.1)), 1.0, bound);
}

TEST(Simulation, JitterAndDropsHaveTheirShare)
{
  bench::SimulationScript script;
  script.drop_rate = 0.1;
  const bench::Simulation simulation{script};
  constexpr int n = 4000;
  int n_dropped = 0;
  std::vector<double> jitters_s;
  for (std::uint64_t k = 0; k < n; ++k) {
    const bench::SimulatedFrame frame = simulation.frame(k);
    EXPECT_EQ(frame.time_s, static_cast<double>(k) / 100.0);
    n_dropped += frame.is_dropped ? 1 : 0;
    jitters_s.push_back(frame.send_s - frame.time_s);
  }
  EXPECT_NEAR(n_dropped, 0.1 * n, 5.0 * std::sqrt(0.1 * 0.9 * n));
  // Uniform from 0 to 2 ms.
  EXPECT_NEAR(std::reduce(jitters_s.begin(), jitters_s.end()) / n, 0.001, 5.0 * 0.002 / std::sqrt(12.0 * n));
  const auto [least, most] = std::ranges::minmax(jitters_s);
  EXPECT_GE(least, 0.0);
  EXPECT_LT(least, 1e-5);
  EXPECT_LT(most, 0.002);
  EXPECT_GT(most, 0.00199);
}

TEST(Simulation, OcclusionsHideBodiesWithTheirMarkersAndChangeNoOther)
{
  bench::SimulationScript script;
  script.tibia.markers_mm.resize(2);
  script.occlusions = {{"tibia", 1.0, 2.0, 4.0}, {"tibia-2", 2.5, 3.0, 0.0}};
  bench::SimulationScript open = script;
  open.occlusions.clear();
  const bench::Simulation simulation{script}, always{open};
  for (std::uint64_t k = 0; k < 1000; ++k) {
    SCOPED_TRACE(k);
    bench::SimulatedFrame frame = simulation.frame(k);
    const std::uint64_t in_period = k % 400;
    const bool is_hidden = in_period >= 100 && in_period < 200;
    EXPECT_TRUE(frame.tools[0].is_seen);
    EXPECT_EQ(frame.tools[1].is_seen, !is_hidden);
    EXPECT_EQ(frame.tools[2].is_seen, !is_hidden);
    // The second marker fires shortly after the tick.
    EXPECT_EQ(frame.tools[3].is_seen, !is_hidden && !(k >= 250 && k < 300));
    for (bench::SimulatedTool& tool : frame.tools) tool.is_seen = true;
    EXPECT_TRUE(is_equal(frame, always.frame(k)));
  }
}

TEST(Simulation, TheDeviceClockDriftsAndSteps)
{
  bench::SimulationScript script = exact_script();
  script.clock = {1.5e9, 100.0, {{2.0, -500.0}, {3.0, 250.0}}};
  const bench::Simulation simulation{script};
  const std::int64_t begin_ns = 1'500'000'000'000'000'000;
  EXPECT_EQ(simulation.device_ns(0.0), begin_ns);
  EXPECT_EQ(simulation.device_ns(1.0) - begin_ns, 1'000'100'000);
  EXPECT_EQ(simulation.device_ns(2.0) - begin_ns, 2'000'200'000 - 500'000'000);
  EXPECT_EQ(simulation.device_ns(3.0) - begin_ns, 3'000'300'000 - 250'000'000);
  EXPECT_LT(simulation.device_ns(2.0), simulation.device_ns(1.99));
  EXPECT_EQ(simulation.frame(300).device_ns, simulation.device_ns(3.0));
}

TEST(Simulation, TheBoardCountsToTheNearestStepWithinItsRange)
{
  bench::SimulationScript script = exact_script();
  EXPECT_EQ(bench::Simulation{script}.potentiometer_count(4.0), 900);
  script.stage = {{0, -3}, {2.5, 25}, {7.5, -25}, {10, -3}};
  script.potentiometer = {{0, 2}};
  script.potentiometer_noise_counts = 3.0;
  const bench::Simulation noisy{script};
  int n_zero = 0, n_high = 0;
  for (int i = 0; i < 2000; ++i) {
    const double time_s = 0.005 * i;
    EXPECT_NEAR(static_cast<double>(noisy.stage_count(time_s)) * bench::stage_mm_a_count,
                noisy.truth(time_s).stage_mm, 0.5 * bench::stage_mm_a_count + rounding_mm);
    const int count = noisy.potentiometer_count(time_s);
    ASSERT_GE(count, 0);
    ASSERT_LE(count, 20);  // 2 and six standard deviations
    n_zero += count == 0 ? 1 : 0;
    n_high += count > 5 ? 1 : 0;
  }
  EXPECT_GT(n_zero, 400);
  EXPECT_GT(n_high, 150);
}

// Scripts and their paths.

constexpr double rounding = 1e-12;

TEST(KeyPath, BetweenTurningPointsIsTheSmoothStep)
{
  const bench::KeyPath path({{0, 0}, {4, 90}, {8, 0}}, true);
  for (int i = 0; i <= 40; ++i) {
    const double s = i / 40.0, expected = 90.0 * s * s * (3.0 - 2.0 * s);
    EXPECT_NEAR(path.at(4.0 * s), expected, 90 * rounding);
    EXPECT_NEAR(path.at(8.0 - 4.0 * s), expected, 90 * rounding);
    EXPECT_NEAR(path.at(4.0 * s + 8.0 * 1000), expected, 1e-8);
    EXPECT_NEAR(path.at(4.0 * s - 8.0), expected, 90 * rounding);
  }
}

TEST(KeyPath, NeverLeavesTheRangeBetweenTwoKeysAndHasNoCorner)
{
  const std::vector<bench::PathPoint> keys = {{0, 0}, {1, 45}, {1.2, 46}, {4, 90}, {6, 45}, {8, 0}};
  const bench::KeyPath path(keys, true);
  constexpr double step_s = 1e-3;
  double slope_before = (path.at(step_s) - path.at(0.0)) / step_s;
  int n_inside = 0;
  for (int i = 1; i < 8000; ++i) {
    const double t = i * step_s;
    const auto after = std::find_if(keys.begin() + 1, keys.end(),
                                    [&](const bench::PathPoint& key) { return key.time_s >= t; });
    const double from = (after - 1)->value, to = after->value;
    EXPECT_GE(path.at(t), std::min(from, to) - rounding * 100);
    EXPECT_LE(path.at(t), std::max(from, to) + rounding * 100);
    n_inside += path.at(t) != from && path.at(t) != to ? 1 : 0;
    // Slopes of up to 70 per second change within 0.2 s at the fastest: by less than 4 in a step with the
    // cubic's 6 (b - a) / length^2.
    const double slope = (path.at(t + step_s) - path.at(t)) / step_s;
    EXPECT_LT(std::abs(slope - slope_before), 4.0);
    slope_before = slope;
  }
  EXPECT_GT(n_inside, 7900);
}

}  // namespace vrda::simulation_test
