#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "bench/board.h"
#include "bench/protocols.hpp"

namespace vrda::protocols_test {

using Bytes = std::vector<std::uint8_t>;
constexpr std::int64_t ms = 1'000'000;

Bytes frame(char request, const Bytes& payload)
{
  Bytes bytes{static_cast<std::uint8_t>(request), static_cast<std::uint8_t>(payload.size())};
  bytes.insert(bytes.end(), payload.begin(), payload.end());
  const std::uint16_t crc = crc16(bytes.data(), bytes.size());
  bytes.insert(bytes.begin(), {board_frame_start_0, board_frame_start_1});
  bytes.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  bytes.push_back(static_cast<std::uint8_t>(crc >> 8));
  return bytes;
}

const Bytes version{1, 'V', 'R', 'D', 'A'};

bench::BoardProtocol protocol_that_is_up(const bench::BoardSettings& settings = {})
{
  bench::BoardProtocol protocol(settings, 0);
  EXPECT_EQ(protocol.due(0), "V");
  EXPECT_TRUE(protocol.receive(frame('V', version), 0).empty());
  EXPECT_EQ(protocol.phase(), bench::BoardProtocol::Phase::up);
  return protocol;
}

TEST(BoardProtocol, RequestsTheVersionUntilAnAnswerOrATimeout)
{
  bench::BoardProtocol protocol({}, 0);
  std::int64_t now_ns = 0;
  for (int n = 0; n < bench::BoardProtocol::max_version_requests; ++n) {
    EXPECT_EQ(protocol.next_due_ns(), now_ns);
    EXPECT_EQ(protocol.due(now_ns), "V");
    EXPECT_EQ(protocol.due(now_ns), "");
    now_ns += bench::BoardProtocol::request_timeout_ns;
  }
  EXPECT_EQ(protocol.phase(), bench::BoardProtocol::Phase::requesting_version);
  EXPECT_EQ(protocol.due(now_ns), "");
  EXPECT_EQ(protocol.phase(), bench::BoardProtocol::Phase::failed);
  EXPECT_EQ(protocol.error_message(), "found no answer to V for 5 s, wanted a board of protocol version 1");
}

TEST(BoardProtocol, FailsOnAnotherVersionAndOnAnotherBoard)
{
  bench::BoardProtocol newer({}, 0);
  newer.receive(frame('V', {2, 'V', 'R', 'D', 'A'}), 0);
  EXPECT_EQ(newer.phase(), bench::BoardProtocol::Phase::failed);
  EXPECT_EQ(newer.error_message(), "found protocol version 2, wanted 1");
  for (const Bytes& payload : {Bytes{1, 'V', 'R', 'D', 'B'}, Bytes{1}, Bytes{1, 'V', 'R', 'D', 'A', 0}}) {
    bench::BoardProtocol other({}, 0);
    other.receive(frame('V', payload), 0);
    EXPECT_EQ(other.phase(), bench::BoardProtocol::Phase::failed);
    EXPECT_NE(other.error_message().find("VRDA"), std::string::npos) << other.error_message();
  }
}

TEST(BoardProtocol, WhatIsNoReadingIsRefused)
{
  bench::BoardProtocol protocol = protocol_that_is_up();
  for (const Bytes& bytes :
       {frame('P', {0, 4}), frame('P', {1}), frame('E', {1, 2, 3, 4}), frame('Z', {1}), frame('Q', {1, 2})})
    EXPECT_TRUE(protocol.receive(bytes, 0).empty());
  EXPECT_EQ(protocol.n_refused(), 5U);
  protocol.receive(Bytes{1, 2, 3}, 0);
  EXPECT_EQ(protocol.n_refused(), 6U);
}

TEST(BoardProtocol, AsksForAllReadingsInOneGoAtItsRate)
{
  bench::BoardProtocol protocol = protocol_that_is_up();
  int n_rounds = 0;
  for (std::int64_t now_ns = 0; now_ns < 1000 * ms; now_ns = protocol.next_due_ns()) {
    const std::string requests = protocol.due(now_ns);
    n_rounds += requests == "PE" ? 1 : 0;
    protocol.receive(frame('P', {1, 0}), now_ns);
    protocol.receive(frame('E', {0, 0, 0, 0, 0}), now_ns);
  }
  EXPECT_EQ(n_rounds, 1000 / 10);
}

TEST(BoardProtocol, KeepsTwoOfAKindOnTheirWayAndAsksAgainWhatIsLate)
{
  bench::BoardSettings settings;
  settings.has_stage = false;
  bench::BoardProtocol protocol = protocol_that_is_up(settings);
  const std::int64_t begin_ns = protocol.next_due_ns();
  EXPECT_EQ(protocol.due(begin_ns), "P");
  EXPECT_EQ(protocol.due(begin_ns + 10 * ms), "P");
  EXPECT_EQ(protocol.due(begin_ns + 20 * ms), "") << "two are on their way";
  protocol.receive(frame('P', {1, 0}), begin_ns + 25 * ms);
  EXPECT_EQ(protocol.due(begin_ns + 30 * ms), "P");
  EXPECT_EQ(protocol.due(begin_ns + 60 * ms - 1), "");
  EXPECT_EQ(protocol.due(begin_ns + 60 * ms), "P") << "that of 10 ms is late";
}

TEST(BoardProtocol, SetsZeroOnceItIsAnswered)
{
  bench::BoardProtocol protocol = protocol_that_is_up();
  protocol.zero_stage();
  const std::int64_t now_ns = protocol.next_due_ns();
  EXPECT_EQ(protocol.due(now_ns).front(), 'Z');
  EXPECT_EQ(protocol.due(now_ns + 1).find('Z'), std::string::npos);
  EXPECT_EQ(protocol.due(now_ns + bench::BoardProtocol::request_timeout_ns).front(), 'Z')
      << "no answer: again";
  EXPECT_TRUE(protocol.receive(frame('Z', {1, 0, 0, 0}), now_ns + 60 * ms).empty());
  EXPECT_EQ(protocol.due(now_ns + 200 * ms).find('Z'), std::string::npos);

  bench::BoardProtocol asking({}, 0);
  asking.zero_stage();
  asking.receive(frame('V', version), 0);
  EXPECT_EQ(asking.due(1000 * ms).find('Z'), std::string::npos) << "it was not up";
}

/// The firmware on a line: requests are answered one a loop.
struct FirmwareLine {
  std::uint16_t knob = 0;
  quadrature signals{};
  std::string requests;
  Bytes sent;
  hal hardware{this,
               [](void* self) -> int {
                 std::string& waiting = of(self).requests;
                 if (waiting.empty()) return -1;
                 const int byte = static_cast<std::uint8_t>(waiting.front());
                 waiting.erase(0, 1);
                 return byte;
               },
               [](void* self, const std::uint8_t* bytes, std::uint8_t n) {
                 of(self).sent.insert(of(self).sent.end(), bytes, bytes + n);
               },
               [](void* self) { return of(self).knob; },
               [](void* self) { return quadrature_read_and_reset_counter(&of(self).signals); },
               [](void* self) { return quadrature_read_and_reset_lost(&of(self).signals); }};
  board firmware{};

  FirmwareLine() { board_start(&firmware, &hardware); }
  static FirmwareLine& of(void* self) { return *static_cast<FirmwareLine*>(self); }
};

/// The firmware's answer; P has the value `knob`.
Bytes answer(char request, std::uint16_t knob = 0)
{
  FirmwareLine line;
  line.knob = knob;
  line.requests = request;
  board_loop(&line.firmware);
  return line.sent;
}

TEST(Crc16, IsCcittFalse)
{
  const std::string digits = "123456789";  // the check value of the catalogue of CRCs
  EXPECT_EQ(crc16(reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size()), 0x29B1);
  EXPECT_EQ(crc16(nullptr, 0), 0xFFFF);
}

TEST(FirmwareFrames, OnlyRequestsAreAnsweredWithTheirFrames)
{
  int n_answered = 0;
  for (int byte = 0; byte < 256; ++byte) n_answered += answer(static_cast<char>(byte)).empty() ? 0 : 1;
  EXPECT_EQ(n_answered, 4);
  EXPECT_EQ(answer('P', 0x2A7), frame('P', {0xA7, 0x02}));
  EXPECT_EQ(answer('V'), frame('V', version));
}

/// Requests without a pause: the counter is still read between two answers.
TEST(FirmwareFrames, ABusyLineDelaysNoPoll)
{
  FirmwareLine line;
  line.requests = std::string(10, 'P') + "E";
  constexpr std::uint16_t moved = 30'000;  // twice this is more than the counter holds
  while (!line.requests.empty()) {
    line.signals.counter = static_cast<std::uint16_t>(line.signals.counter + moved);
    board_loop(&line.firmware);
  }
  EXPECT_EQ(line.firmware.position, 11 * moved);
  EXPECT_EQ(line.sent.size(), 10 * answer('P').size() + answer('E').size());
}

std::vector<int> values(bench::SerialFrameParser& frames)
{
  std::vector<int> found;
  while (const std::optional<bench::SerialFrame> frame = frames.next())
    found.push_back(frame->payload[0] | frame->payload[1] << 8);
  return found;
}

Bytes& operator+=(Bytes& to, const Bytes& more)
{
  to.insert(to.end(), more.begin(), more.end());
  return to;
}

TEST(SerialFrames, NoiseCostsTheFrameItHitsAndNoOther)
{
  // Any flipped bit in the second of three frames: the first and the third are received.
  const Bytes hit = answer('P', 0x0102);
  for (std::size_t bit = 0; bit < 8 * hit.size(); ++bit) {
    Bytes bytes = answer('P', 1);
    bytes += hit;
    bytes[hit.size() + bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    bytes += answer('P', 3);
    bytes += Bytes(board_longest_frame, 0);  // completes a frame whose length was increased
    bench::SerialFrameParser frames;
    frames.add(bytes);
    EXPECT_EQ(values(frames), (std::vector<int>{1, 3})) << "bit " << bit;
    EXPECT_GE(frames.n_noise_runs(), 1U);
  }
}

bench::TrackerSettings settings()
{
  bench::TrackerSettings settings;
  settings.tools = {"Femur", "Tibia"};
  return settings;
}

bench::IgtlMessage message(bench::IgtlKind kind, const std::string& device, std::int64_t device_ns,
                           const std::vector<std::string>& tools)
{
  bench::IgtlMessage message;
  message.kind = kind;
  message.device = device;
  message.device_ns = device_ns;
  for (const std::string& name : tools) {
    message.tools.push_back({name});
    // A pose that is measured again with each stamp.
    message.tools.back().X_tracker_tool.translation().x() = 1e-6 * static_cast<double>(device_ns);
  }
  return message;
}

bench::IgtlMessage femur(std::int64_t device_ns)
{
  return message(bench::IgtlKind::transform, "Femur", device_ns, {"Femur"});
}

/// Tool and state of each sample, as "0 seen 1 stale".
std::string summary(const std::vector<bench::Sample>& samples)
{
  static const char* const names[] = {"seen", "missing", "stale", "not_a_place"};
  std::string text;
  for (const bench::Sample& sample : samples)
    text += std::to_string(sample.source) + " " + names[sample.state] + " ";
  if (!text.empty()) text.pop_back();
  return text;
}

TEST(TrackerProtocol, AToolLeftOutOfItsListIsMissing)
{
  bench::TrackerProtocol protocol(settings(), 0);
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Tracker", 1, {"Femur"}), 0)),
            "0 seen 1 missing")
      << "never heard of";
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Tracker", 2, {"Femur", "Tibia"}), 1)),
            "0 seen 1 seen");
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Second", 3, {"Stylus"}), 2)), "")
      << "another tracker's list";
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::qtdata, "Tracker", 3, {}), 3)),
            "0 missing 1 missing");
  EXPECT_EQ(summary(protocol.receive(femur(4), 4)), "0 seen");
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Tracker", 5, {"Tibia"}), 5)), "1 seen")
      << "the femur has messages of its own";
}

TEST(TrackerProtocol, AStatusOfAToolIsAboutIt)
{
  bench::TrackerProtocol protocol(settings(), 0);
  bench::IgtlMessage status = message(bench::IgtlKind::status, "Tibia", 1, {});
  EXPECT_EQ(summary(protocol.receive(status, 0)), "");
  EXPECT_EQ(bench::error_text_of(status), "");
  status.code = 16;
  status.text = "not present";
  EXPECT_EQ(summary(protocol.receive(status, 1)), "1 missing");
  EXPECT_EQ(bench::error_text_of(status), "Tibia: status 16 (not present)");
  status.device = "Tracker";
  EXPECT_EQ(summary(protocol.receive(status, 2)), "");
  bench::IgtlMessage refusal = message(bench::IgtlKind::tdata_started, "Tracker", 1, {});
  EXPECT_EQ(bench::error_text_of(refusal), "Tracker: refuses to stream TDATA");
  refusal.code = 0;
  EXPECT_EQ(bench::error_text_of(refusal), "");
}

/// The states at the end of three periods of 150 ms: the tibia is absent, the clock does not advance,
/// silence.
std::string course(bench::IgtlKind kind)
{
  bench::TrackerProtocol protocol(settings(), 0);
  const bool is_list = kind == bench::IgtlKind::tdata || kind == bench::IgtlKind::qtdata;
  std::vector<std::string> state{"none", "none"};
  std::string text;
  const auto take = [&](const std::vector<bench::Sample>& samples) {
    for (const bench::Sample& sample : samples) state[sample.source] = summary({sample}).substr(2);
  };
  const auto send = [&](std::int64_t now_ms, const std::vector<std::string>& tools, std::int64_t stamp) {
    if (is_list) take(protocol.receive(message(kind, "Tracker", stamp, tools), now_ms * ms));
    for (const std::string& tool : tools)
      if (!is_list) take(protocol.receive(message(kind, tool, stamp, {tool}), now_ms * ms));
    take(protocol.stale_samples(now_ms * ms));
  };
  for (std::int64_t now_ms = 10; now_ms <= 900; now_ms += 10) {
    const std::int64_t phase = (now_ms - 1) / 150;
    const bool is_whole = phase % 2 == 0;
    if (phase < 5) {
      send(now_ms,
           is_whole || phase != 1 ? std::vector<std::string>{"Femur", "Tibia"}
                                  : std::vector<std::string>{"Femur"},
           phase == 3 ? 450 : now_ms);
    } else {
      take(protocol.stale_samples(now_ms * ms));
    }
    if (now_ms % 150 == 0) text += state[0] + " " + state[1] + "; ";
  }
  return text;
}

TEST(TrackerProtocol, AbsentAndStaleMeanTheSameForEveryType)
{
  for (const bench::IgtlKind kind : {bench::IgtlKind::transform, bench::IgtlKind::position,
                                     bench::IgtlKind::tdata, bench::IgtlKind::qtdata}) {
    SCOPED_TRACE(static_cast<int>(kind));
    EXPECT_EQ(course(kind), "seen seen; seen missing; seen seen; stale stale; seen seen; stale stale; ");
  }
}

TEST(TrackerProtocol, AFrozenListIsStaleForAToolThatItLacks)
{
  bench::TrackerProtocol protocol(settings(), 0);
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Tracker", 1, {"Femur"}), 0)),
            "0 seen 1 missing");
  EXPECT_EQ(summary(protocol.receive(message(bench::IgtlKind::tdata, "Tracker", 1, {"Femur"}), 50 * ms)), "");
  EXPECT_EQ(summary(protocol.stale_samples(100 * ms)), "0 stale 1 stale");
}

/// One message of the femur every 10 ms from `from_ms`, with advancing stamps; the state of the last sample.
std::string last_state(bench::TrackerProtocol& protocol, bench::IgtlMessage said, std::int64_t from_ms,
                       std::int64_t n, bool is_jittering)
{
  std::string state;
  for (std::int64_t k = 0; k < n; ++k) {
    said.device_ns = (from_ms + 10 * k + 1) * ms;
    if (is_jittering) said.tools[0].X_tracker_tool.translation().y() = 0.01 * static_cast<double>(k % 7);
    state = summary(protocol.receive(said, (from_ms + 10 * k) * ms));
  }
  return state;
}

/// What a server does with a hidden tool in header version 1: it repeats the last pose, or sends the
/// identity.
TEST(TrackerProtocol, ATrackedPoseThatFreezesIsHiddenUnlessTheServerStatesIt)
{
  struct Row {
    const char* name;
    bool has_jittered, becomes_identity, is_stated;
    const char *after_400_ms, *after_600_ms, *note;
  };
  for (const Row& row :
       {Row{"frozen", true, false, false, "0 seen", "0 stale", "taken as hidden"},
        Row{"identity", true, true, false, "0 seen", "0 stale", "taken as hidden"},
        Row{"identity from the start", false, true, false, "0 seen", "0 stale", "taken as hidden"},
        Row{"fixed from the start", false, false, false, "0 seen", "0 seen", "have not changed"},
        Row{"stated as seen", true, false, true, "0 seen", "0 seen", "the server states"},
        Row{"fixed and stated", false, false, true, "0 seen", "0 seen", nullptr}}) {
    for (const bench::IgtlKind kind : {bench::IgtlKind::transform, bench::IgtlKind::position,
                                       bench::IgtlKind::tdata, bench::IgtlKind::qtdata}) {
      SCOPED_TRACE(row.name);
      bench::TrackerProtocol protocol(settings(), 0);
      bench::IgtlMessage said = message(kind, "Femur", 1, {"Femur"});
      said.tools[0].is_stated = row.is_stated;
      said.tools[0].X_tracker_tool.translation() = Eigen::Vector3d(10.0, 20.0, 30.0);
      last_state(protocol, said, 0, row.has_jittered ? 100 : 0, true);
      EXPECT_TRUE(protocol.notes().empty());
      if (row.becomes_identity) said.tools[0].X_tracker_tool.setIdentity();
      EXPECT_THAT(last_state(protocol, said, 1000, 40, false), testing::StartsWith(row.after_400_ms));
      EXPECT_THAT(last_state(protocol, said, 1400, 20, false), testing::StartsWith(row.after_600_ms));
      EXPECT_THAT(protocol.notes(), row.note == nullptr
                                        ? testing::Matcher<std::vector<std::string>>(testing::IsEmpty())
                                        : testing::ElementsAre(testing::HasSubstr(row.note)));
      EXPECT_THAT(last_state(protocol, said, 1600, 3, true), testing::StartsWith("0 seen"));
      EXPECT_TRUE(protocol.notes().empty());
    }
  }
}

/// 3 s of a moving tool at 30 Hz, with stamps that do not follow it.
TEST(TrackerProtocol, StampsThatDoNotFollowThePosesAreReplacedByArrivals)
{
  struct Row {
    const char* name;
    std::int64_t (*stamp_ms)(std::int64_t now_ms);
    int least_seen;  ///< of 90
    bool uses_stamps;
    const char* note;
  };
  for (const Row& row :
       {Row{"good", [](std::int64_t t) { return t; }, 90, true, nullptr},
        Row{"since the start", [](std::int64_t t) { return t - 999; }, 90, true, nullptr},
        Row{"ahead", [](std::int64_t t) { return t + 3'600'000; }, 90, true, nullptr},
        Row{"zero", [](std::int64_t) { return std::int64_t{0}; }, 90, false, "no time stamps"},
        Row{"same", [](std::int64_t) { return std::int64_t{1000}; }, 80, false, "do not advance"},
        Row{"whole seconds", [](std::int64_t t) { return t / 1000 * 1000; }, 80, false, "do not advance"},
        Row{"tenths", [](std::int64_t t) { return t / 100 * 100; }, 70, false, "do not advance"},
        Row{"each twice", [](std::int64_t t) { return t / 66 * 66; }, 70, false, "do not advance"},
        Row{"back and forth", [](std::int64_t t) { return t % 2 == 0 ? t : t - 500; }, 70, false,
            "do not advance"},
        Row{"set back", [](std::int64_t t) { return t < 2500 ? t : t - 1500; }, 80, true, "went back"}}) {
    SCOPED_TRACE(row.name);
    bench::TrackerProtocol protocol(settings(), 0);
    int n_seen = 0;
    std::int64_t stamp_ns = 0;
    for (std::int64_t k = 0; k < 90; ++k) {
      const std::int64_t now_ms = 1000 + 33 * k;
      bench::IgtlMessage said = femur(row.stamp_ms(now_ms) * ms);
      said.tools[0].X_tracker_tool.translation().x() = static_cast<double>(k);
      for (const bench::Sample& sample : protocol.receive(said, now_ms * ms)) {
        n_seen += sample.is(bench::ToolVisibility::seen) ? 1 : 0;
        stamp_ns = sample.device_ns;
      }
    }
    EXPECT_GE(n_seen, row.least_seen);
    EXPECT_EQ(stamp_ns != 0, row.uses_stamps);
    EXPECT_THAT(protocol.notes(), row.note == nullptr
                                      ? testing::Matcher<std::vector<std::string>>(testing::IsEmpty())
                                      : testing::ElementsAre(testing::HasSubstr(row.note)));
  }
}

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

}  // namespace vrda::protocols_test
