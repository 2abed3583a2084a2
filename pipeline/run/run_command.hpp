/// `vrda run`: solves a job and writes its motion model. In: job and mesh files. Out: <output>,
/// <output>.run.json, while running a start file and a journal, from which a repeated command resumes. Throws
/// InputError for input that is refused; unsolved attitudes are counted and give exit code 3.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/console.hpp"
#include "job/case.hpp"
#include "run/run_output.hpp"
#include "run/submission.hpp"

namespace vrda::run {

struct RunOptions : job::JobSource {
  std::string output;         ///< empty: results/NAME/NAME.h5
  int n_threads = 0;          ///< 0: one per processor
  bool is_fresh = false;      ///< discards an existing journal; solves a finished job again
  bool may_replace = false;   ///< replaces the result of another job
  bool writes_trace = false;  ///< writes every move of every search next to the output
  bool has_profile = false;   ///< prints the time of each phase
  std::string progress = "auto";
  bool only_spine = false;                 ///< solves only the spine, into its own journal, for shards
  std::optional<store::Shard> shard;       ///< solves only these rows, into their own journal
  std::function<void()> on_solving_start;  ///< called before the first step of the spine, and of the rows
  /// Called with the steps done and all steps, before the first and after each step, from any thread; then
  /// likewise with the samples.
  std::function<void(int n_done, int n_total)> on_progress;
  bool is_hosted = false;  ///< within another program: leaves signals to it, prints no path
  /// Absent: a shard waits a minute for its journal, a whole run does not wait.
  std::optional<JournalWait> journal_wait;
};

/// Solves the whole job, or with `only_spine` or `shard` a part for `vrda merge`.
core::ExitCode run_command(const RunOptions& options);

// `vrda merge`: journals of shards -> motion model.

/// Without a job file it is that of the case file next to the journals.
struct MergeOptions : job::JobSource {
  std::vector<std::string> journals;  ///< empty: those of the spine and all shards next to the output
  std::string output;
  int n_threads = 0;  ///< for smoothing; 0: one per processor
  bool keeps_journals = false;
  bool may_replace = false;   ///< replaces the result of another job
  std::int32_t n_shards = 0;  ///< if known: their journals are also opened by name; 0: unknown
};

/// Gives the same bytes as a single run. Throws InputError with the missing attitudes and shards. Then, and
/// when interrupted, the journals are kept. An output that already contains this result is not changed.
core::ExitCode merge_command(const MergeOptions& options);

// The one place that decides what is said about a job: `check`, `run` and the commands like it print these
// warnings, and /job/warnings of the motion model holds them.

/// How the moving object starts at the first flexion.
struct InitialContact {
  bool is_overlapping = false;
  double travel_mm = 0.0;   ///< along Delta to the first contact; infinite with nothing ahead
  double substep_mm = 0.0;  ///< of solve::Joint
};

struct CheckedCase {
  job::Case job_case;  ///< `warnings` has every warning about the job
  InitialContact initial;
};

/// load_case(), whose warnings (job/case_warnings.hpp) come first; then the initial pose, triangles that
/// intersect each other, and unit, side and frame by registration. They depend on the job and its files only.
/// Cost beside load_case(): 20 ms for the generic knee, 0.3 s for bones of 40,000 triangles. Mesh files of
/// together at least `large_bytes` are announced on standard error.
CheckedCase load_checked_case(const job::Job& job, const std::string& data_directory,
                              std::uintmax_t large_bytes = 50'000'000);

}  // namespace vrda::run
