// Pose of the model: tracked legs, hidden bodies, prediction.
#include <gtest/gtest.h>

#include "bench_samples.hpp"
#include "core/units.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/allocation_count.hpp"
#include "support/models.hpp"

namespace vrda::bench_state_test {

using bench::BodyRole;
using test::SmallBench, test::distance_of, test::ms_in_ns, test::some_pose;

/// Rounding of poses 1 m away, converted to quaternions and six numbers.
constexpr double rounding = 1e-9;

bench::LegAngles angles_at(double flexion_deg, double varus_deg)
{
  return {rad_from_deg(flexion_deg), rad_from_deg(varus_deg), 0.2};
}

void expect_attitude(const bench::BenchFrame& frame, double flexion_deg, double varus_deg,
                     double tolerance_deg)
{
  EXPECT_NEAR(deg_from_rad(frame.pose.attitude.flexion_rad), flexion_deg, tolerance_deg);
  EXPECT_NEAR(deg_from_rad(frame.pose.attitude.varus_rad), varus_deg, tolerance_deg);
}

TEST(BenchState, TwoBodiesAskTheModelAtTheirGroodSuntayAngles)
{
  for (const std::string side : {"right", "left"}) {
    SmallBench bench(test::two_bodies_text(), side);
    std::int64_t now_ns = 0;
    for (const double flexion_deg : {5.0, 37.0, 88.0}) {
      for (const double varus_deg : {-3.0, 0.0, 2.5}) {
        now_ns += 10 * ms_in_ns;
        const Pose X_thigh = some_pose(static_cast<int>(flexion_deg));
        bench.take_leg(X_thigh, angles_at(flexion_deg, varus_deg), now_ns, now_ns);
        const bench::BenchFrame& frame = bench.state.frame(now_ns);
        expect_attitude(frame, flexion_deg, varus_deg, rounding);
        const Pose X_reference = X_thigh * bench.X_body_model(BodyRole::femur);
        const store::JointPose wanted = bench.motion.at({rad_from_deg(flexion_deg), rad_from_deg(varus_deg)});
        EXPECT_LT(distance_of(frame.X_tracker_reference, X_reference), rounding);
        EXPECT_LT(distance_of(frame.X_tracker_moving, X_reference * wanted.X_reference_moving), rounding);
        EXPECT_TRUE(frame.bodies[1].is_live && frame.bodies[2].is_live);
        EXPECT_EQ(frame.n_samples, 2);
        EXPECT_EQ(frame.newest_arrival_ns, now_ns);
      }
    }
  }
}

/// The mark of a leg at these angles; `tibia_first`: the bodies are exchanged.
std::string mark_at(double flexion_deg, double varus_deg, bool is_exchanged = false, double theta_rad = 0.2)
{
  SmallBench bench(test::two_bodies_text());
  const Pose X_thigh = some_pose(1);
  const Pose X_shank =
      bench.X_tracker_shank(X_thigh, {rad_from_deg(flexion_deg), rad_from_deg(varus_deg), theta_rad});
  bench.state.take(test::place_sample(is_exchanged ? 1 : 0, X_thigh, 0, ms_in_ns));
  bench.state.take(test::place_sample(is_exchanged ? 0 : 1, X_shank, 0, ms_in_ns));
  return bench::leg_check_text(bench.state.frame(ms_in_ns).leg);
}

TEST(BenchState, ALegBeyondTheModelIsMarkedWithItsAngles)
{
  // The model: flexion 0 to 90, varus -4 to 4 degrees; within a degree is noise.
  EXPECT_EQ(mark_at(45.0, 2.0), "");
  EXPECT_EQ(mark_at(90.9, -4.9), "");
  EXPECT_EQ(mark_at(120.0, 0.0), "flexion 120, model ends at 90");
  EXPECT_EQ(mark_at(-8.0, 0.0), "flexion -8, model begins at 0");
  EXPECT_EQ(mark_at(30.0, 12.0), "varus 12, model ends at 4");
  EXPECT_EQ(mark_at(120.0, -6.0), "flexion 120, model ends at 90; varus -6, model begins at -4");
  EXPECT_EQ(mark_at(40.0, 0.0, false, rad_from_deg(75.0)),
            "implausible angles: check bodies and calibration; rotation 75");
  EXPECT_EQ(mark_at(60.0, 0.0, true).find("femur and tibia bodies probably exchanged"), 0u);
}

TEST(BenchState, ARigidLegHasThePoseOfItsBodyAndTheAnglesOfTheParameters)
{
  SmallBench bench(test::rigid_text());
  const Pose X_leg = some_pose(3);
  bench.state.take(test::place_sample(0, X_leg, 0, ms_in_ns));
  bench::set_value(bench.state.values(), bench::find_parameter("flexion").value(), 42.0);
  bench::set_value(bench.state.values(), bench::find_parameter("varus").value(), -1.5);
  const bench::BenchFrame& frame = bench.state.frame(ms_in_ns);
  expect_attitude(frame, 42.0, -1.5, rounding);
  EXPECT_LT(distance_of(frame.X_tracker_reference, X_leg * bench.X_body_model(BodyRole::leg)), rounding);
  EXPECT_LT(distance_of(frame.X_tracker_moving, frame.X_tracker_reference * frame.pose.X_reference_moving),
            rounding);
}

TEST(BenchState, AHiddenBodyStaysWhereItWasIsMarkedAndRecovers)
{
  SmallBench bench(test::two_bodies_text());
  bench.state.take(test::stage_sample(0, 0));
  bench.state.take(test::potentiometer_sample(0, 0));
  EXPECT_FALSE(bench.state.frame(0).bodies[2].was_seen);
  bench.take_leg(some_pose(1), angles_at(30, 1), 5, ms_in_ns);
  EXPECT_TRUE(bench::is_live(bench.state.frame(ms_in_ns)));
  // The femur moves, the tibia is hidden: the angles are kept.
  bench.state.take(test::place_sample(0, some_pose(2), 5 + 100 * ms_in_ns, 101 * ms_in_ns));
  bench.state.take(test::hidden_sample(1, 101 * ms_in_ns));
  const bench::BenchFrame hidden = bench.state.frame(301 * ms_in_ns);
  EXPECT_FALSE(bench::is_live(hidden));
  EXPECT_TRUE(hidden.bodies[1].is_live);
  EXPECT_FALSE(hidden.bodies[2].is_live);
  EXPECT_TRUE(hidden.bodies[2].was_seen);
  EXPECT_EQ(hidden.bodies[2].state, bench::ToolVisibility::missing);
  EXPECT_NEAR(hidden.bodies[2].age_s, 0.3, 1e-6);
  expect_attitude(hidden, 30.0, 1.0, rounding);
  EXPECT_LT(distance_of(hidden.X_tracker_reference, some_pose(2) * bench.X_body_model(BodyRole::femur)),
            rounding);
  bench.take_leg(some_pose(2), angles_at(60, -1), 5 + 400 * ms_in_ns, 401 * ms_in_ns);
  const bench::BenchFrame again = bench.state.frame(401 * ms_in_ns);
  EXPECT_TRUE(bench::is_live(again));
  expect_attitude(again, 60.0, -1.0, rounding);
  EXPECT_NEAR(again.bodies[2].age_s, 0.0, 1e-4);
}

TEST(BenchState, AClosedLinkLosesEverythingOfItsDevice)
{
  SmallBench bench(test::two_bodies_text());
  bench.take_leg(some_pose(1), angles_at(30, 1), 5, ms_in_ns);
  bench.state.take(test::stage_sample(100, ms_in_ns));
  bench.state.take(test::potentiometer_sample(100, ms_in_ns));
  bench.state.take(test::link_sample(bench::DeviceId::tracker, bench::LinkState::up, ms_in_ns));
  const bench::BenchFrame live = bench.state.frame(ms_in_ns);
  EXPECT_TRUE(bench::is_live(live));
  bench.state.take(test::link_sample(bench::DeviceId::tracker, bench::LinkState::closed, 2 * ms_in_ns));
  const bench::BenchFrame lost = bench.state.frame(3 * ms_in_ns);
  EXPECT_FALSE(lost.bodies[1].is_live || lost.bodies[2].is_live);
  EXPECT_EQ(lost.bodies[1].state, bench::ToolVisibility::stale);
  EXPECT_TRUE(lost.stage.is_live && lost.potentiometer.is_live);
  EXPECT_EQ(lost.X_tracker_moving.matrix(), live.X_tracker_moving.matrix());
  bench.state.take(test::link_sample(bench::DeviceId::board, bench::LinkState::opening, 3 * ms_in_ns));
  const bench::BenchFrame none = bench.state.frame(4 * ms_in_ns);
  EXPECT_FALSE(none.stage.is_live || none.potentiometer.is_live);
  EXPECT_EQ(none.X_tracker_eyes.matrix(), live.X_tracker_eyes.matrix());
  EXPECT_EQ(none.n_samples, 0);
  EXPECT_EQ(none.newest_arrival_ns, 0);
}

TEST(BenchState, PredictionCarriesAConstantVelocityOnByTheHorizon)
{
  SmallBench bench(test::rigid_text());
  bench.state.values().prediction_ms = 30.0;
  const bench::Screw a_second{{0.5, -0.8, 0.3}, {200.0, -100.0, 50.0}};
  const Pose start = some_pose(5);
  for (int k = 1; k <= 20; ++k) {
    const std::int64_t arrival_ns = k * 10 * ms_in_ns;
    bench.state.take(
        test::place_sample(0, test::moved(start, a_second, 0.01 * k), arrival_ns + 77, arrival_ns));
  }
  // The delay of 4 ms until the frame is also predicted.
  const bench::BenchFrame& frame = bench.state.frame(204 * ms_in_ns);
  const Pose wanted = test::moved(start, a_second, 0.204 + 0.030) * bench.X_body_model(BodyRole::leg);
  EXPECT_LT(distance_of(frame.X_tracker_reference, wanted), 1e-6);
  bench.state.values().prediction_ms = 0.0;
  const Pose held = test::moved(start, a_second, 0.2) * bench.X_body_model(BodyRole::leg);
  EXPECT_LT(distance_of(bench.state.frame(204 * ms_in_ns).X_tracker_reference, held), rounding);
  EXPECT_GT(distance_of(held, wanted), 5.0);
}

TEST(BenchState, MarkersThatAreHiddenLoseTheBodyFromTwoOn)
{
  SmallBench bench(test::bench_head("rigid") + test::display_table + test::tracker_table +
                   "[body.leg]\nmarkers = [\"a\", \"b\", \"c\", \"d\"]\n"
                   "markers_mm = [0, 0, 0, 80, 0, 0, 0, 60, 0, 0, 0, 50]\n");
  const Pose X_leg = some_pose(2);
  const auto is_live_with = [&](int n_seen, std::int64_t arrival_ns) {
    for (std::uint16_t m = 0; m < 4; ++m) {
      Pose marker = Pose::Identity();
      marker.translation() = X_leg * bench.bench.bodies[0]->markers_body_mm[m];
      bench.state.take(m < n_seen ? test::place_sample(m, marker, arrival_ns, arrival_ns)
                                  : test::hidden_sample(m, arrival_ns));
    }
    const bench::BenchFrame& frame = bench.state.frame(arrival_ns);
    EXPECT_LT(distance_of(frame.X_tracker_reference, X_leg * bench.X_body_model(BodyRole::leg)), rounding);
    return frame.bodies[0].is_live;
  };
  EXPECT_TRUE(is_live_with(4, 10 * ms_in_ns));
  EXPECT_TRUE(is_live_with(3, 20 * ms_in_ns));
  EXPECT_FALSE(is_live_with(2, 30 * ms_in_ns));
  EXPECT_FALSE(is_live_with(0, 40 * ms_in_ns));
  EXPECT_TRUE(is_live_with(4, 50 * ms_in_ns));
}

TEST(BenchState, ACellWithoutAnAnswerKeepsTheLastPoseAndSaysSo)
{
  store::MotionModel model = test::bench_model("right");
  test::unsolve(model, 3, 2);
  const store::Motion motion(model, "raw");
  SmallBench bench(test::rigid_text());
  bench::BenchState state(bench.bench, bench.calibration, motion, bench.frame);
  state.values().flexion_rad = rad_from_deg(15.0);
  state.values().varus_rad = 0.0;
  const bench::BenchFrame solved = state.frame(0);
  EXPECT_EQ(solved.pose.status, store::PoseStatus::solved);
  EXPECT_FALSE(solved.is_pose_held);
  state.values().flexion_rad = rad_from_deg(45.0);
  EXPECT_EQ(motion.at({rad_from_deg(45.0), 0.0}).status, store::PoseStatus::unsolved_cell);
  EXPECT_EQ(state.frame(1).X_tracker_moving.matrix(), solved.X_tracker_moving.matrix());
  EXPECT_TRUE(state.frame(2).is_pose_held);
}

/// One second of all inputs, with a gap.
std::vector<bench::BenchFrame> frames_of(SmallBench& bench, long& n_allocations)
{
  std::vector<bench::BenchFrame> frames;
  frames.reserve(60);
  bench.state.values().prediction_ms = 20.0;
  bench.state.set_filter(true);
  for (int k = 1; k <= 60; ++k) {
    const std::int64_t now_ns = k * 16 * ms_in_ns;
    const long before = test::allocations_of_thread();
    bench.take_leg(some_pose(1), angles_at(20 + k, 0.05 * k), now_ns, now_ns);
    if (k % 7 == 0) bench.state.take(test::hidden_sample(1, now_ns));
    bench.state.take(test::place_sample(2, some_pose(k % 3), now_ns, now_ns));
    bench.state.take(test::potentiometer_sample(10 * k, now_ns));
    bench.state.take(test::stage_sample(k, now_ns));
    frames.push_back(bench.state.frame(now_ns));
    n_allocations += test::allocations_of_thread() - before;
  }
  return frames;
}

TEST(BenchState, AllocatesNothingAndTheSameSamplesGiveTheSameFrames)
{
  const std::string text = test::two_bodies_text("tracker");
  SmallBench one(text), other(text);
  long n_allocations = 0;
  const std::vector<bench::BenchFrame> a = frames_of(one, n_allocations), b = frames_of(other, n_allocations);
  EXPECT_EQ(n_allocations, 0);
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].X_tracker_moving.matrix(), b[k].X_tracker_moving.matrix());
    EXPECT_EQ(a[k].X_tracker_reference.matrix(), b[k].X_tracker_reference.matrix());
    EXPECT_EQ(a[k].X_tracker_eyes.matrix(), b[k].X_tracker_eyes.matrix());
    EXPECT_EQ(bench::is_live(a[k]), b[k].bodies[2].is_live);
    EXPECT_EQ(bench::is_live(a[k]), (k + 1) % 7 != 0);
  }
}

}  // namespace vrda::bench_state_test
