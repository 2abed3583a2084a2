/// The computer's side of the serial protocol (schemas/serial-protocol.md): frames, when to ask, and what the
/// answers say.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "devices/devices.hpp"

namespace vrda {

struct SerialFrame {
  char request = 0;
  std::uint8_t n = 0;  ///< bytes of the payload
  std::array<std::uint8_t, 16> payload{};
  bool operator==(const SerialFrame&) const = default;
};

/// What is no frame is dropped byte by byte, so that noise costs the frame it hits and no other.
class SerialFrames {
 public:
  void add(std::span<const std::uint8_t> bytes);
  /// The next frame with a right checksum; nothing until more bytes come.
  std::optional<SerialFrame> next();
  /// Runs of bytes that belonged to no frame.
  std::uint64_t n_noises() const { return n_noises_; }

 private:
  enum class Look { frame, noise, more };
  Look look() const;
  std::span<const std::uint8_t> waiting() const { return std::span(buffer_).subspan(begin_); }

  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;  ///< of what is not used yet
  bool is_in_noise_ = false;
  std::uint64_t n_noises_ = 0;
};

/// One opening of the line. Pure: times are handed in, bytes handed out.
/// Asks for the version first. Then, `rate_hz` times a second, all readings in one go without waiting for the
/// answers: 8 bytes for P and 11 for E are 1.7 ms at 115,200 baud. Two of a kind may be on their way, for
/// adapters that keep answers back for up to 16 ms; more would only queue up on a slow line, which instead is
/// read as fast as it goes.
class BoardTalk {
 public:
  enum class Phase {
    asking,   ///< for the version
    up,       ///< it is the board that was looked for
    given_up  ///< `trouble` says why: open the line anew, later
  };
  static constexpr std::int64_t late_ns = 50'000'000;  ///< of the protocol: then it is asked again
  /// Boards that start anew when the line is opened take up to 2 s for it.
  static constexpr int most_version_requests = 100;
  /// Without any answer: the board is gone, though its line is there.
  static constexpr std::int64_t silent_ns = 1'000'000'000;

  BoardTalk(const BoardSettings& settings, std::int64_t now_ns);

  /// Requests to be sent now.
  std::string due(std::int64_t now_ns);
  /// When due() has more to say.
  std::int64_t next_due_ns() const;
  std::vector<Sample> hear(std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  /// From the next due() on, until it is answered. Nothing while the board is not up: a stage that is set to
  /// zero later than asked for may have moved.
  void zero_stage() { is_zero_wanted_ = is_zero_wanted_ || phase_ == Phase::up; }

  Phase phase() const { return phase_; }
  const std::string& trouble() const { return trouble_; }
  /// Noise, and frames that are no answer.
  std::uint64_t n_refused() const { return n_refused_ + frames_.n_noises(); }

 private:
  struct Reading {
    char request = 'P';
    int n_on_their_way = 0;
    std::array<std::int64_t, 2> asked_ns{};  ///< the oldest first
  };
  void give_up(const std::string& trouble);
  std::string due_version(std::int64_t now_ns);
  std::string due_reading(Reading& reading, bool is_round, std::int64_t now_ns);
  void hear_version(const SerialFrame& frame, std::int64_t now_ns);
  bool hear_reading(const SerialFrame& frame, Sample& sample);

  std::vector<Reading> readings_;
  std::int64_t period_ns_;
  Phase phase_ = Phase::asking;
  std::string trouble_;
  SerialFrames frames_;
  std::int64_t next_ns_;  ///< the version's next request, or the next round of readings
  int n_version_requests_ = 0;
  std::int64_t last_answer_ns_ = 0;
  bool is_zero_wanted_ = false;
  std::int64_t zero_again_ns_ = 0;
  std::uint64_t n_refused_ = 0;
};

}  // namespace vrda
