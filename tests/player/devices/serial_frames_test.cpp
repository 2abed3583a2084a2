#include "devices/board_talk.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

extern "C" {
#include "firmware/board.h"
}

namespace vrda::serial_frames_test {

using Bytes = std::vector<std::uint8_t>;

/// What the firmware answers, P holding `potentiometer`.
Bytes answer(char request, std::uint16_t potentiometer = 0)
{
  const hal hardware{&potentiometer,
                     nullptr,
                     nullptr,
                     [](void* self) { return *static_cast<std::uint16_t*>(self); },
                     [](void*) { return std::uint16_t{0}; },
                     [](void*) { return std::uint16_t{0}; }};
  board firmware;
  board_start(&firmware, &hardware);
  Bytes frame(board_longest_frame);
  frame.resize(board_answer(&firmware, static_cast<std::uint8_t>(request), frame.data()));
  return frame;
}

std::vector<int> values(SerialFrames& frames)
{
  std::vector<int> found;
  while (const std::optional<SerialFrame> frame = frames.next())
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
  SerialFrames frames;
  std::string requests;
  for (const char request : std::string("PEZV")) {
    for (const std::uint8_t byte : answer(request)) {
      frames.add({&byte, 1});
      while (const std::optional<SerialFrame> frame = frames.next()) requests += frame->request;
    }
  }
  EXPECT_EQ(requests, "PEZV");
  EXPECT_EQ(frames.n_noises(), 0U);
}

TEST(SerialFrames, NoiseCostsTheFrameItHitsAndNoOther)
{
  // Any bit of the second of three frames: the first and the third come through.
  const Bytes hit = answer('P', 0x0102);
  for (std::size_t bit = 0; bit < 8 * hit.size(); ++bit) {
    Bytes bytes = answer('P', 1);
    bytes += hit;
    bytes[hit.size() + bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    bytes += answer('P', 3);
    bytes += Bytes(board_longest_frame, 0);  // a length that was made longer is waited for
    SerialFrames frames;
    frames.add(bytes);
    EXPECT_EQ(values(frames), (std::vector<int>{1, 3})) << "bit " << bit;
    EXPECT_GE(frames.n_noises(), 1U);
  }
}

TEST(SerialFrames, StartsThatAreNoneAreStepsOnTheWay)
{
  Bytes bytes{0xA5, 0xA5, 0x5A, 0xA5,
              0x5A, 'P',  200,  0xA5};  // a mark within a mark; a length there is none of
  bytes += answer('P', 7);
  SerialFrames frames;
  frames.add(bytes);
  EXPECT_EQ(values(frames), std::vector<int>{7});
  EXPECT_EQ(frames.n_noises(), 1U);
}

TEST(SerialFrames, DroppedBytesAndNoiseLeaveTheOtherFrames)
{
  std::mt19937 random(5);
  int n_frames = 0, n_spoilt = 0, n_found = 0;
  SerialFrames frames;
  for (int n = 0; n < 2000; ++n) {
    Bytes bytes = answer('P', static_cast<std::uint16_t>(n % 1024));
    const unsigned draw = random() % 4;
    if (draw == 0) bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(random() % bytes.size()));
    if (draw == 1)
      bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(random() % (bytes.size() - 1) + 1),
                   static_cast<std::uint8_t>(random()));
    (draw < 2 ? n_spoilt : n_frames) += 1;
    frames.add(bytes);
    n_found += static_cast<int>(values(frames).size());
  }
  frames.add(Bytes(board_longest_frame, 0));
  n_found += static_cast<int>(values(frames).size());
  EXPECT_GT(n_spoilt, 800);
  // A frame with a byte too many in it can still hold, when that byte equals its neighbour.
  EXPECT_GE(n_found, n_frames);
  EXPECT_LE(n_found, n_frames + n_spoilt / 20);
  // Half of the spoilt ones follow another and join its noise.
  EXPECT_GT(frames.n_noises(), static_cast<std::uint64_t>(n_spoilt) * 2 / 5);
}

}  // namespace vrda::serial_frames_test
