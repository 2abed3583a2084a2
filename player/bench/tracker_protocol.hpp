/// Tool poses from a tracker's messages, and detection of stale tools.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bench/devices.hpp"
#include "bench/message.hpp"

namespace vrda::bench {

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

  std::vector<Sample> receive(const bench::IgtlMessage& message, std::int64_t now_ns);
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
  Sample observed_sample(Tool& tool, const bench::IgtlTool* observed, const bench::IgtlMessage& message,
                         std::int64_t now_ns);

  std::int64_t stale_after_ns_;
  std::int64_t last_news_ns_;  ///< of any tool
  std::vector<Tool> tools_;
  bool uses_arrival_ = false;  ///< the stamps do not follow the poses
  bool has_gone_back_ = false, has_no_stamps_ = false;
};

/// Error text of a STATUS or RTS_TDATA message; empty if OK or another message.
std::string error_text_of(const bench::IgtlMessage& message);

}  // namespace vrda::bench
