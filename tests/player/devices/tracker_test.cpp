// The tracker client against a local server.
#include <gtest/gtest.h>

#include <atomic>
#include <optional>

#include "core/error.hpp"
#include "devices/tracker_server.hpp"
#include "player/devices/waiting.hpp"

namespace vrda::tracker_test {

using test::is_link;
using test::is_place;
using test::take_until;
using test::wait_until;

constexpr std::int64_t ms = 1'000'000;

/// The tick number is the pose's x; the clock advances by 10 ms.
IgtlMessage tdata_of(std::uint64_t tick, const std::vector<std::string>& tools)
{
  IgtlMessage message;
  message.kind = IgtlKind::tdata;
  message.device = "Tracker";
  message.device_ns = static_cast<std::int64_t>(tick + 1) * 10 * ms;
  for (const std::string& name : tools) {
    message.tools.push_back({name});
    message.tools.back().X_tracker_tool.translation().x() = static_cast<double>(tick);
  }
  return message;
}

std::vector<IgtlMessage> femur(std::uint64_t tick)
{
  return {tdata_of(tick, {"Femur"})};
}

TrackerSettings settings_for(const TrackerServer& server)
{
  TrackerSettings settings;
  settings.port = server.port();
  settings.tools = {"Femur"};
  settings.retry_ms = 5.0;
  return settings;
}

/// A fault after which the tool is seen again without intervention.
class Recovery : public testing::Test {
 protected:
  void start(const TrackerServerOptions& options = {})
  {
    server_.emplace(options, femur);
    devices_.emplace(settings_for(*server_), std::nullopt);
    ASSERT_TRUE(take_until(*devices_, seen_, [](const Sample& s) { return is_place(s, SeenState::seen); }));
    EXPECT_EQ(devices_->report(DeviceId::tracker).link, LinkState::up);
  }
  void expect_closed_and_seen_again()
  {
    EXPECT_TRUE(take_until(*devices_, seen_,
                           [](const Sample& s) { return is_link(s, DeviceId::tracker, LinkState::closed); }));
    trouble_ = devices_->report(DeviceId::tracker).trouble;
    EXPECT_TRUE(take_until(*devices_, seen_,
                           [](const Sample& s) { return is_link(s, DeviceId::tracker, LinkState::up); }));
    EXPECT_TRUE(take_until(*devices_, seen_, [](const Sample& s) { return is_place(s, SeenState::seen); }));
  }

  std::optional<TrackerServer> server_;
  std::optional<Devices> devices_;
  std::vector<Sample> seen_;
  std::string trouble_;  ///< when the link closed, or empty if it is up again
};

TEST(Tracker, AHundredHertzWithJitterArriveWhole)
{
  TrackerServerOptions options;
  options.jitter_ms = 2.0;
  TrackerServer server(options, femur);
  Devices devices(settings_for(server), std::nullopt);
  constexpr int n_wanted = 300;
  std::vector<Sample> places, seen;
  ASSERT_TRUE(take_until(devices, seen, [&places](const Sample& sample) {
    if (is_place(sample, SeenState::seen)) places.push_back(sample);
    return places.size() == n_wanted;
  }));
  int n_wrong = 0, n_back = 0;
  for (std::size_t k = 1; k < places.size(); ++k) {
    n_wrong += places[k].place.position_mm[0] == places[k - 1].place.position_mm[0] + 1.0 ? 0 : 1;
    n_wrong += places[k].device_ns == places[k - 1].device_ns + 10 * ms ? 0 : 1;
    n_back += places[k].arrival_ns < places[k - 1].arrival_ns ? 1 : 0;
  }
  EXPECT_EQ(n_wrong, 0);
  EXPECT_EQ(n_back, 0);
  const DeviceReport report = devices.report(DeviceId::tracker);
  EXPECT_EQ(report.n_lost, 0U);
  EXPECT_EQ(report.n_refused, 0U);
  EXPECT_EQ(report.n_connects, 1U);
  EXPECT_GT(report.rate_hz, 0.0);
  EXPECT_EQ(report.peer, "127.0.0.1:" + std::to_string(server.port()));
}

TEST_F(Recovery, FromAServerThatIsKilledAndReturns)
{
  start();
  const std::uint16_t port = server_->port();
  server_.reset();
  ASSERT_TRUE(take_until(*devices_, seen_,
                         [](const Sample& s) { return is_link(s, DeviceId::tracker, LinkState::closed); }));
  EXPECT_TRUE(take_until(*devices_, seen_, [](const Sample& s) { return is_place(s, SeenState::stale); }));
  EXPECT_TRUE(
      wait_until([&] { return devices_->report(DeviceId::tracker).trouble == "Connection refused"; }));
  TrackerServerOptions options;
  options.port = port;
  // The new clock is far behind: poses are accepted after several.
  server_.emplace(options, femur);
  EXPECT_TRUE(take_until(*devices_, seen_,
                         [](const Sample& s) { return is_link(s, DeviceId::tracker, LinkState::up); }));
  EXPECT_TRUE(take_until(*devices_, seen_, [](const Sample& s) { return is_place(s, SeenState::seen); }));
  EXPECT_EQ(devices_->report(DeviceId::tracker).n_connects, 2U);
}

TEST_F(Recovery, FromConnectionsThatAreClosed)
{
  start();
  server_->misbehave(Mischief::close);
  expect_closed_and_seen_again();
  EXPECT_EQ(devices_->report(DeviceId::tracker).n_refused, 0U);
}

TEST_F(Recovery, FromHalfAMessage)
{
  start();
  server_->misbehave(Mischief::half_a_message);
  expect_closed_and_seen_again();
  EXPECT_EQ(devices_->report(DeviceId::tracker).n_refused, 1U);
}

TEST_F(Recovery, FromGarbage)
{
  start();
  server_->misbehave(Mischief::garbage);
  expect_closed_and_seen_again();
  EXPECT_EQ(devices_->report(DeviceId::tracker).n_refused, 1U);
}

TEST_F(Recovery, FromAWrongChecksum)
{
  start();
  server_->misbehave(Mischief::wrong_checksum);
  expect_closed_and_seen_again();
  EXPECT_EQ(devices_->report(DeviceId::tracker).n_refused, 1U);
}

/// A tracker whose ticks a test can change.
struct Script {
  std::atomic<bool> is_hidden{false}, stands_still{false}, is_silent{false};
  std::atomic<std::int64_t> clock_ns{0};  ///< added to every stamp

  std::vector<IgtlMessage> operator()(std::uint64_t tick)
  {
    IgtlMessage message =
        tdata_of(tick, is_hidden ? std::vector<std::string>{} : std::vector<std::string>{"Femur"});
    message.device_ns = stands_still ? last_ns_ : message.device_ns + clock_ns;
    last_ns_ = message.device_ns;
    if (is_silent) return {};
    return {message};
  }

 private:
  std::int64_t last_ns_ = 0;
};

class Scripted : public testing::Test {
 protected:
  void await(SeenState state)
  {
    EXPECT_TRUE(take_until(devices_, seen_, [state](const Sample& s) { return is_place(s, state); }));
  }

  Script script_;
  TrackerServer server_{{}, [this](std::uint64_t tick) { return script_(tick); }};
  Devices devices_{settings_for(server_), std::nullopt};
  std::vector<Sample> seen_;
};

TEST_F(Scripted, ABodyThatIsHiddenIsMissingUntilItIsSeen)
{
  await(SeenState::seen);
  script_.is_hidden = true;
  await(SeenState::missing);
  script_.is_hidden = false;
  await(SeenState::seen);
}

TEST_F(Scripted, AClockThatStepsBackIsStaleUntilItIsBelieved)
{
  script_.clock_ns = 3'600'000 * ms;
  ASSERT_TRUE(take_until(devices_, seen_, [](const Sample& s) { return s.device_ns > 3'600'000 * ms; }));
  script_.clock_ns = 0;
  await(SeenState::stale);
  await(SeenState::seen);
  EXPECT_LT(seen_.back().device_ns, 3'600'000 * ms);
}

TEST_F(Scripted, AClockThatStandsStillIsStaleUntilItGoesOn)
{
  await(SeenState::seen);
  script_.stands_still = true;
  await(SeenState::stale);
  script_.stands_still = false;
  await(SeenState::seen);
}

TEST_F(Scripted, ATrackerThatSaysNothingIsStaleUntilItSpeaks)
{
  await(SeenState::seen);
  script_.is_silent = true;
  await(SeenState::stale);
  EXPECT_EQ(devices_.report(DeviceId::tracker).link, LinkState::up);
  script_.is_silent = false;
  await(SeenState::seen);
}

TEST(Tracker, AsksForTdataWhereItIsTold)
{
  TrackerServerOptions options;
  options.waits_for_request = true;
  TrackerServer server(options, femur);
  TrackerSettings settings = settings_for(server);
  settings.tdata_interval_ms = 30.0;
  Devices devices(settings, std::nullopt);
  std::vector<Sample> places, seen;
  ASSERT_TRUE(take_until(devices, seen, [&places](const Sample& sample) {
    if (is_place(sample, SeenState::seen)) places.push_back(sample);
    return places.size() == 5;
  }));
  for (std::size_t k = 1; k < places.size(); ++k)
    EXPECT_EQ(places[k].place.position_mm[0], places[k - 1].place.position_mm[0] + 3.0);
}

TEST(Tracker, AServerThatWaitsSaysNothingUnasked)
{
  TrackerServerOptions options;
  options.waits_for_request = true;
  TrackerServer server(options, femur);
  TrackerSettings settings = settings_for(server);
  settings.stale_after_ms = 20.0;
  Devices devices(settings, std::nullopt);
  std::vector<Sample> seen;
  int n_stale = 0;
  ASSERT_TRUE(take_until(devices, seen, [&n_stale](const Sample& s) {
    return (n_stale += is_place(s, SeenState::stale) ? 1 : 0) == 5;
  }));
  for (const Sample& sample : seen) EXPECT_FALSE(is_place(sample, SeenState::seen));
}

TEST(Tracker, SendsSeveralClientsTheSame)
{
  TrackerServer server({}, femur);
  Devices first(settings_for(server), std::nullopt), second(settings_for(server), std::nullopt);
  std::vector<Sample> seen;
  EXPECT_TRUE(wait_until([&] { return server.n_clients() == 2; }));
  EXPECT_TRUE(take_until(first, seen, [](const Sample& s) { return is_place(s, SeenState::seen); }));
  EXPECT_TRUE(take_until(second, seen, [](const Sample& s) { return is_place(s, SeenState::seen); }));
}

TEST(Tracker, SaysWhatIsWrongWithAHost)
{
  TrackerSettings settings;
  settings.host = "no such host";
  settings.tools = {"Femur"};
  settings.retry_ms = 1.0;
  const Devices devices(settings, std::nullopt);
  EXPECT_TRUE(wait_until([&] { return !devices.report(DeviceId::tracker).trouble.empty(); }));
  EXPECT_EQ(devices.report(DeviceId::board).link, LinkState::closed);
}

TEST(TrackerServer, RefusesAddressesAndPortsItCannotListenOn)
{
  TrackerServerOptions options;
  options.address = "localhost";
  try {
    TrackerServer server(options, femur);
    FAIL() << "a name is no number";
  } catch (const InputError& error) {
    EXPECT_EQ(error.facts().field, "address");
    EXPECT_EQ(error.facts().found, "localhost");
  }
  const TrackerServer first({}, femur);
  options.address = "127.0.0.1";
  options.port = first.port();
  try {
    TrackerServer second(options, femur);
    FAIL() << "the port is taken";
  } catch (const InputError& error) {
    EXPECT_EQ(error.facts().field, "port");
    EXPECT_EQ(error.facts().found, "127.0.0.1:" + std::to_string(first.port()) + ": Address already in use");
  }
}

}  // namespace vrda::tracker_test
