/// What a run needed: times and machine. Kept beside the motion model, which holds none of it.
#pragma once

#include <chrono>
#include <string>

namespace vrda {

class RunRecord {
 public:
  /// The clock starts now.
  RunRecord(int n_threads, int n_recalled);

  /// Writes JSON: seconds, threads, steps recalled, host, processors, date (UTC).
  void write(const std::string& path) const;

 private:
  std::chrono::system_clock::time_point begun_;
  std::chrono::steady_clock::time_point start_;
  int n_threads_;
  int n_recalled_;
};

}  // namespace vrda
