#include "devices/sample.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "devices/device_output.hpp"

namespace vrda::sample_queue_test {

devices::Sample reading(std::int32_t count)
{
  devices::Sample sample;
  sample.kind = devices::SampleKind::stage;
  sample.count = count;
  return sample;
}

devices::Sample of_place(devices::ToolVisibility state)
{
  devices::Sample sample;
  sample.kind = devices::SampleKind::tool_pose;
  sample.state = static_cast<std::uint8_t>(state);
  return sample;
}

TEST(SampleQueue, GivesWhatWasPutInItsOrder)
{
  devices::SampleQueue queue;
  devices::Sample sample;
  EXPECT_FALSE(queue.take(sample));
  for (std::int32_t round = 0; round < 3; ++round) {  // wraps around
    for (std::int32_t k = 0; k < 3000; ++k) ASSERT_TRUE(queue.put(reading(k)));
    for (std::int32_t k = 0; k < 3000; ++k) {
      ASSERT_TRUE(queue.take(sample));
      ASSERT_EQ(sample.count, k);
    }
    EXPECT_FALSE(queue.take(sample));
  }
}

TEST(SampleQueue, KeepsRoomForTheNewsOfLinksAndOfToolsNoLongerSeen)
{
  devices::SampleQueue queue;
  std::size_t n = 0;
  while (queue.put(reading(1))) ++n;
  EXPECT_EQ(n, devices::SampleQueue::capacity - devices::SampleQueue::n_reserved);
  EXPECT_FALSE(queue.put(of_place(devices::ToolVisibility::seen)));
  EXPECT_TRUE(queue.put(of_place(devices::ToolVisibility::stale)));
  EXPECT_TRUE(queue.put(devices::Sample()));
  for (n = 2; queue.put(devices::Sample()); ++n) {
  }
  EXPECT_EQ(n, devices::SampleQueue::n_reserved);
}

TEST(SampleQueue, LosesNothingBetweenTwoThreads)
{
  constexpr std::int32_t n_samples = 300'000;
  devices::SampleQueue queue;
  std::thread writer([&queue] {
    for (std::int32_t k = 0; k < n_samples;) {
      if (queue.put(reading(k))) ++k;
    }
  });
  std::int32_t n_wrong = 0;
  devices::Sample sample;
  for (std::int32_t k = 0; k < n_samples;) {
    if (!queue.take(sample)) continue;
    n_wrong += sample.count == k ? 0 : 1;
    ++k;
  }
  writer.join();
  EXPECT_EQ(n_wrong, 0);
}

TEST(Outlet, CountsWhatTheLoopDidNotTake)
{
  devices::SampleQueue queue;
  const devices::ArrivalClock clock;
  devices::DeviceOutput outlet(devices::DeviceId::board, "/dev/board", queue, clock);
  outlet.put(std::vector<devices::Sample>(devices::SampleQueue::capacity, reading(1)));
  const devices::DeviceReport report = outlet.report();
  EXPECT_EQ(report.peer, "/dev/board");
  EXPECT_EQ(report.n_samples, devices::SampleQueue::capacity);
  EXPECT_EQ(report.n_lost, devices::SampleQueue::n_reserved);
}

TEST(Outlet, ToolsThatAreMissingAreNoSamples)
{
  devices::SampleQueue queue;
  const devices::ArrivalClock clock;
  devices::DeviceOutput outlet(devices::DeviceId::tracker, "", queue, clock);
  devices::Sample sample;
  sample.kind = devices::SampleKind::tool_pose;
  for (const devices::ToolVisibility state :
       {devices::ToolVisibility::seen, devices::ToolVisibility::missing, devices::ToolVisibility::stale,
        devices::ToolVisibility::invalid_pose}) {
    sample.state = static_cast<std::uint8_t>(state);
    sample.arrival_ns = clock.now_ns();
    outlet.put({sample});
  }
  EXPECT_EQ(outlet.report().n_samples, 1U);
  EXPECT_GT(outlet.report().rate_hz, 0.0);
}

TEST(Outlet, ReportsEachLinkStateOnceAndKeepsItsErrorMessage)
{
  devices::SampleQueue queue;
  const devices::ArrivalClock clock;
  devices::DeviceOutput outlet(devices::DeviceId::board, "", queue, clock);
  outlet.set_link(devices::LinkState::opening, "");
  outlet.set_link(devices::LinkState::closed, "Connection refused");
  outlet.set_link(devices::LinkState::closed, "Connection refused");
  outlet.set_link(devices::LinkState::opening, "");
  EXPECT_EQ(outlet.report().error_message, "Connection refused");
  outlet.set_link(devices::LinkState::up, "");
  EXPECT_EQ(outlet.report().error_message, "");
  EXPECT_EQ(outlet.report().n_connects, 1U);
  EXPECT_EQ(outlet.report().n_samples, 0U);
  std::vector<int> states;
  for (devices::Sample sample; queue.take(sample);) states.push_back(sample.state);
  EXPECT_EQ(states, (std::vector<int>{1, 0, 1, 2}));
}

TEST(RateMeter, IsExactForSteadyReadings)
{
  devices::RateMeter meter;
  EXPECT_EQ(meter.rate_hz(0), 0.0);
  constexpr std::int64_t period_ns = 10'000'000;
  std::int64_t now_ns = 0;
  for (int n = 0; n < 1000; ++n, now_ns += period_ns) meter.count(now_ns);
  // One reading more or less within the counted 1.75 to 2 s.
  EXPECT_NEAR(meter.rate_hz(now_ns), 100.0, 1.0 / 1.75);
  EXPECT_EQ(meter.rate_hz(now_ns + 3'000'000'000), 0.0);
}

}  // namespace vrda::sample_queue_test
