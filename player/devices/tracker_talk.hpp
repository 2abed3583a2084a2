/// What a tracker's messages say of the tools that are asked for, and when a tool's last place is too old to
/// be believed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "devices/devices.hpp"
#include "igtl/message.hpp"

namespace vrda {

/// Follows the two clocks of one tool: the device's time stamps, and arrivals.
/// - A place counts where its stamp is later than the last that counted, or where the device gives none (0).
/// - The same stamp again is nothing new: a tracker that repeats itself goes stale.
/// - An earlier stamp is behind: the clock was set back, or the last one was a leap ahead. It counts for
/// nothing until it
///   passes the last one that did, or until n_to_believe in a row, each later than the one before, say that
///   this is the clock now.
class ToolWatch {
 public:
  enum class Heard { counts, repeated, behind };
  static constexpr int n_to_believe = 8;  ///< 80 ms at 100 Hz

  ToolWatch(std::int64_t stale_after_ns, std::int64_t now_ns)
      : stale_after_ns_(stale_after_ns), last_news_ns_(now_ns)
  {
  }

  Heard hear(std::int64_t device_ns, std::int64_t now_ns);
  /// The tracker said that it does not see the tool: news, though not of a place.
  void hear_missing(std::int64_t now_ns) { last_news_ns_ = now_ns; }
  /// True where nothing new came for so long; again after as long, lest a listener missed it.
  bool falls_stale(std::int64_t now_ns);

 private:
  std::int64_t stale_after_ns_;
  std::int64_t last_news_ns_;    ///< or last said to be stale
  std::int64_t counted_ns_ = 0;  ///< the last stamp that counted; 0: none
  std::int64_t last_behind_ns_ = 0;
  int n_behind_ = 0;  ///< in a row, each later than the one before
};

/// Pure: times are handed in.
/// - Tools are known by name: the device of a TRANSFORM or POSITION, an element's of TDATA and QTDATA.
/// - A tool that a list leaves out is missing, unless its places come from elsewhere: by another device's
/// list, or by messages
///   of its own.
/// - A STATUS other than OK whose device is a tool says that it is missing; of any other device it is told as
/// trouble.
class TrackerTalk {
 public:
  TrackerTalk(const TrackerSettings& settings, std::int64_t now_ns);

  std::vector<Sample> hear(const IgtlMessage& message, std::int64_t now_ns);
  /// Those that have fallen stale.
  std::vector<Sample> pass_time(std::int64_t now_ns);

 private:
  struct Tool {
    std::string name;
    ToolWatch watch;
    bool is_heard = false;
    std::optional<std::string> list = std::nullopt;  ///< device of the list that told of it last
  };
  Sample sample_of(const Tool& tool, SeenState state, std::int64_t now_ns) const;
  Sample heard(Tool& tool, const IgtlTool& said, const IgtlMessage& message, std::int64_t now_ns) const;

  std::vector<Tool> tools_;
};

/// What a STATUS says that is worth telling, empty for OK and other messages.
std::string trouble_of(const IgtlMessage& message);

}  // namespace vrda
