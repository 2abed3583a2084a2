#include "bench/bench_run.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bench_samples.hpp"
#include "player/bench/sample_recording.hpp"

namespace vrda::replay_state_test {

using test::ms_in_ns;

constexpr std::size_t n_frames = 8600;  // 143 s, longer than the run-up
constexpr std::size_t hidden_from = 600, turned_at = 300;

/// A moving femur with arrival jitter; a tibia that is hidden early and stays so; a potentiometer and keys
/// that change parameters at the beginning only; a lost and found board.
std::string recorded(const test::SmallBench& bench)
{
  std::vector<bench::RecordedFrame> frames;
  for (std::size_t k = 0; k < n_frames; ++k) {
    const auto now_ns = static_cast<std::int64_t>(k + 1) * 16'666'667;
    const std::int64_t arrival_ns = now_ns - static_cast<std::int64_t>(1 + k * 7919 % 5) * ms_in_ns;
    const std::int64_t device_ns = now_ns - 8 * ms_in_ns + 3'600'000 * ms_in_ns;
    const double flexion_rad = 0.7 + 0.3 * std::sin(0.01 * static_cast<double>(k));
    const Pose X_thigh = test::moved(test::some_pose(2), {{0.02, 0.01, 0.0}, {5.0, 0.0, 1.0}},
                                     1e-9 * 1.0 * static_cast<double>(now_ns));
    bench::RecordedFrame& frame = frames.emplace_back();
    frame.now_ns = now_ns;
    std::vector<bench::Sample>& samples = frame.samples;
    samples.push_back(test::place_sample(0, X_thigh, device_ns, arrival_ns));
    samples.push_back(k < hidden_from
                          ? test::place_sample(1, bench.X_tracker_shank(X_thigh, {flexion_rad, 0.02, 0.1}),
                                               device_ns, arrival_ns)
                          : test::hidden_sample(1, arrival_ns));
    if (k < 2 * turned_at)
      samples.push_back(test::potentiometer_sample(k < turned_at ? 300 : 700, arrival_ns));
    if (k == 100 || k == 400)
      samples.push_back(test::link_sample(
          bench::DeviceId::board, k == 100 ? bench::LinkState::closed : bench::LinkState::up, arrival_ns));
    if (k == 50) frame.keys.assign(3, {view::Key::right});
  }
  return test::recording_bytes({}, frames);
}

TEST(ReplayState, AJumpShowsTheFrameOfTheSession)
{
  const test::SmallBench small(test::two_bodies_text());
  const bench::BenchSetup setup{small.model, small.motion, small.frame, small.bench, small.calibration, {}};
  const std::string bytes = recorded(small);
  bench::RecordingReader reader = test::reader_of(bytes);
  bench::ReplayState played(setup, reader);
  for (std::size_t k = 0; k + 200 < n_frames; ++k) played.at(k);
  bench::ReplayState jumped(setup, reader);
  jumped.at(10);
  for (const std::size_t k : {n_frames - 200, n_frames - 1, n_frames - 2}) {
    SCOPED_TRACE(k);
    const bench::BenchFrame a = played.at(k), b = jumped.at(k);
    EXPECT_EQ(a.X_tracker_reference.matrix(), b.X_tracker_reference.matrix());
    EXPECT_EQ(a.X_tracker_moving.matrix(), b.X_tracker_moving.matrix());
    EXPECT_EQ(a.X_tracker_eyes.matrix(), b.X_tracker_eyes.matrix());
    EXPECT_EQ(a.pose.attitude.flexion_rad, b.pose.attitude.flexion_rad);
    for (std::size_t role = 0; role < a.bodies.size(); ++role) {
      EXPECT_EQ(a.bodies[role].is_live, b.bodies[role].is_live);
      EXPECT_EQ(a.bodies[role].was_seen, b.bodies[role].was_seen);
      EXPECT_NEAR(a.bodies[role].age_s, b.bodies[role].age_s, 0.02);
    }
    EXPECT_EQ(a.potentiometer.is_live, b.potentiometer.is_live);
    for (std::size_t p = 0; p < bench::parameters().size(); ++p)
      EXPECT_EQ(bench::value_of(played.state().values(), p), bench::value_of(jumped.state().values(), p));
  }
}

/// Two samples per picture, with a delay of 3 ms.
TEST(MotionCollector, GivesEveryPoseAtItsTime)
{
  const bench::Screw a_second{{0.5, -0.8, 0.3}, {200.0, -100.0, 50.0}};
  const Pose start = test::some_pose(3);
  bench::MotionCollector collector(test::SmallBench(test::rigid_text()).bench);
  for (int k = 0; k < 100; ++k) {
    bench::RecordedFrame picture;
    for (const int ms : {20 * k, 20 * k + 10})
      picture.samples.push_back(test::place_sample(0, test::moved(start, a_second, 0.001 * ms),
                                                   (5000 + ms) * ms_in_ns, (ms + 3) * ms_in_ns));
    collector.take(picture);
  }
  const std::vector<bench::TimedPose>& motion = collector.motion(bench::BodyRole::leg);
  ASSERT_EQ(motion.size(), 200u);
  for (std::size_t k = 0; k < motion.size(); ++k) {
    EXPECT_NEAR(motion[k].time_s, 0.01 * static_cast<double>(k) + 0.003, 1e-9);
    EXPECT_LT(test::distance_of(motion[k].X, test::moved(start, a_second, 0.01 * static_cast<double>(k))),
              1e-9);
  }
  EXPECT_TRUE(collector.motion(bench::BodyRole::tibia).empty());
  // A constant twist is predicted exactly; the held pose has the error of the motion during the horizon.
  const std::vector<bench::BodyPrediction> predictions = bench::predictions_of(collector);
  ASSERT_EQ(predictions.size(), 3u);
  EXPECT_EQ(predictions[1].horizon_ms, 33.0);
  EXPECT_LT(predictions[1].error.shift_mm.predicted.percentile_95, 1e-6);
  EXPECT_GT(predictions[1].error.shift_mm.held.rms, 1.0);
}

}  // namespace vrda::replay_state_test
