/// Which tasks are to be done, and after which.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cluster/submission.hpp"

namespace vrda {

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

/// One task and those of the list that must have ended well before it begins; `is_after_any`: ended in
/// whatever way.
struct PlannedTask {
  TaskId task;
  std::vector<std::size_t> after;
  bool is_after_any = false;
};

/// The tasks one by one, each after those it needs: what local processes do.
std::vector<PlannedTask> tasks_of_work(const Work& work);

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

/// The cases of one task of a job of runs.
std::vector<std::int32_t> cases_of_task(const PlannedJob& job, std::int32_t number, std::size_t n_cases);

}  // namespace vrda
