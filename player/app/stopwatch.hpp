/// Time between the frames of a window.
#pragma once

#include <algorithm>
#include <chrono>

namespace vrda {

class Stopwatch {
 public:
  double running_s() const
  {
    const std::chrono::duration<double> since = std::chrono::steady_clock::now() - start_;
    return std::min(since.count(), longest_s);
  }
  /// Begins anew; how long it ran.
  double lap_s()
  {
    const double s = running_s();
    start_ = std::chrono::steady_clock::now();
    return s;
  }

 private:
  static constexpr double longest_s = 10.0;  ///< a machine that slept is not time that was seen

  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace vrda
