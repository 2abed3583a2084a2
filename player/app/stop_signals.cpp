#include "app/stop_signals.hpp"

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

bool StopSignals::came_within(std::chrono::milliseconds patience)
{
  if (has_come_) return true;
  const timespec wait{patience.count() / 1000, patience.count() % 1000 * 1'000'000};
  has_come_ = sigtimedwait(&signals_, nullptr, &wait) > 0;
  return has_come_;
}

}  // namespace vrda
