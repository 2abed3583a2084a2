/// Remaining tasks as Slurm jobs and job arrays with dependencies; local processes use the same jobs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "run/submission.hpp"
#include "store/run_files.hpp"

namespace vrda::run {

/// Parses "3/8". Throws InputError whose file is "--shard".
store::Shard shard_of(const std::string& text);

/// Rows of a shard, round-robin: i with i % count == number - 1. Empty for the last shards if there are more
/// shards than rows.
std::vector<std::int32_t> rows_of(const store::Shard& shard, std::int32_t n_rows);

/// Remaining tasks of one case: `run` only, or the missing of spine and shards followed by a merge.
struct CaseWork {
  std::int32_t case_number = 0;
  bool needs_spine = false;
  std::vector<std::int32_t> shards;  ///< ascending
  bool needs_run = false;
  /// Slurm ids of active jobs on which the shards or the merge depend.
  std::vector<std::string> active_spine_jobs;
  std::vector<std::string> active_shard_jobs;
};

struct Work {
  std::vector<CaseWork> cases;
  bool needs_index = false;
  std::vector<std::string> active_case_jobs;  ///< Slurm ids of other active jobs on which the index depends

  bool is_empty() const { return cases.empty() && !needs_index; }
};

/// All tasks of a new submission.
Work all_work(const Submission& submission);

/// Slurm's limits, with its defaults.
struct SlurmLimits {
  std::int32_t max_array_size = 1001;  ///< an array's largest number is one less
  std::int32_t max_job_count = 10000;  ///< jobs in the queue; each array task counts
};

/// One sbatch command: a job or a job array.
struct PlannedJob {
  TaskKind kind = TaskKind::run;
  std::int32_t case_number = -1;      ///< for spine, shard and merge
  std::vector<std::int32_t> numbers;  ///< array task numbers, ascending; empty: no array
  std::int32_t offset = 0;            ///< of `run`: task t starts at case offset + (t - 1) * per_task
  std::int32_t per_task = 1;
  std::vector<std::size_t> after;      ///< dependencies: earlier jobs of the list
  std::vector<std::string> after_ids;  ///< dependencies: ids of active jobs
};

/// Limits of local runs.
inline constexpr SlurmLimits no_limits{1'000'000'000, 2'000'000'000};

/// The jobs in submission order. Throws InputError naming option and fitting value beyond Slurm's limits.
std::vector<PlannedJob> jobs_of_work(const Submission& submission, const Work& work,
                                     const SlurmLimits& limits);

/// Cases per array task: the option's value, or the smallest number for which tasks fill half the queue.
std::int32_t cases_per_task(const Submission& submission, const SlurmLimits& limits);

/// "1-3,5": sbatch's notation of ascending numbers.
std::string ranges_text(const std::vector<std::int32_t>& numbers);

/// Log file of a `run` job's task `number`, which may also be an sbatch pattern.
std::string log_of_runs(std::int32_t offset, const std::string& number);

/// The tasks of array task `number` of a job (0: job without an array); for `run` one per case.
std::vector<TaskId> tasks_of(const Submission& submission, const PlannedJob& job, std::int32_t number);
/// The tasks of all its array tasks.
std::vector<TaskId> tasks_of(const Submission& submission, const PlannedJob& job);

}  // namespace vrda::run
