/// What a run needed: times and machine. Kept beside the motion model, which holds none of it.
#pragma once

#include <chrono>
#include <string>

namespace vrda {

class RunRecord {
 public:
  /// The clock starts now.
  RunRecord(int n_threads, int n_recalled);

  /// All steps are solved; what follows is smoothing and writing.
  void note_solved();

  /// Writes JSON: seconds, of them solving (by the clock, and of all threads), threads, steps recalled, host,
  /// processors, date (UTC).
  void write(const std::string& path) const;

 private:
  std::chrono::system_clock::time_point begun_;
  std::chrono::steady_clock::time_point start_;
  double processor_start_s_;
  std::chrono::duration<double> solving_{0.0};
  double solving_processor_s_ = 0.0;
  int n_threads_;
  int n_recalled_;
};

}  // namespace vrda
