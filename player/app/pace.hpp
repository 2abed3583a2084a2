/// The loop's pace.
#pragma once

#include <chrono>
#include <thread>

namespace vrda {

/// Wakes at even times; where a picture took longer than its time the next comes at once. More than one that
/// was missed is not made up for.
class Pace {
 public:
  explicit Pace(double rate_hz)
      : period_(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(1.0 / rate_hz)))
  {
  }
  void wait()
  {
    next_ += period_;
    const Clock::time_point now = Clock::now();
    if (next_ + period_ < now) next_ = now;
    std::this_thread::sleep_until(next_);
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::duration period_;
  Clock::time_point next_ = Clock::now();
};

}  // namespace vrda
