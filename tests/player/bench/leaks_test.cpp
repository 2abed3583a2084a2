// Devices leak no resources, and servers listen only on this machine.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <optional>
#include <sstream>

#include "bench/simulated_devices.hpp"
#include "player/bench/waiting.hpp"

namespace vrda::leaks_test {

using test::is_link;
using test::take_until;

std::ptrdiff_t n_entries(const char* folder)
{
  const std::filesystem::directory_iterator entries(folder);
  return std::distance(begin(entries), end(entries));
}

struct Held {
  std::ptrdiff_t n_descriptors, n_threads;
  std::size_t bytes;
};

Held held()
{
  return {n_entries("/proc/self/fd"), n_entries("/proc/self/task"), mallinfo2().uordblks};
}

std::vector<bench::IgtlMessage> femur(std::uint64_t tick)
{
  bench::IgtlMessage message;
  message.kind = bench::IgtlKind::tdata;
  message.device_ns = static_cast<std::int64_t>(tick + 1);
  message.tools.push_back({"Femur"});
  return {message};
}

bench::TrackerSettings settings_for(const bench::TrackerServer& server)
{
  bench::TrackerSettings settings;
  settings.port = server.port();
  settings.tools = {"Femur"};
  settings.retry_ms = 1.0;
  return settings;
}

bench::PtyBoardOptions knob_and_stage()
{
  bench::PtyBoardOptions options;
  options.potentiometer = [] { return 1; };
  options.stage_count = [] { return 1; };
  return options;
}

/// A leak of malloc's smallest block, 32 bytes, per connect would exceed this.
std::size_t allowed_bytes(int n_connects)
{
  return static_cast<std::size_t>(n_connects) * 32;
}

void expect_same(const Held& before, const Held& after, int n_connects)
{
  EXPECT_EQ(after.n_descriptors, before.n_descriptors);
  EXPECT_EQ(after.n_threads, before.n_threads);
  EXPECT_LT(after.bytes, before.bytes + allowed_bytes(n_connects));
}

TEST(Leaks, AThousandConnectsAndDisconnectsOfBothDevicesLeaveNothing)
{
  bench::TrackerServerOptions options;
  options.rate_hz = 1000.0;
  bench::TrackerServer server(options, femur);
  const bench::PtyBoard board(knob_and_stage());
  const bench::TrackerSettings tracker = settings_for(server);
  bench::BoardSettings line;
  line.port = board.path();
  const auto connect_and_leave = [&] {
    bench::Devices devices(tracker, line);
    std::vector<bench::Sample> seen;
    for (const bench::DeviceId device : {bench::DeviceId::tracker, bench::DeviceId::board}) {
      const auto is_up = [device](const bench::Sample& s) {
        return is_link(s, device, bench::LinkState::up);
      };
      const bool is_seen = std::ranges::any_of(seen, is_up);
      ASSERT_TRUE(is_seen || take_until(devices, seen, is_up));
    }
  };
  const auto is_left = [&server] { return server.n_clients() == 0; };
  constexpr int n_first = 100, n_connects = 1000;  // the first connects fill caches
  for (int n = 0; n < n_first; ++n) connect_and_leave();
  ASSERT_TRUE(test::wait_until(is_left));
  const Held before = held();
  for (int n = 0; n < n_connects; ++n) connect_and_leave();
  ASSERT_TRUE(test::wait_until(is_left));
  expect_same(before, held(), n_connects);
}

TEST(Leaks, AThousandConnectionsLostAndMadeAgainLeaveNothing)
{
  std::atomic<bool> is_spoilt{false};
  bench::TrackerServerOptions options;
  options.rate_hz = 1000.0;
  options.corrupt = [&is_spoilt](std::vector<std::uint8_t>& bytes) {
    if (is_spoilt.exchange(false)) bytes[0] = 0xFF;
  };
  bench::TrackerServer server(options, femur);
  bench::Devices devices(settings_for(server), std::nullopt);
  std::vector<bench::Sample> seen;
  const auto be_lost = [&] {
    seen.clear();
    ASSERT_TRUE(
        take_until(devices, seen, [](const bench::Sample& s) { return s.is(bench::ToolVisibility::seen); }));
    is_spoilt = true;
    ASSERT_TRUE(take_until(devices, seen, [](const bench::Sample& s) {
      return is_link(s, bench::DeviceId::tracker, bench::LinkState::closed);
    }));
  };
  constexpr int n_first = 100, n_connects = 1000;
  for (int n = 0; n < n_first; ++n) be_lost();
  const Held before = held();
  for (int n = 0; n < n_connects; ++n) be_lost();
  // The connection may or may not exist at either time: three descriptors for its two ends and one not yet
  // accepted.
  const Held after = held();
  EXPECT_LE(std::abs(after.n_descriptors - before.n_descriptors), 3);
  EXPECT_EQ(after.n_threads, before.n_threads);
  EXPECT_LT(after.bytes, before.bytes + allowed_bytes(n_connects));
  EXPECT_GE(devices.report(bench::DeviceId::tracker).n_connects,
            static_cast<std::uint64_t>(n_first + n_connects));
}

/// Local addresses of sockets that listen (state 0A) on the port, in /proc's hexadecimal.
std::vector<std::string> listeners(std::uint16_t port)
{
  std::ostringstream hex;
  hex << ':' << std::hex << std::uppercase << std::setw(4) << std::setfill('0') << port;
  std::vector<std::string> found;
  for (const char* table : {"/proc/self/net/tcp", "/proc/self/net/tcp6"}) {
    std::ifstream file(table);
    for (std::string line; std::getline(file, line);) {
      std::istringstream words(line);
      std::string number, local, remote, state;
      words >> number >> local >> remote >> state;
      if (state == "0A" && local.ends_with(hex.str())) found.push_back(local.substr(0, local.size() - 5));
    }
  }
  return found;
}

TEST(Loopback, NothingListensBeyondThisMachineUnlessTheAddressSaysSo)
{
  const bench::TrackerServer server({}, femur);
  const bench::Devices devices(settings_for(server), std::nullopt);
  EXPECT_EQ(listeners(server.port()), std::vector<std::string>{"0100007F"});  // 127.0.0.1, lowest byte first
  bench::TrackerServerOptions open;
  open.address = "0.0.0.0";
  const bench::TrackerServer everywhere(open, femur);
  EXPECT_EQ(listeners(everywhere.port()), std::vector<std::string>{"00000000"});
}

}  // namespace vrda::leaks_test
