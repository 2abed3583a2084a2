// Pose of the model: tracked legs, hidden bodies, prediction.
#include <gtest/gtest.h>

#include <cmath>

#include "bench/bench_show.hpp"
#include "core/units.hpp"
#include "player/bench/bench_samples.hpp"
#include "player/bench/bench_texts.hpp"
#include "support/allocation_count.hpp"
#include "support/models.hpp"

namespace vrda::bench_state_test {

using bench::BodyRole, test::SmallBench, test::distance_of, test::ms_in_ns, test::some_pose;

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

// Pose of the eyes and effect of the board's inputs.

constexpr const char* no_zero = "stage not zeroed: press Z at its stop";

TEST(BenchInputs, TheStageMovesTheEyesAlongItsDirectionByItsCounts)
{
  SmallBench bench(test::two_bodies_text());
  const bench::Calibration& c = bench.calibration;
  const Pose X_tracker_table = bench::pose_of(c.X_tracker_table);
  EXPECT_LT(
      distance_of(bench.state.frame(0).X_tracker_eyes, X_tracker_table * bench::pose_of(c.X_table_eyes)),
      rounding);
  for (const int count : {1, 4000, -7001}) {
    bench.state.take(test::stage_sample(count, ms_in_ns, bench::stage_zeroed));
    const bench::BenchFrame& frame = bench.state.frame(ms_in_ns);
    Pose X_table_eyes = bench::pose_of(c.X_table_eyes);
    X_table_eyes.translation() += 0.005 * count * Eigen::Vector3d(0.6, 0.0, 0.8);
    EXPECT_LT(distance_of(frame.X_tracker_eyes, X_tracker_table * X_table_eyes), rounding);
    EXPECT_NEAR(frame.stage_mm, 0.005 * count, rounding);
    EXPECT_TRUE(frame.is_stage_zeroed);
  }
}

TEST(BenchInputs, AStageWhoseBoardRestartedKeepsItsPositionUntilItIsZeroed)
{
  SmallBench bench(test::two_bodies_text());
  const auto at = [&](int count, int flags) {
    bench.state.take(test::stage_sample(count, ms_in_ns, static_cast<std::uint8_t>(flags)));
    return bench.state.frame(ms_in_ns);
  };
  const bench::BenchFrame zeroed = at(4000, bench::stage_zeroed);
  EXPECT_TRUE(zeroed.stage.is_live);
  EXPECT_EQ(bench::stage_status_text(zeroed), "");
  bench.state.take(test::link_sample(bench::DeviceId::board, bench::LinkState::closed, ms_in_ns));
  const bench::BenchFrame silent = bench.state.frame(1001 * ms_in_ns);
  EXPECT_EQ(bench::stage_status_text(silent), "stage silent for 1 s");
  for (const int count : {0, -300, 17}) {
    const bench::BenchFrame restarted = at(count, 0);
    EXPECT_FALSE(restarted.stage.is_live || restarted.is_stage_zeroed);
    EXPECT_EQ(restarted.X_tracker_eyes.matrix(), zeroed.X_tracker_eyes.matrix());
    EXPECT_EQ(restarted.stage_mm, zeroed.stage_mm);
    EXPECT_EQ(bench::stage_status_text(restarted), no_zero);
  }
  const bench::BenchFrame again = at(200, bench::stage_zeroed);
  EXPECT_TRUE(again.stage.is_live);
  EXPECT_NEAR(again.stage_mm, 1.0, rounding);
  EXPECT_EQ(bench::stage_status_text(again), "");
}

TEST(BenchInputs, AStageWithoutZeroOrWithLostCountsIsMarked)
{
  SmallBench bench(test::two_bodies_text());
  EXPECT_EQ(bench::stage_status_text(bench.state.frame(0)), "stage not seen yet");
  for (const auto& [flags, mark] :
       {std::pair<int, std::string>{0, no_zero},
        std::pair<int, std::string>{bench::stage_lost_counts, no_zero},
        std::pair<int, std::string>{bench::stage_zeroed | bench::stage_lost_counts,
                                    "stage has lost counts: press Z at its stop"},
        std::pair<int, std::string>{bench::stage_zeroed, ""}}) {
    bench.state.take(test::stage_sample(100, ms_in_ns, static_cast<std::uint8_t>(flags)));
    const bench::BenchFrame& frame = bench.state.frame(ms_in_ns);
    EXPECT_EQ(bench::stage_status_text(frame), mark);
    // Without zeroing, the counts since the start of the board move the eyes.
    EXPECT_TRUE(frame.stage.is_live);
    EXPECT_NEAR(frame.stage_mm, 0.5, rounding);
  }
}

TEST(BenchInputs, AHeadOnTheTrackerHasThePoseOfItsBody)
{
  SmallBench bench(test::two_bodies_text("tracker"));
  const bench::Calibration& c = bench.calibration;
  // Before the head is seen: on the table.
  EXPECT_LT(distance_of(bench.state.frame(0).X_tracker_eyes,
                        bench::pose_of(c.X_tracker_table) * bench::pose_of(c.X_table_eyes)),
            rounding);
  bench.state.take(test::place_sample(2, some_pose(5), 0, ms_in_ns));
  const bench::BenchFrame& frame = bench.state.frame(ms_in_ns);
  EXPECT_LT(distance_of(frame.X_tracker_eyes, some_pose(5) * bench::pose_of(c.X_headbody_eyes)), rounding);
  EXPECT_TRUE(frame.bodies[3].is_live);
  EXPECT_FALSE(frame.stage.is_used);
}

TEST(BenchInputs, ThePotentiometerSetsAnAngleOverTheMeasuredRange)
{
  SmallBench flexion(test::rigid_text("flexion"));
  flexion.state.take(test::potentiometer_sample(341, ms_in_ns));
  EXPECT_NEAR(deg_from_rad(flexion.state.values().flexion_rad), 30.0, rounding);
  SmallBench varus(test::rigid_text("varus"));
  varus.state.take(test::potentiometer_sample(1023, ms_in_ns));
  EXPECT_NEAR(deg_from_rad(varus.state.values().varus_rad), 4.0, rounding);
  SmallBench selected(test::rigid_text());
  selected.state.select(bench::find_parameter("varus").value());
  selected.state.take(test::potentiometer_sample(0, ms_in_ns));
  EXPECT_NEAR(deg_from_rad(selected.state.values().varus_rad), -4.0, rounding);
}

TEST(BenchInputs, ThePotentiometerMovesAnyOtherParameterByItsSteps)
{
  SmallBench bench(test::rigid_text());
  const std::size_t distance = bench::find_parameter("left.distance").value();
  bench.state.select(distance);
  bench.state.take(test::potentiometer_sample(100, ms_in_ns));
  EXPECT_EQ(bench::value_of(bench.state.values(), distance), 880.0);
  // Half a turn, long enough for the filter: 100 steps of 1 px.
  const auto turn_to = [&](int count, int from) {
    for (int k = 0; k < 500; ++k)
      bench.state.take(test::potentiometer_sample(count, (from + k) * 10 * ms_in_ns));
  };
  turn_to(612, 1);
  EXPECT_EQ(bench::value_of(bench.state.values(), distance), 980.0);
  // For another parameter the potentiometer starts at its current position.
  const std::size_t aspect = bench::find_parameter("left.pixel_aspect").value();
  bench.state.select(aspect);
  turn_to(612, 501);
  EXPECT_EQ(bench::value_of(bench.state.values(), aspect), 1.0);
  turn_to(561, 1001);
  EXPECT_NEAR(bench::value_of(bench.state.values(), aspect), 0.99, rounding);
  EXPECT_EQ(bench::value_of(bench.state.values(), distance), 980.0);
}

TEST(BenchInputs, KeysChangeAnAngleForGoodWhileThePotentiometerRests)
{
  SmallBench bench(test::rigid_text("flexion"));
  int k = 0;
  const auto listen = [&](int count) {
    // The last bit toggles.
    for (int n = 0; n < 500; ++n, ++k)
      bench.state.take(test::potentiometer_sample(count + k % 2, k * 10 * ms_in_ns));
    return deg_from_rad(bench.state.values().flexion_rad);
  };
  constexpr double count_deg = 90.0 / 1023.0;
  EXPECT_NEAR(listen(341), 30.0, count_deg);
  const double before_deg = deg_from_rad(bench.state.values().flexion_rad);
  bench::apply_key(bench.state, {view::Key::right, true});
  EXPECT_NEAR(deg_from_rad(bench.state.values().flexion_rad), before_deg + 10.0, 1e-3);
  EXPECT_NEAR(listen(341), before_deg + 10.0, 1e-3);
  EXPECT_NEAR(listen(682), 60.0, count_deg);
  EXPECT_NEAR(listen(690), 690 * count_deg, count_deg);
}

TEST(BenchInputs, EscapeClosesTheHelpAndQQuits)
{
  SmallBench bench(test::rigid_text("flexion"));
  EXPECT_EQ(bench::apply_key(bench.state, {view::Key::escape}), bench::BenchRequest::close_help);
  EXPECT_EQ(bench::apply_key(bench.state, {view::key_of('Q')}), bench::BenchRequest::quit);
}

/// A bench with a leg 1 m in front of the eyes, and the pointer.
struct Desk {
  explicit Desk(const view::Reflection& reflection = {})
      : bench(test::two_bodies_text()), display(bench.bench.display)
  {
    display.reflection = reflection;
    ball.emplace(display, Eigen::Vector3d(5.0, 3.0, 1.0));
    bench.take_leg(test::some_pose(1), {rad_from_deg(30.0), 0.0, 0.0}, 1, 1);
    frame = bench.state.frame(2);
    // Eyes that look at the joint, upright in its axes.
    Pose X_reference_eyes = Pose::Identity();
    X_reference_eyes.translation() = Eigen::Vector3d(5.0, 3.0, 801.0);
    frame.X_tracker_eyes = frame.X_tracker_reference * X_reference_eyes;
  }
  /// Passes the event to the trackball, and its sample, if any, to the bench.
  void move(view::InputKind kind, double x_px, double y_px,
            view::MouseButton button = view::MouseButton::left)
  {
    view::InputEvent event;
    event.kind = kind;
    event.x_px = x_px;
    event.y_px = y_px;
    event.button = button;
    last = ball->take(event, bench.state, frame, 3);
    if (last) bench.state.take(*last);
  }
  Eigen::Vector2d middle_px() const { return view::middle_px(display.windows.left); }

  test::SmallBench bench;
  bench::DisplaySettings display;
  std::optional<bench::Trackball> ball;
  bench::BenchFrame frame;
  std::optional<bench::Sample> last;
};

TEST(Trackball, TheRightButtonMovesTheJointWithThePointer)
{
  Desk desk;
  const Eigen::Vector2d from = desk.middle_px();
  desk.move(view::InputKind::motion, from.x(), from.y());
  EXPECT_FALSE(desk.last) << "no button";
  desk.move(view::InputKind::press, from.x(), from.y(), view::MouseButton::right);
  desk.move(view::InputKind::motion, from.x() + 88.0, from.y());
  // At the pivot's depth of 800 mm a pixel of the left eye is 800 / distance_px wide.
  const view::Eye& eye = desk.bench.state.values().calibration.eyes.left;
  const double wanted_mm = 88.0 * (800.0 + eye.position_head_mm.z()) / eye.distance_px;
  EXPECT_NEAR(desk.bench.state.X_leg_joint().translation().x(), wanted_mm, 0.01 * wanted_mm);
  EXPECT_NEAR(desk.bench.state.X_leg_joint().translation().z(), 0.0, 1e-6);
  EXPECT_TRUE(desk.bench.state.frame(4).is_moved_aside);
  desk.move(view::InputKind::motion, from.x(), from.y());
  EXPECT_LT(test::distance_of(desk.bench.state.X_leg_joint(), Pose::Identity()), 1e-9) << "back at the press";
  desk.move(view::InputKind::release, from.x(), from.y(), view::MouseButton::right);
  desk.move(view::InputKind::motion, from.x() + 50.0, from.y());
  EXPECT_FALSE(desk.last) << "released";
}

TEST(Trackball, TheLeftButtonTurnsAboutTheCentreAndKeyRPutsBack)
{
  Desk desk;
  const Eigen::Vector2d from = desk.middle_px();
  desk.move(view::InputKind::press, from.x(), from.y());
  desk.move(view::InputKind::motion, from.x() + 60.0, from.y());
  const Pose X = desk.bench.state.X_leg_joint();
  EXPECT_GT(Eigen::AngleAxisd(X.linear()).angle(), rad_from_deg(10.0));
  const Eigen::Vector3d centre(5.0, 3.0, 1.0);
  EXPECT_LT((X * centre - centre).norm(), 1e-6) << "the centre stays";
  bench::apply_key(desk.bench.state, {view::key_of('R')});
  EXPECT_FALSE(desk.bench.state.frame(5).is_moved_aside);
}

TEST(Trackball, BehindAMirrorTheJointFollowsWhatIsSeen)
{
  Desk desk({true, false});
  const Eigen::Vector2d from = desk.middle_px();
  desk.move(view::InputKind::press, from.x(), from.y(), view::MouseButton::right);
  desk.move(view::InputKind::motion, from.x() + 88.0, from.y());
  EXPECT_LT(desk.bench.state.X_leg_joint().translation().x(), -10.0);
}

TEST(Trackball, OutsideTheEyesWindowsNothingIsHeld)
{
  Desk desk;
  desk.move(view::InputKind::press, 3.0, 3.0);
  desk.move(view::InputKind::motion, 300.0, 300.0);
  EXPECT_FALSE(desk.last);
}

class Controls : public testing::Test {
 protected:
  bench::BenchRequest press(view::Key key, bool has_shift = false)
  {
    return bench::apply_key(bench_.state, {key, has_shift, false});
  }
  std::string selected() const { return bench::parameters()[bench_.state.selected()].name; }
  double value(const char* name) const
  {
    return bench::value_of(bench_.state.values(), bench::find_parameter(name).value());
  }

  test::SmallBench bench_{test::rigid_text()};
};

TEST_F(Controls, UpAndDownGoThroughAllThatTheBenchUsesAndAround)
{
  std::vector<std::size_t> used;
  for (std::size_t k = 0; k < bench::parameters().size(); ++k) {
    if (bench::is_used(k, bench_.state.bench())) used.push_back(k);
  }
  ASSERT_EQ(used.front(), bench_.state.selected());
  for (std::size_t k = 1; k <= used.size(); ++k) {
    press(view::Key::down);
    EXPECT_EQ(bench_.state.selected(), used[k % used.size()]);
  }
  press(view::Key::up);
  EXPECT_EQ(bench_.state.selected(), used.back());
}

TEST(ControlsOfATrackedLeg, ItsAnglesCannotBeSelected)
{
  test::SmallBench bench(test::two_bodies_text());
  EXPECT_EQ(bench::parameters()[bench.state.selected()].name, "prediction");
  bench::apply_key(bench.state, {view::key_of('F'), false, false});
  EXPECT_EQ(bench::parameters()[bench.state.selected()].name, "prediction");
  for (const char* name : {"flexion", "varus", "leg.shift_x", "head.turn_y"})
    EXPECT_FALSE(bench::is_used(bench::find_parameter(name).value(), bench.state.bench())) << name;
  for (const char* name : {"femur.turn_x", "tibia.shift_z", "eyes.shift_y", "table.turn_x", "right.k2"})
    EXPECT_TRUE(bench::is_used(bench::find_parameter(name).value(), bench.state.bench())) << name;
}

TEST_F(Controls, WithShiftTheyGoToAnotherKind)
{
  press(view::key_of('I'));
  press(view::Key::down, true);
  EXPECT_EQ(selected(), "image_distance");
  press(view::Key::down, true);
  EXPECT_EQ(selected(), "leg.shift_x");
  press(view::Key::down, true);
  EXPECT_EQ(selected(), "eyes.shift_x");  // neither femur nor tibia are tracked
  press(view::Key::up, true);
  EXPECT_EQ(selected().substr(0, 4), "leg.");
}

TEST_F(Controls, LeftAndRightChangeByStepsAndBackToTheSameValue)
{
  for (std::size_t k = 0; k < bench::parameters().size(); ++k) {
    const bench::Parameter& parameter = bench::parameters()[k];
    SCOPED_TRACE(parameter.name);
    bench_.state.select(k);
    // Away from the ends of the range, so that nothing is clamped.
    bench::set_value(
        bench_.state.values(), k,
        std::round(0.5 * (parameter.minimum + parameter.maximum) / parameter.step) * parameter.step);
    press(view::Key::right);
    press(view::Key::left);
    const double before = bench::value_of(bench_.state.values(), k);
    const auto gained = [&] { return (bench::value_of(bench_.state.values(), k) - before) / parameter.step; };
    press(view::Key::right);
    EXPECT_NEAR(gained(), 1.0, 1e-6);
    press(view::Key::right, true);
    EXPECT_NEAR(gained(), 11.0, 1e-6);
    press(view::Key::left, true);
    press(view::Key::left);
    press(view::Key::left);
    EXPECT_NEAR(gained(), -1.0, 1e-6);
    press(view::Key::right);
    EXPECT_NEAR(gained(), 0.0, 1e-9);
  }
}

TEST_F(Controls, SwitchesPredictionAndFilter)
{
  EXPECT_EQ(value("prediction"), 0.0);
  press(view::key_of('P'));
  EXPECT_EQ(value("prediction"), 30.0);
  press(view::key_of('P'));
  EXPECT_EQ(value("prediction"), 0.0);
  test::SmallBench bench("prediction_ms = 45\n" + test::rigid_text());
  bench::apply_key(bench.state, {view::key_of('P')});
  EXPECT_EQ(bench.state.values().prediction_ms, 0.0);
  bench::apply_key(bench.state, {view::key_of('P')});
  EXPECT_EQ(bench.state.values().prediction_ms, 45.0);
  EXPECT_TRUE(bench_.state.is_filtered());
  press(view::key_of('E'));
  EXPECT_FALSE(bench_.state.is_filtered());
  press(view::key_of('E'));
  EXPECT_TRUE(bench_.state.is_filtered());
}

}  // namespace vrda::bench_state_test
