/// Solves the steps of a sweep, or of a part of one, into a journal, with progress; parts of a run as
/// processes of their own.
#pragma once

#include "load/case.hpp"
#include "run/run_command.hpp"
#include "run/step_log.hpp"
#include "sweep/sweep.hpp"
#include "talk/talk.hpp"

namespace vrda {

/// What progress counts: cells of the grid, or the steps along the spine that are known beforehand (with the
/// search one a flexion, with varus left free the starts of each).
enum class Counted { cells, spine };

/// Recalls what `log` or `spine` knows, keeps what is new in `log`, asks for interrupts before each step. All
/// that was kept has reached the disk when it returns.
SweepResult solve_part(const Case& job_case, const SweepPlan& plan, Counted counted,
                       const RunOptions& options, StepLog& log,
                       const std::map<StepKey, StepRecord>& spine = {});

/// Says where the steps are and how to go on.
ExitCode say_interrupted(const StepLog& log);

/// Solves the spine into its own journal; nothing is left to do where that is complete.
ExitCode spine_command(const RunOptions& options);

/// Solves the rows of options.shard into the shard's journal. Reads the spine, or solves it where nobody else
/// does.
ExitCode shard_command(const RunOptions& options);

}  // namespace vrda
