/// Solves the steps of a sweep, or of a part of it, into a journal, with progress; and the commands for the
/// parts of a run, each a separate process.
#pragma once

#include "core/console.hpp"
#include "run/run_command.hpp"
#include "run/step_log.hpp"
#include "job/case.hpp"
#include "solve/sweep.hpp"

namespace vrda::run {

/// Unit of progress: cells of the grid, or the spine steps known in advance (one per flexion with the search,
/// the starts of each flexion with free varus).
enum class ProgressUnit { cells, spine };

/// Recalls steps from `log` and `spine`, appends new ones to `log`, and checks for interrupts before each
/// step. All appended steps are on disk when it returns.
solve::SweepResult solve_part(const job::Case& job_case, const solve::SweepPlan& plan, ProgressUnit counted,
                              const RunOptions& options, StepLog& log,
                              const std::map<StepKey, StepRecord>& spine = {});

/// Reports where the solved steps are and how to resume.
core::ExitCode report_interrupted(const StepLog& log);

/// Solves the spine into its own journal, unless that is already complete.
core::ExitCode spine_command(const RunOptions& options);

/// Solves the rows of options.shard into the shard's journal. Reads the spine's journal; solves an incomplete
/// spine when it gets its lock.
core::ExitCode shard_command(const RunOptions& options);

}  // namespace vrda::run
