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

  /// Whether one came; waits for it until `due`.
  bool came_by(std::chrono::steady_clock::time_point due);

 private:
  sigset_t signals_{}, before_{};
  bool has_come_ = false;
};

}  // namespace vrda
