/// Solves the steps of a sweep, or of a part of it, into a journal, with progress; and the commands for the
/// parts of a run, each a separate process.
#pragma once

#include "console/console.hpp"
#include "job_run/run_command.hpp"
#include "job_run/step_log.hpp"
#include "load/case.hpp"
#include "sweep/sweep.hpp"

namespace vrda::job_run {

/// Unit of progress: cells of the grid, or the spine steps known in advance (one per flexion with the search,
/// the starts of each flexion with free varus).
enum class ProgressUnit { cells, spine };

/// Recalls steps from `log` and `spine`, appends new ones to `log`, and checks for interrupts before each
/// step. All appended steps are on disk when it returns.
sweep::SweepResult solve_part(const load::Case& job_case, const sweep::SweepPlan& plan, ProgressUnit counted,
                              const RunOptions& options, StepLog& log,
                              const std::map<StepKey, StepRecord>& spine = {});

/// Reports where the solved steps are and how to resume.
console::ExitCode report_interrupted(const StepLog& log);

/// Solves the spine into its own journal, unless that is already complete.
console::ExitCode spine_command(const RunOptions& options);

/// Solves the rows of options.shard into the shard's journal. Reads the spine's journal; solves an incomplete
/// spine when it gets its lock.
console::ExitCode shard_command(const RunOptions& options);

}  // namespace vrda::job_run
