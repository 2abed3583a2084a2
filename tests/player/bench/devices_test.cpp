// The tracker client against a local server.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <malloc.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <iomanip>
#include <sstream>

#include "bench/simulated_devices.hpp"
#include "core/files.hpp"
#include "player/bench/waiting.hpp"

namespace vrda::devices_test {

using test::is_link, test::take_until, test::wait_until;

using Bytes = std::vector<std::uint8_t>;
using Fault = void (*)(Bytes& bytes);

constexpr std::int64_t ms = 1'000'000;

/// The tick number is the pose's x; the clock advances by 10 ms.
bench::IgtlMessage tdata_of(std::uint64_t tick, const std::vector<std::string>& tools)
{
  bench::IgtlMessage message;
  message.kind = bench::IgtlKind::tdata;
  message.device = "Tracker";
  message.device_ns = static_cast<std::int64_t>(tick + 1) * 10 * ms;
  for (const std::string& name : tools) {
    message.tools.push_back({name});
    message.tools.back().X_tracker_tool.translation().x() = static_cast<double>(tick);
  }
  return message;
}

std::vector<bench::IgtlMessage> femur(std::uint64_t tick)
{
  return {tdata_of(tick, {"Femur"})};
}

bool is_seen(const bench::Sample& sample)
{
  return sample.is(bench::ToolVisibility::seen);
}
bool is_up(const bench::Sample& sample)
{
  return is_link(sample, bench::DeviceId::tracker, bench::LinkState::up);
}
bool is_closed(const bench::Sample& sample)
{
  return is_link(sample, bench::DeviceId::tracker, bench::LinkState::closed);
}

bench::TrackerSettings settings_for(const bench::TrackerServer& server)
{
  bench::TrackerSettings settings;
  settings.port = server.port();
  settings.tools = {"Femur"};
  settings.retry_ms = 1.0;
  return settings;
}

/// A fault after which the tool is seen again without intervention.
class Recovery : public testing::Test {
 protected:
  void start()
  {
    bench::TrackerServerOptions options;
    options.corrupt = [this](Bytes& bytes) {
      if (const Fault fault = next_fault_.exchange(nullptr)) fault(bytes);
    };
    server_.emplace(options, femur);
    devices_.emplace(settings_for(*server_), std::nullopt);
    ASSERT_TRUE(take_until(*devices_, seen_, is_seen));
    EXPECT_EQ(devices_->report(bench::DeviceId::tracker).link, bench::LinkState::up);
  }
  void expect_closed_and_seen_again()
  {
    EXPECT_TRUE(take_until(*devices_, seen_, is_closed));
    EXPECT_TRUE(take_until(*devices_, seen_, is_up));
    EXPECT_TRUE(take_until(*devices_, seen_, is_seen));
  }

  std::atomic<Fault> next_fault_{nullptr};
  std::optional<bench::TrackerServer> server_;
  std::optional<bench::Devices> devices_;
  std::vector<bench::Sample> seen_;
};

TEST(Tracker, AHundredHertzWithJitterArriveWhole)
{
  bench::TrackerServerOptions options;
  options.jitter_ms = 2.0;
  bench::TrackerServer server(options, femur);
  bench::Devices devices(settings_for(server), std::nullopt);
  constexpr int n_wanted = 300;
  std::vector<bench::Sample> places, seen;
  ASSERT_TRUE(take_until(devices, seen, [&places](const bench::Sample& sample) {
    if (is_seen(sample)) places.push_back(sample);
    return places.size() == n_wanted;
  }));
  int n_wrong = 0, n_back = 0;
  for (std::size_t k = 1; k < places.size(); ++k) {
    n_wrong += places[k].tool_pose.position_mm[0] == places[k - 1].tool_pose.position_mm[0] + 1.0 ? 0 : 1;
    n_wrong += places[k].device_ns == places[k - 1].device_ns + 10 * ms ? 0 : 1;
    n_back += places[k].arrival_ns < places[k - 1].arrival_ns ? 1 : 0;
  }
  EXPECT_EQ(n_wrong, 0);
  EXPECT_EQ(n_back, 0);
  const bench::DeviceReport report = devices.report(bench::DeviceId::tracker);
  EXPECT_EQ(report.n_lost, 0U);
  EXPECT_EQ(report.n_refused, 0U);
  EXPECT_EQ(report.n_connects, 1U);
  EXPECT_GT(report.rate_hz, 0.0);
  EXPECT_EQ(report.peer, "127.0.0.1:" + std::to_string(server.port()));
}

TEST_F(Recovery, FromSpoiltMessages)
{
  for (const Fault fault : {Fault([](Bytes& bytes) { bytes.resize(bytes.size() / 2); }),
                            Fault([](Bytes& bytes) { bytes.insert(bytes.begin(), 100, 0xFF); }),
                            Fault([](Bytes& bytes) { bytes[bench::igtl_header_bytes - 1] ^= 1; })}) {
    start();
    next_fault_ = fault;
    expect_closed_and_seen_again();
    EXPECT_EQ(devices_->report(bench::DeviceId::tracker).n_refused, 1U);
  }
}

/// A server by hand.
class Listener {
 public:
  Listener() : socket_(socket(AF_INET, SOCK_STREAM, 0))
  {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t n = sizeof address;
    auto* const generic = reinterpret_cast<sockaddr*>(&address);
    EXPECT_EQ(bind(socket_.get(), generic, n), 0);
    EXPECT_EQ(listen(socket_.get(), 1), 0);
    EXPECT_EQ(getsockname(socket_.get(), generic, &n), 0);
    settings.port = ntohs(address.sin_port);
    settings.tools = {"Femur"};
    settings.retry_ms = 1.0;
  }
  OpenFile next_client() const { return OpenFile(accept(socket_.get(), nullptr, nullptr)); }

  bench::TrackerSettings settings;

 private:
  OpenFile socket_;
};

/// The next message that a client sends.
std::optional<bench::IgtlMessage> next_request(const OpenFile& client)
{
  bench::IgtlStream stream;
  for (std::uint8_t byte = 0; recv(client.get(), &byte, 1, 0) == 1;) {
    stream.add({&byte, 1});
    if (std::optional<bench::IgtlMessage> message = stream.next()) return message;
  }
  return std::nullopt;
}

/// PlusServer states what is hidden only to clients that have sent a message of header version 2. A server
/// that ends such a connection at once gets no second request.
TEST(Tracker, AsksForHeaderVersion2UnlessTheServerEndsTheConnection)
{
  Listener listener;
  listener.settings.tdata_interval_ms = 30.0;
  const bench::Devices devices(listener.settings, std::nullopt);
  using bench::IgtlKind;
  for (const auto& [first, version] : {std::pair{IgtlKind::status, 2}, std::pair{IgtlKind::start_tdata, 1},
                                       std::pair{IgtlKind::status, 2}}) {
    const OpenFile client = listener.next_client();
    const std::optional<bench::IgtlMessage> request = next_request(client);
    ASSERT_TRUE(request);
    EXPECT_EQ(request->kind, first);
    EXPECT_EQ(request->header_version, version);
    EXPECT_EQ(request->interval_ms, first == IgtlKind::start_tdata ? 30 : 0);
  }
}

/// The simulated tracker states what is visible, so poses without noise are not taken as hidden.
TEST(Tracker, TheSimulatedOneAnswersInTheRequestedVersion)
{
  const bench::TrackerServer server({}, femur);
  const OpenFile client(socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(server.port());
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(connect(client.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  std::optional<bench::IgtlMessage> said = next_request(client);
  ASSERT_TRUE(said);
  EXPECT_FALSE(said->tools.at(0).is_stated);
  bench::IgtlMessage request;
  request.kind = bench::IgtlKind::status;
  request.header_version = 2;
  const std::vector<std::uint8_t> bytes = bench::bytes_of(request);
  ASSERT_EQ(send(client.get(), bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  while (said && !said->tools.at(0).is_stated) said = next_request(client);
  ASSERT_TRUE(said);
  EXPECT_EQ(said->header_version, 2);
}

/// A tracker whose ticks a test can change.
struct Script {
  std::atomic<bool> is_hidden{false}, is_frozen{false}, is_silent{false};
  std::atomic<std::int64_t> clock_ns{0};  ///< added to every stamp

  std::vector<bench::IgtlMessage> operator()(std::uint64_t tick)
  {
    if (is_silent) return {};
    if (is_frozen) return {last_};
    last_ = tdata_of(tick, is_hidden ? std::vector<std::string>{} : std::vector<std::string>{"Femur"});
    last_.device_ns += clock_ns;
    return {last_};
  }

 private:
  bench::IgtlMessage last_;  ///< sent again while frozen
};

class Scripted : public testing::Test {
 protected:
  void await(bench::ToolVisibility state)
  {
    EXPECT_TRUE(take_until(devices_, seen_, [state](const bench::Sample& s) { return s.is(state); }));
  }

  Script script_;
  bench::TrackerServer server_{{}, [this](std::uint64_t tick) { return script_(tick); }};
  bench::Devices devices_{settings_for(server_), std::nullopt};
  std::vector<bench::Sample> seen_;
};

TEST_F(Scripted, WhatIsAmissIsSaidUntilItIsOver)
{
  await(bench::ToolVisibility::seen);
  for (const auto& [is_amiss, state] : {std::pair{&script_.is_hidden, bench::ToolVisibility::missing},
                                        std::pair{&script_.is_frozen, bench::ToolVisibility::stale},
                                        std::pair{&script_.is_silent, bench::ToolVisibility::stale}}) {
    *is_amiss = true;
    await(state);
    EXPECT_EQ(devices_.report(bench::DeviceId::tracker).link, bench::LinkState::up);
    *is_amiss = false;
    await(bench::ToolVisibility::seen);
  }
}

TEST(Tracker, SaysWhatIsWrongWithAHost)
{
  bench::TrackerSettings settings;
  settings.host = "no such host";
  settings.tools = {"Femur"};
  settings.retry_ms = 1.0;
  const bench::Devices devices(settings, std::nullopt);
  EXPECT_TRUE(wait_until([&] { return !devices.report(bench::DeviceId::tracker).error_message.empty(); }));
  EXPECT_EQ(devices.report(bench::DeviceId::board).link, bench::LinkState::closed);
}

// Devices leak no resources, and servers listen only on this machine.

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
  // On a busy machine the first batches fill caches too; a leak grows with each.
  Held before = held(), after{};
  for (int batch = 0; batch < 4; ++batch) {
    if (batch > 0) before = after;
    for (int n = 0; n < n_connects; ++n) connect_and_leave();
    ASSERT_TRUE(test::wait_until(is_left));
    after = held();
    if (after.bytes < before.bytes + allowed_bytes(n_connects)) break;
  }
  expect_same(before, after, n_connects);
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

}  // namespace vrda::devices_test
