/// Host side of the serial protocol (schemas/serial-protocol.md): framing, request schedule, decoding of
/// answers.
#pragma once

#include "bench/devices.hpp"

namespace vrda::bench {

/// The board's answer to a request.
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
  /// The next bytes of the connection, in order.
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
  /// Readings in the bytes that arrived at `now_ns`.
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

// Tool poses from a tracker's messages, and detection of stale tools.

/// Tracks the two clocks of one tool: device time stamps and arrival times.
/// - A pose is accepted if its stamp is later than the last accepted one, or 0 (no stamp).
/// - A repeated stamp carries no news: the tool becomes stale.
/// - An earlier stamp is `behind`: the clock was set back, or the last stamp was an outlier. It is rejected
///   until it passes the last accepted one, or until n_to_accept_clock in a row, each later than the one
///   before, show that the clock was reset.
class ToolMonitor {
 public:
  enum class StampCheck { accepted, repeated, behind };
  static constexpr int n_to_accept_clock = 8;  ///< 80 ms at 100 Hz

  ToolMonitor(std::int64_t stale_after_ns, std::int64_t now_ns)
      : stale_after_ns_(stale_after_ns), last_news_ns_(now_ns)
  {
  }

  StampCheck receive_stamp(std::int64_t device_ns, std::int64_t now_ns);
  /// True if nothing new arrived for `stale_after_ns`; true again after each further period.
  bool becomes_stale(std::int64_t now_ns);

 private:
  std::int64_t stale_after_ns_;
  std::int64_t last_news_ns_;     ///< or time of the last stale report
  std::int64_t accepted_ns_ = 0;  ///< last accepted stamp; 0: none
  std::int64_t last_behind_ns_ = 0;
  int n_behind_ = 0;  ///< in a row, each later than the one before
};

/// Tracks the numbers of one tool. A measured pose always jitters; a server that states no visibility repeats
/// the last pose of a hidden tool, or sends the identity, with new time stamps.
class PoseMonitor {
 public:
  enum class PoseCheck {
    changing,
    constant,  ///< bit-identical since the first one: a fixed reference, a simulated tracker, or hidden
    frozen     ///< bit-identical after it has changed, or the identity: hidden
  };
  static constexpr std::int64_t frozen_after_ns = 500'000'000;

  PoseCheck receive(const ToolPose& pose, std::int64_t now_ns);
  /// Whether `pose` differs from the last one by more than float32 rounding: 1e-3 mm, 1e-5 rad.
  bool has_moved(const ToolPose& pose) const;

 private:
  ToolPose last_;
  std::int64_t changed_ns_ = 0;  ///< when `last_` was received first
  bool has_last_ = false, has_changed_ = false;
};

/// Pure: times are passed in.
/// - Tools are matched by name: the device of a TRANSFORM or POSITION, or an element of TDATA and QTDATA.
/// - `missing`: there is news of the tracker, but not of the tool. A tool absent from a list is missing at
/// once,
///   unless its poses come from another device's list or separate messages; a tool with messages of its own
///   after `stale_after_ms`.
/// - `stale`: no news of any tool for that time. A message of a repeated time stamp is no news, whatever its
///   type and whether or not it contains the tool.
/// - `stale`: also a tool whose numbers stay bit-identical for PoseMonitor::frozen_after_ns while messages
///   arrive, unless their meta data state that it is visible.
/// - Time stamps that do not advance while the poses move are not used: the samples have stamp 0.
/// - A STATUS other than OK from a tool marks it missing; from another device it is reported as an error.
class TrackerProtocol {
 public:
  TrackerProtocol(const TrackerSettings& settings, std::int64_t now_ns);

  /// Samples of the tools that the message is about, with their arrival `now_ns`.
  std::vector<Sample> receive(const IgtlMessage& message, std::int64_t now_ns);
  /// Samples of the tools that became stale, or missing while others have news.
  std::vector<Sample> stale_samples(std::int64_t now_ns);
  /// A new connection: what was learnt about the sender's stamps and poses is forgotten.
  void begin_connection();
  /// What is odd about the messages of this connection: stamps that are not used, numbers that do not change.
  std::vector<std::string> notes() const;

 private:
  struct Tool {
    std::string name;
    ToolMonitor watch;
    bool was_received = false;
    std::optional<std::string> list = std::nullopt;  ///< device of the list that last contained it
    PoseMonitor pose = {};
    PoseMonitor::PoseCheck numbers = PoseMonitor::PoseCheck::changing;
    bool is_stated = false;  ///< the sender states the visibility
    int doubt = 0;           ///< about the stamps, see check_stamp()
  };
  ToolMonitor::StampCheck check_stamp(Tool& tool, const ToolPose* place, std::int64_t device_ns,
                                      std::int64_t now_ns);
  Sample sample_of(const Tool& tool, ToolVisibility state, std::int64_t now_ns) const;
  Sample observed_sample(Tool& tool, const IgtlTool* observed, const IgtlMessage& message,
                         std::int64_t now_ns);

  std::int64_t stale_after_ns_;
  std::int64_t last_news_ns_;  ///< of any tool
  std::vector<Tool> tools_;
  bool uses_arrival_ = false;  ///< the stamps do not follow the poses
  bool has_gone_back_ = false, has_no_stamps_ = false;
};

/// Error text of a STATUS or RTS_TDATA message; empty if OK or another message.
std::string error_text_of(const IgtlMessage& message);

}  // namespace vrda::bench
