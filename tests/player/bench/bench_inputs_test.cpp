// Pose of the eyes and effect of the board's inputs.
#include <gtest/gtest.h>

#include "bench/bench_run.hpp"
#include "bench/bench_show.hpp"
#include "bench_samples.hpp"
#include "core/units.hpp"
#include "player/bench/bench_texts.hpp"

namespace vrda::bench_inputs_test {

using test::SmallBench, test::distance_of, test::ms_in_ns, test::some_pose;

constexpr double rounding = 1e-9;
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

TEST(BenchInputs, UsedOnesAreMarkedUntilTheyAreSeen)
{
  SmallBench bench(test::rigid_text());
  const bench::BenchFrame before = bench.state.frame(0);
  EXPECT_TRUE(before.stage.is_used && before.potentiometer.is_used && before.bodies[0].is_used);
  EXPECT_FALSE(before.bodies[1].is_used);
  EXPECT_FALSE(bench::is_live(before));
  bench.state.take(test::stage_sample(0, ms_in_ns));
  bench.state.take(test::potentiometer_sample(0, ms_in_ns));
  bench.state.take(test::place_sample(0, some_pose(1), 0, ms_in_ns));
  const bench::BenchFrame after = bench.state.frame(501 * ms_in_ns);
  EXPECT_TRUE(bench::is_live(after));
  EXPECT_NEAR(after.stage.age_s, 0.5, rounding);
}

}  // namespace vrda::bench_inputs_test
