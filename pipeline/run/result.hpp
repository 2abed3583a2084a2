/// From a finished sweep to the motion model file: smooths, measures, writes atomically, and reports warnings
/// and the exit code; and the record of the run's seconds, threads and host (<output>.run.json). Throws
/// InputError naming the file if the disk refuses it.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "analysis/audit.hpp"
#include "analysis/compare.hpp"
#include "core/console.hpp"
#include "job/case.hpp"
#include "solve/sweep.hpp"
#include "store/motion_model.hpp"

namespace vrda::run {

/// Name of the phase whose seconds the record states.
inline constexpr const char* solving_phase = "solving";

class RunRecord {
 public:
  /// Starts the clock.
  RunRecord(int n_threads, int n_recalled);

  /// Ends the current phase and starts the next.
  void end_phase(const std::string& name);

  /// Writes JSON: total, solving and CPU seconds, threads, steps recalled, host, processors, date (UTC).
  void write(const std::string& path) const;
  /// The phases with their seconds, processor time of all threads and its share, to stderr.
  void report_profile() const;

 private:
  struct Phase {
    std::string name;
    double seconds = 0.0, processor_s = 0.0;
  };
  Phase elapsed() const;

  std::chrono::system_clock::time_point started_;
  std::chrono::steady_clock::time_point start_;
  double processor_start_s_;
  std::vector<Phase> phases_;
  int n_threads_;
  int n_recalled_;
};

/// The motion model with the smoothed surfaces and flexion-only motion of its job; `samples` are the records
/// of all samples of an uncertain job. `output` is for messages.
/// The bytes do not depend on threads, shards or interruptions. Empty if `is_stopped`, which is polled before
/// each surface, returns true.
std::optional<store::MotionModel> build_result(const job::Case& job_case, const solve::SweepResult& result,
                                               const std::vector<StepRecord>& samples,
                                               const std::string& output, int n_threads,
                                               const std::function<bool()>& is_stopped, RunRecord& record);

/// Like write_result() for a result that is already at `output`: finishes the work of a killed run by
/// removing the `needless` files and writing a missing record.
core::ExitCode finish_existing_result(const job::Case& job_case, const store::MotionModel& model,
                                      const std::string& output, const std::vector<std::string>& needless,
                                      int n_threads);

/// Writes the model, removes the `needless` journals and start file and writes `record` next to the model.
/// Too many unsolved attitudes are an exit code, not an error.
core::ExitCode write_result(const job::Case& job_case, const store::MotionModel& model,
                            const std::string& output, const std::vector<std::string>& needless,
                            RunRecord& record);

// Decides which motion of a model is its default: the smoothed one only if it meets the criteria of
// `vrda compare`. Also measures the contact of smoothed motions for these criteria.

/// Measures the motion of a degree in contact: two-sided with compartments, else after recontact along Delta,
/// at and halfway between the attitudes of the grid.
analysis::MeasureContact contact_measure(const analysis::Measuring& with);

/// The first of store::set_names(model) if that is not smoothed, or if its degree has no fault in a
/// comparison of the model's degrees (of its smoothed sets and of its two-sided motion); otherwise "raw" with
/// the fault. The reason is that of analysis/compare.hpp. Bitwise equal for any number of threads. Cost: a
/// fit per degree and, but for the degree of the two-sided motion, moving it into contact.
store::DefaultMotion evaluated_default_motion(const store::MotionModel& model, bool is_robust, int n_threads);

/// `model` with its default motion decided, and with the statement of its prior.
store::MotionModel with_default_motion(store::MotionModel model, bool is_robust, int n_threads);

/// "default motion: raw, the solved poses; two_sided (degree 4) does not meet ..."; for a model that was not
/// compared with a remark.
std::string default_motion_line(const store::MotionModel& model);

/// "screw-home along the spine: net ...": rotation of a knee along the spine (store/solved_cells.hpp).
/// Empty for other joints.
std::string screw_home_line(const store::MotionModel& model);

/// The raw motion's jumps: of theta along the spine (store/solved_cells.hpp), and of the pose if it is too
/// large for any polynomial and the default motion's reason does not name it. May be empty.
std::vector<std::string> jump_lines(const store::MotionModel& model);

}  // namespace vrda::run
