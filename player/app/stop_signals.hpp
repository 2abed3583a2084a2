/// Ctrl-C as something to wait for.
#pragma once

#include <signal.h>

#include <chrono>

namespace vrda {

/// Keeps SIGINT and SIGTERM from ending the program, for as long as it lives. Threads begun meanwhile keep
/// them too.
class StopSignals {
 public:
  StopSignals();
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

  /// Whether one came, within `patience` or at any time before.
  bool came_within(std::chrono::milliseconds patience);

 private:
  sigset_t signals_{}, before_{};
  bool has_come_ = false;
};

}  // namespace vrda
