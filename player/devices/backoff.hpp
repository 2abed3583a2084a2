/// How long to wait before trying again.
#pragma once

#include <algorithm>

namespace vrda {

/// Doubles from `first_ms` to 20 times that (0.1 s to 2 s), and stays there: a device that returns is met
/// within that time, and one that never does costs next to nothing.
class Backoff {
 public:
  explicit Backoff(double first_ms) : first_ms_(first_ms), next_ms_(first_ms) {}

  double next_ms()
  {
    const double now_ms = next_ms_;
    next_ms_ = std::min(2.0 * now_ms, 20.0 * first_ms_);
    return now_ms;
  }

  /// The peer has shown that it is what was looked for.
  void reset() { next_ms_ = first_ms_; }

 private:
  double first_ms_, next_ms_;
};

}  // namespace vrda
