/// Solves the samples of an uncertain job ([uncertainty]) into a journal.
#pragma once

#include <map>
#include <vector>

#include "run/run_command.hpp"
#include "run/step_log.hpp"
#include "job/case.hpp"
#include "solve/sweep.hpp"

namespace vrda::run {

/// Number of samples of the job; 0 without [uncertainty].
std::int32_t n_samples_of(const job::Case& job_case);

/// Solves the samples with these numbers, each on one thread, from the spine in `job` (the result of `plan`).
/// Recalls samples from `log`, appends new ones, checks for interrupts. Records in the order of `samples`;
/// empty when stopped.
std::optional<std::vector<StepRecord>> solve_samples(const job::Case& job_case, const solve::SweepPlan& plan,
                                                     const solve::SweepResult& job,
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
