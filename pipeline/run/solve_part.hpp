/// Solves the steps of a sweep, or of a part of it, into a journal, with progress; and the commands for the
/// parts of a run, each a separate process.
#pragma once

#include <map>
#include <memory>
#include <vector>

#include "core/console.hpp"
#include "job/case.hpp"
#include "run/run_command.hpp"
#include "run/run_output.hpp"
#include "solve/sweep.hpp"

namespace vrda::run {

/// Unit of progress: cells of the grid, or the spine steps known in advance (one per flexion with the search,
/// the starts of each flexion with free varus).
enum class ProgressUnit { cells, spine };

/// The steps, and the bodies in the frame of the first flexion that they were solved with.
struct SolvedPart {
  solve::SweepResult result;
  std::shared_ptr<const solve::Joint> joint;
};

/// Recalls steps from `log` and `spine`, appends new ones to `log`, and checks for interrupts before each
/// step. All appended steps are on disk when it returns.
SolvedPart solve_part(const job::Case& job_case, const solve::SweepPlan& plan, ProgressUnit counted,
                      const RunOptions& options, StepLog& log,
                      const std::map<StepKey, StepRecord>& spine = {});

/// Reports where the solved steps are and how to resume.
core::ExitCode report_interrupted(const StepLog& log);

/// Solves the spine into its own journal, unless that is already complete.
core::ExitCode spine_command(const RunOptions& options);

/// Solves the rows of options.shard into the shard's journal. Reads the spine's journal; solves an incomplete
/// spine when it gets its lock.
core::ExitCode shard_command(const RunOptions& options);

// Solves the samples of an uncertain job ([uncertainty]) into a journal.

/// Number of samples of the job; 0 without [uncertainty].
std::int32_t n_samples_of(const job::Case& job_case);

/// Solves the samples with these numbers, each on one thread, from the spine in `job` (the part of `plan`).
/// Recalls samples from `log`, appends new ones, checks for interrupts. Records in the order of `samples`;
/// empty when stopped.
std::optional<std::vector<StepRecord>> solve_samples(const job::Case& job_case, const solve::SweepPlan& plan,
                                                     const SolvedPart& job,
                                                     const std::vector<std::int32_t>& samples,
                                                     const RunOptions& options, StepLog& log);

/// All samples of the job.
std::vector<std::int32_t> all_samples(const job::Case& job_case);

/// The records of samples among `steps`, and the numbers of those that lack a flexion.
struct KnownSamples {
  std::vector<StepRecord> records;
  std::vector<std::int32_t> missing;
};
KnownSamples known_samples(const job::Case& job_case, const std::map<StepKey, StepRecord>& steps);

}  // namespace vrda::run
