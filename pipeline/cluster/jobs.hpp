/// Which tasks are to be done, as jobs and arrays of Slurm that wait for each other; local processes take the
/// same jobs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cluster/submission.hpp"
#include "journal/run_files.hpp"

namespace vrda {

/// "3/8". Throws InputError whose file is "--shard".
Shard shard_of(const std::string& text);

/// The rows, dealt out in turn: i with i % count == number - 1. None for the last ones of more shards than
/// rows.
std::vector<std::int32_t> rows_of(const Shard& shard, std::int32_t n_rows);

/// What one case still needs: `run` alone, or what is missing of spine and shards and then always a merge.
struct CaseWork {
  std::int32_t case_number = 0;
  bool needs_spine = false;
  std::vector<std::int32_t> shards;  ///< rising
  bool needs_run = false;
  /// Slurm's ids of jobs under way that the shards or the merge must wait for.
  std::vector<std::string> spine_under_way;
  std::vector<std::string> shards_under_way;
};

struct Work {
  std::vector<CaseWork> cases;
  bool needs_index = false;
  std::vector<std::string> cases_under_way;  ///< Slurm's ids of what the index must wait for besides

  bool is_nothing() const { return cases.empty() && !needs_index; }
};

/// Everything of a new submission.
Work all_work(const Submission& submission);

/// How many tasks Slurm takes; its own defaults.
struct SlurmLimits {
  std::int32_t max_array_size = 1001;  ///< an array's largest number is one less
  std::int32_t max_job_count = 10000;  ///< jobs in the queue at once, each task of an array counts
};

/// One sbatch: a job or an array of them.
struct PlannedJob {
  TaskKind kind = TaskKind::run;
  std::int32_t case_number = -1;      ///< of spine, shard and merge
  std::vector<std::int32_t> numbers;  ///< array tasks, rising; empty: no array
  std::int32_t offset = 0;  ///< of `run`: task t takes the cases from offset + (t - 1) * per_task on
  std::int32_t per_task = 1;
  std::vector<std::size_t> after;      ///< earlier jobs of the list
  std::vector<std::string> after_ids;  ///< and jobs under way
};

/// Of local processes.
inline constexpr SlurmLimits no_limits{1'000'000'000, 2'000'000'000};

/// The jobs in the order of their submission. Throws InputError naming the option, and what would fit, when
/// Slurm's limits leave no room.
std::vector<PlannedJob> jobs_of_work(const Submission& submission, const Work& work,
                                     const SlurmLimits& limits);

/// Cases of one task of an array: as asked, or as few as let every task into the queue with room for others'.
std::int32_t cases_per_task(const Submission& submission, const SlurmLimits& limits);

/// "1-3,5": sbatch's way of numbers, which rise.
std::string ranges_text(const std::vector<std::int32_t>& numbers);

/// The log of task `number`, or of what stands for it, of a job of runs.
std::string log_of_runs(std::int32_t offset, const std::string& number);

/// The tasks of number `number` of a job (0: of a job without an array); of runs a task a case.
std::vector<TaskId> tasks_of(const Submission& submission, const PlannedJob& job, std::int32_t number);
/// Those of all its numbers.
std::vector<TaskId> tasks_of(const Submission& submission, const PlannedJob& job);

}  // namespace vrda
