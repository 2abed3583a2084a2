#include "bench/bench_run.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "bench_samples.hpp"
#include "core/framed_file.hpp"

namespace vrda::replay_state_test {

using test::ms_in_ns;

constexpr core::FrameFormat format{"VRDABREC", 1, 1U << 24, "frame"};
constexpr std::size_t n_frames = 8600;  // 143 s, longer than the run-up
constexpr std::size_t hidden_from = 600, turned_at = 300;

/// A moving femur with arrival jitter; a tibia that is hidden early and stays so; a potentiometer and keys
/// that change parameters at the beginning only; a lost and found board.
std::string recorded(const test::SmallBench& bench)
{
  std::string bytes = core::header_bytes("bench recording", format);
  bytes += core::frame_of(bench::bytes_of(bench::RecordingFacts{}));
  for (std::size_t k = 0; k < n_frames; ++k) {
    const auto now_ns = static_cast<std::int64_t>(k + 1) * 16'666'667;
    const std::int64_t arrival_ns = now_ns - static_cast<std::int64_t>(1 + k * 7919 % 5) * ms_in_ns;
    const std::int64_t device_ns = now_ns - 8 * ms_in_ns + 3'600'000 * ms_in_ns;
    const double flexion_rad = 0.7 + 0.3 * std::sin(0.01 * static_cast<double>(k));
    const Pose X_thigh = test::moved(test::some_pose(2), {{0.02, 0.01, 0.0}, {5.0, 0.0, 1.0}},
                                     1e-9 * 1.0 * static_cast<double>(now_ns));
    std::vector<bench::Sample> samples{test::place_sample(0, X_thigh, device_ns, arrival_ns)};
    samples.push_back(k < hidden_from
                          ? test::place_sample(1, bench.X_tracker_shank(X_thigh, {flexion_rad, 0.02, 0.1}),
                                               device_ns, arrival_ns)
                          : test::hidden_sample(1, arrival_ns));
    if (k < 2 * turned_at)
      samples.push_back(test::potentiometer_sample(k < turned_at ? 300 : 700, arrival_ns));
    if (k == 100 || k == 400)
      samples.push_back(test::link_sample(
          bench::DeviceId::board, k == 100 ? bench::LinkState::closed : bench::LinkState::up, arrival_ns));
    std::vector<view::KeyPress> keys;
    if (k == 50) keys.assign(3, {view::Key::right});
    bytes += core::frame_of(bench::bytes_of(now_ns, keys, samples));
  }
  return bytes;
}

TEST(ReplayState, AJumpShowsTheFrameOfTheSession)
{
  const test::SmallBench small(test::two_bodies_text());
  const bench::BenchSetup setup{small.model, small.motion, small.frame, small.bench, small.calibration, {}};
  const std::string bytes = recorded(small);
  bench::RecordingReader reader("a.log", bytes.size(), [&](std::uint64_t at, std::size_t n) {
    return bytes.substr(static_cast<std::size_t>(at), n);
  });
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

}  // namespace vrda::replay_state_test
