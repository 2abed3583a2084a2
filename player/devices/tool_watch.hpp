/// When a tool's last place is too old to be believed.
#pragma once

#include <cstdint>

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

}  // namespace vrda
