#include <gtest/gtest.h>

#include <cstdint>
#include <deque>
#include <random>
#include <string>
#include <vector>

#include "bench/board.h"

namespace {

/// Test bench: encoder signals from the stage's position, a serial line as a queue of bytes.
class Bench {
 public:
  Bench()
  {
    quadrature_start(&signals_, false, false);
    board_start(&board_, &hal_);
  }
  Bench(const Bench&) = delete;
  Bench& operator=(const Bench&) = delete;

  /// Moves the stage count by count; the state at count n is the n-th of 00, 10, 11, 01 (A leads).
  void move_to(int count)
  {
    while (count_ != count) {
      count_ += count > count_ ? 1 : -1;
      const int phase = ((count_ % 4) + 4) % 4;
      quadrature_edge(&signals_, phase == 1 || phase == 2, phase == 2 || phase == 3);
    }
  }
  void jump(int counts) { count_ += counts; }
  void loop() { board_loop(&board_); }
  void receive(char request) { received_.push_back(static_cast<std::uint8_t>(request)); }
  std::size_t n_sent() const { return sent_.size(); }
  std::vector<std::uint8_t> ask(char request)
  {
    receive(request);
    sent_.clear();
    loop();
    return sent_;
  }
  std::int32_t position()
  {
    const std::vector<std::uint8_t> frame = ask('E');
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(frame.at(4 + i)) << (8 * i);
    return static_cast<std::int32_t>(value);
  }
  int flags() { return ask('E').at(8); }

  std::uint16_t potentiometer = 0;

 private:
  quadrature signals_{};
  std::deque<std::uint8_t> received_;
  std::vector<std::uint8_t> sent_;
  int count_ = 0;
  hal hal_{this,
           [](void* self) -> int {
             auto& waiting = static_cast<Bench*>(self)->received_;
             if (waiting.empty()) return -1;
             const int byte = waiting.front();
             waiting.pop_front();
             return byte;
           },
           [](void* self, const std::uint8_t* bytes, std::uint8_t n) {
             auto& sent = static_cast<Bench*>(self)->sent_;
             sent.insert(sent.end(), bytes, bytes + n);
           },
           [](void* self) { return static_cast<Bench*>(self)->potentiometer; },
           [](void* self) { return quadrature_read_and_reset_counter(&static_cast<Bench*>(self)->signals_); },
           [](void* self) { return quadrature_read_and_reset_lost(&static_cast<Bench*>(self)->signals_); }};
  board board_{};
};

TEST(Crc16, IsCcittFalse)
{
  const std::string digits = "123456789";  // the check value of the catalogue of CRCs
  EXPECT_EQ(crc16(reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size()), 0x29B1);
  EXPECT_EQ(crc16(nullptr, 0), 0xFFFF);
}

TEST(Quadrature, CountsEveryEdgeInItsDirection)
{
  Bench bench;
  for (const int count : {1, 2, 3, 4, 9, 8, 0, -1, -7, 20000, -12345}) {
    bench.move_to(count);
    EXPECT_EQ(bench.position(), count);
  }
  EXPECT_EQ(bench.flags() & board_flag_lost, 0);
}

TEST(Quadrature, AStepOverTwoStatesIsCountedAsLostUntilTheNextZero)
{
  Bench bench;
  bench.move_to(5);
  bench.jump(1);     // a missed edge
  bench.move_to(7);  // two states after the last one seen
  EXPECT_EQ(bench.position(), 5);
  EXPECT_EQ(bench.flags(), board_flag_lost);
  bench.ask('Z');
  EXPECT_EQ(bench.flags(), board_flag_zeroed);
}

TEST(Board, PositionsGrowBeyondTheCounterAsLongAsItIsReadInTime)
{
  Bench bench;
  std::mt19937 random(3);
  std::uniform_int_distribution<int> step(-20000, 32767);  // range of the 16-bit counter
  int count = 0, furthest = 0;
  for (int n = 0; n < 60; ++n) {
    count += step(random);
    bench.move_to(count);
    bench.loop();
    furthest = std::max(furthest, count);
    EXPECT_EQ(bench.position(), count);
  }
  EXPECT_GT(furthest, 1 << 17);
}

/// Requests without a pause: the counter is still read between two answers.
TEST(Board, ABusyLineDelaysNoPoll)
{
  Bench bench;
  constexpr int n_requests = 10;
  for (int n = 0; n < n_requests; ++n) bench.receive('P');
  const std::size_t frame_bytes = bench.ask('P').size();
  int count = 0;
  for (int n = 1; n < n_requests; ++n) {
    count += 30'000;  // twice this is more than the counter holds
    bench.move_to(count);
    bench.loop();
    EXPECT_EQ(bench.n_sent(), (static_cast<std::size_t>(n) + 1) * frame_bytes);
  }
  bench.loop();  // the request of ask()
  EXPECT_EQ(bench.position(), count);
}

TEST(Board, ZeroReturnsThePlaceBeforeAndCountsOnFromThere)
{
  Bench bench;
  bench.move_to(300);
  const std::vector<std::uint8_t> frame = bench.ask('Z');
  EXPECT_EQ(frame.at(4) | frame.at(5) << 8, 300);
  EXPECT_EQ(bench.position(), 0);
  bench.move_to(310);
  EXPECT_EQ(bench.position(), 10);
}

TEST(Board, FramesAreAsSpecified)
{
  Bench bench;
  bench.potentiometer = 0x2A7;
  const std::vector<std::uint8_t> frame = bench.ask('P');
  ASSERT_EQ(frame.size(), 8U);
  EXPECT_EQ(frame[0], 0xA5);
  EXPECT_EQ(frame[1], 0x5A);
  EXPECT_EQ(frame[2], 'P');
  EXPECT_EQ(frame[3], 2);
  EXPECT_EQ(frame[4] | frame[5] << 8, 0x2A7);
  EXPECT_EQ(frame[6] | frame[7] << 8, crc16(frame.data() + 2, 4));
  const std::vector<std::uint8_t> version = bench.ask('V');
  EXPECT_EQ(version.at(4), board_protocol_version);
  EXPECT_EQ(std::string(version.begin() + 5, version.begin() + 9), "VRDA");
}

TEST(Board, WhatIsNoRequestGetsNoAnswer)
{
  Bench bench;
  int n_answered = 0;
  for (int byte = 0; byte < 256; ++byte) n_answered += bench.ask(static_cast<char>(byte)).empty() ? 0 : 1;
  EXPECT_EQ(n_answered, 4);
}

}  // namespace
