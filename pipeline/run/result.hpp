/// From a finished sweep to the file that is all there is to keep, and beside it what the run needed.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "load/case.hpp"
#include "store/motion_model.hpp"
#include "sweep/sweep.hpp"
#include "talk/talk.hpp"

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

/// The motion model with all that its job asks for: smoothed surfaces, flexion-only motion. `output` is for
/// messages. The same bytes however the steps came about. Nothing when `is_stopped`, which is asked before
/// each surface, says so.
std::optional<MotionModel> result_of(const Case& job_case, const SweepResult& result,
                                     const std::string& output, int n_threads,
                                     const std::function<bool()>& is_stopped);

/// Ends a command whose result is at `output` already, as write_result does, with what a killed run has left
/// to do: needless files go, and a record is written where there is none.
ExitCode keep_result(const Case& job_case, const MotionModel& model, const std::string& output,
                     const std::vector<std::string>& needless, int n_threads);

/// Writes the model, then removes the journals and start file it makes needless, then leaves `record` beside
/// it. Prints the output's path. Too many unsolved attitudes are an exit code, not an error.
ExitCode write_result(const Case& job_case, const MotionModel& model, const std::string& output,
                      const std::vector<std::string>& needless, const RunRecord& record);

}  // namespace vrda
