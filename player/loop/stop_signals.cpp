#include "loop/stop_signals.hpp"

#include <algorithm>
#include <cstdint>

namespace vrda {

StopSignals::StopSignals()
{
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, &before_);
}

// What came is answered: it does not end the program when it is let through again.
StopSignals::~StopSignals()
{
  const timespec none{};
  while (sigtimedwait(&signals_, nullptr, &none) > 0) {
  }
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

bool StopSignals::came_by(std::chrono::steady_clock::time_point due)
{
  if (has_come_) return true;
  const std::chrono::nanoseconds left = due - std::chrono::steady_clock::now();
  const std::int64_t ns = std::max<std::int64_t>(0, left.count());
  const timespec wait{ns / 1'000'000'000, ns % 1'000'000'000};
  has_come_ = sigtimedwait(&signals_, nullptr, &wait) > 0;
  return has_come_;
}

}  // namespace vrda
