#include "bench/protocols.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "bench/board.h"

namespace vrda::board_protocol_test {

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

TEST(BoardProtocol, ReadingsSayWhatTheBoardSaid)
{
  bench::BoardProtocol protocol = protocol_that_is_up();
  Bytes bytes = frame('P', {0xFF, 0x03});
  const Bytes stage = frame('E', {0xFE, 0xFF, 0xFF, 0xFF, 3});
  bytes.insert(bytes.end(), stage.begin(), stage.end());
  const std::vector<bench::Sample> samples = protocol.receive(bytes, 9);
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[0].kind, bench::SampleKind::potentiometer);
  EXPECT_EQ(samples[0].count, 1023);
  EXPECT_EQ(samples[0].arrival_ns, 9);
  EXPECT_EQ(samples[1].kind, bench::SampleKind::stage);
  EXPECT_EQ(samples[1].count, -2);
  EXPECT_EQ(samples[1].state, bench::stage_zeroed | bench::stage_lost_counts);
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

TEST(BoardProtocol, FailsOnABoardThatStopsAnswering)
{
  bench::BoardProtocol protocol = protocol_that_is_up();
  std::int64_t now_ns = protocol.next_due_ns();
  const std::int64_t begin_ns = now_ns;
  while (protocol.phase() == bench::BoardProtocol::Phase::up) {
    protocol.due(now_ns);
    ASSERT_GT(protocol.next_due_ns(), now_ns);
    now_ns = protocol.next_due_ns();
    ASSERT_LT(now_ns, begin_ns + 2000 * ms);
  }
  EXPECT_EQ(protocol.error_message(), "found no answer for 1 s, wanted readings");
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

TEST(SerialFrames, ReadsEveryAnswerOfTheFirmwareByteByByte)
{
  bench::SerialFrameParser frames;
  std::string requests;
  for (const char request : std::string("PEZV")) {
    for (const std::uint8_t byte : answer(request)) {
      frames.add({&byte, 1});
      while (const std::optional<bench::SerialFrame> frame = frames.next()) requests += frame->request;
    }
  }
  EXPECT_EQ(requests, "PEZV");
  EXPECT_EQ(frames.n_noise_runs(), 0U);
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

}  // namespace vrda::board_protocol_test
