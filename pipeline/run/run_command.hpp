/// `vrda run`: solves a job and writes its motion model. In: job and mesh files. Out: <output>,
/// <output>.run.json, while running a start file and a journal, from which a repeated command resumes. Throws
/// InputError for input that is refused; unsolved attitudes are counted and give exit code 3.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "run/jobs.hpp"
#include "core/console.hpp"
#include "run/step_log.hpp"

namespace vrda::run {

struct RunOptions {
  std::string job_file;
  std::string output;  ///< empty: results/<job name>/<job name>.h5
  std::string data_directory;
  std::vector<std::string> overrides;
  int n_threads = 0;          ///< 0: one per processor
  bool is_fresh = false;      ///< discards an existing journal; solves a finished job again
  bool may_replace = false;   ///< replaces the result of another job
  bool writes_trace = false;  ///< writes every move of every search next to the output
  bool has_profile = false;   ///< prints the time of each phase
  std::string progress = "auto";
  bool only_spine = false;                 ///< solves only the spine, into its own journal, for shards
  std::optional<store::Shard> shard;     ///< solves only these rows, into their own journal
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

}  // namespace vrda::run
