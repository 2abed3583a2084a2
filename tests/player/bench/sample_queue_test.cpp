#include "bench/devices.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace vrda::sample_queue_test {

bench::Sample reading(std::int32_t count)
{
  bench::Sample sample;
  sample.kind = bench::SampleKind::stage;
  sample.count = count;
  return sample;
}

bench::Sample of_place(bench::ToolVisibility state)
{
  bench::Sample sample;
  sample.kind = bench::SampleKind::tool_pose;
  sample.state = static_cast<std::uint8_t>(state);
  return sample;
}

bool put(bench::SampleQueue& queue, const bench::Sample& sample)
{
  const bool has_room = queue.stage(sample);
  queue.publish();
  return has_room;
}

TEST(SampleQueue, GivesWhatWasPutInItsOrder)
{
  bench::SampleQueue queue;
  bench::Sample sample;
  EXPECT_FALSE(queue.take(sample));
  for (std::int32_t round = 0; round < 3; ++round) {  // wraps around
    for (std::int32_t k = 0; k < 3000; ++k) ASSERT_TRUE(put(queue, reading(k)));
    for (std::int32_t k = 0; k < 3000; ++k) {
      ASSERT_TRUE(queue.take(sample));
      ASSERT_EQ(sample.count, k);
    }
    EXPECT_FALSE(queue.take(sample));
  }
}

TEST(SampleQueue, KeepsRoomForTheNewsOfLinksAndOfToolsNoLongerSeen)
{
  bench::SampleQueue queue;
  std::size_t n = 0;
  while (put(queue, reading(1))) ++n;
  EXPECT_EQ(n, bench::SampleQueue::capacity - bench::SampleQueue::n_reserved);
  EXPECT_FALSE(put(queue, of_place(bench::ToolVisibility::seen)));
  EXPECT_TRUE(put(queue, of_place(bench::ToolVisibility::stale)));
  EXPECT_TRUE(put(queue, bench::Sample()));
  for (n = 2; put(queue, bench::Sample()); ++n) {
  }
  EXPECT_EQ(n, bench::SampleQueue::n_reserved);
}

TEST(SampleQueue, LosesNothingBetweenTwoThreads)
{
  constexpr std::int32_t n_samples = 300'000;
  bench::SampleQueue queue;
  std::thread writer([&queue] {
    for (std::int32_t k = 0; k < n_samples;) {
      if (put(queue, reading(k))) ++k;
    }
  });
  std::int32_t n_wrong = 0;
  bench::Sample sample;
  for (std::int32_t k = 0; k < n_samples;) {
    if (!queue.take(sample)) continue;
    n_wrong += sample.count == k ? 0 : 1;
    ++k;
  }
  writer.join();
  EXPECT_EQ(n_wrong, 0);
}

TEST(Outlet, ToolsThatAreMissingAreNoSamples)
{
  bench::SampleQueue queue;
  const bench::ArrivalClock clock;
  bench::DeviceOutput outlet(bench::DeviceId::tracker, "", queue, clock);
  bench::Sample sample;
  sample.kind = bench::SampleKind::tool_pose;
  for (const bench::ToolVisibility state :
       {bench::ToolVisibility::seen, bench::ToolVisibility::missing, bench::ToolVisibility::stale,
        bench::ToolVisibility::invalid_pose}) {
    sample.state = static_cast<std::uint8_t>(state);
    sample.arrival_ns = clock.now_ns();
    outlet.put({sample});
  }
  EXPECT_EQ(outlet.report().n_samples, 1U);
  EXPECT_GT(outlet.report().rate_hz, 0.0);
}

TEST(Outlet, ReportsEachLinkStateOnceAndKeepsItsErrorMessage)
{
  bench::SampleQueue queue;
  const bench::ArrivalClock clock;
  bench::DeviceOutput outlet(bench::DeviceId::board, "", queue, clock);
  outlet.set_link(bench::LinkState::opening, "");
  outlet.set_link(bench::LinkState::closed, "Connection refused");
  outlet.set_link(bench::LinkState::closed, "Connection refused");
  outlet.set_link(bench::LinkState::opening, "");
  EXPECT_EQ(outlet.report().error_message, "Connection refused");
  outlet.set_link(bench::LinkState::up, "");
  EXPECT_EQ(outlet.report().error_message, "");
  EXPECT_EQ(outlet.report().n_connects, 1U);
  EXPECT_EQ(outlet.report().n_samples, 0U);
  std::vector<int> states;
  for (bench::Sample sample; queue.take(sample);) states.push_back(sample.state);
  EXPECT_EQ(states, (std::vector<int>{1, 0, 1, 2}));
}

TEST(RateMeter, IsExactForSteadyReadings)
{
  bench::RateMeter meter;
  EXPECT_EQ(meter.rate_hz(0), 0.0);
  constexpr std::int64_t period_ns = 10'000'000;
  std::int64_t now_ns = 0;
  for (int n = 0; n < 1000; ++n, now_ns += period_ns) meter.count(now_ns);
  // One reading more or less within the counted 1.75 to 2 s.
  EXPECT_NEAR(meter.rate_hz(now_ns), 100.0, 1.0 / 1.75);
  EXPECT_EQ(meter.rate_hz(now_ns + 3'000'000'000), 0.0);
}

}  // namespace vrda::sample_queue_test
