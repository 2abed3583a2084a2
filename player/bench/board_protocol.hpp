/// Host side of the serial protocol (schemas/serial-protocol.md): framing, request schedule, decoding of
/// answers.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/devices.hpp"

namespace vrda::bench {

struct SerialFrame {
  char request = 0;
  std::uint8_t n = 0;  ///< bytes of the payload
  std::array<std::uint8_t, 16> payload{};
  bool operator==(const SerialFrame&) const = default;
};

/// Extracts frames from a byte stream. Resynchronises byte by byte after noise, so only the damaged frame
/// is lost.
class SerialFrameParser {
 public:
  void add(std::span<const std::uint8_t> bytes);
  /// The next frame with a valid checksum; nullopt until more bytes arrive.
  std::optional<SerialFrame> next();
  /// Runs of bytes that belonged to no frame.
  std::uint64_t n_noise_runs() const { return n_noises_; }

 private:
  enum class ParseState { frame, noise, incomplete };
  ParseState parse_state() const;
  std::span<const std::uint8_t> unparsed() const { return std::span(buffer_).subspan(begin_); }

  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;  ///< start of the unprocessed bytes
  bool is_in_noise_ = false;
  std::uint64_t n_noises_ = 0;
};

/// One session on an open serial port. Pure: the caller passes times in and sends the returned bytes.
/// Requests the version first. Then requests all readings `rate_hz` times a second without waiting for the
/// answers: 8 bytes for P and 11 for E take 1.7 ms at 115,200 baud. Two requests of a kind may be
/// outstanding, since adapters delay answers by up to 16 ms; more would only queue on a slow line.
class BoardProtocol {
 public:
  enum class Phase {
    requesting_version,  ///< waiting for the version
    up,                  ///< version and board tag match
    failed               ///< `error_message` gives the reason: reopen the port later
  };
  static constexpr std::int64_t request_timeout_ns =
      50'000'000;  ///< protocol timeout: the request is repeated
  /// Boards that reset when the port is opened need up to 2 s.
  static constexpr int max_version_requests = 100;
  /// No answer for this long: the board is treated as disconnected although the port is open.
  static constexpr std::int64_t board_timeout_ns = 1'000'000'000;

  BoardProtocol(const BoardSettings& settings, std::int64_t now_ns);

  /// Requests to be sent now.
  std::string due(std::int64_t now_ns);
  /// Time of the next request.
  std::int64_t next_due_ns() const;
  std::vector<Sample> receive(std::span<const std::uint8_t> bytes, std::int64_t now_ns);
  /// Requests a stage zero at the next due(), repeated until answered. Ignored while the board is not up: a
  /// delayed zero could be applied after the stage has moved.
  void zero_stage() { is_zero_pending_ = is_zero_pending_ || phase_ == Phase::up; }

  Phase phase() const { return phase_; }
  const std::string& error_message() const { return error_message_; }
  /// Runs of noise, and frames that are not valid answers.
  std::uint64_t n_refused() const { return n_refused_ + frames_.n_noise_runs(); }

 private:
  struct Reading {
    char request = 'P';
    int n_outstanding = 0;
    std::array<std::int64_t, 2> sent_ns{};  ///< oldest first
  };
  void fail(const std::string& error_message);
  std::string due_version(std::int64_t now_ns);
  std::string due_reading(Reading& reading, bool is_round, std::int64_t now_ns);
  void handle_version(const SerialFrame& frame, std::int64_t now_ns);
  bool handle_reading(const SerialFrame& frame, Sample& sample);

  std::vector<Reading> readings_;
  std::int64_t period_ns_;
  Phase phase_ = Phase::requesting_version;
  std::string error_message_;
  SerialFrameParser frames_;
  std::int64_t next_ns_;  ///< next version request, or next round of readings
  int n_version_requests_ = 0;
  std::int64_t last_answer_ns_ = 0;
  bool is_zero_pending_ = false;
  std::int64_t zero_retry_ns_ = 0;
  std::uint64_t n_refused_ = 0;
};

}  // namespace vrda::bench
