/// Slurm's user commands, and the record of submitted jobs: DIR/submitted.jsonl, one line per job, in order.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "run/jobs.hpp"
#include "run/submission.hpp"
#include "core/error.hpp"

namespace vrda::run {

/// squeue's row of a job or of one array task.
struct SlurmRow {
  std::string id;           ///< of the job or the whole array
  std::int32_t number = 0;  ///< in the array; 0: no array
  std::string state;        ///< "PENDING", "RUNNING", "TIMEOUT", ...
  std::string node;
  std::string reason;  ///< "Priority", "Dependency", "NonZeroExitCode", ...
};

/// squeue's format for rows_of_squeue().
inline constexpr const char* squeue_format = "%F|%K|%T|%N|%r";
/// Invalid lines are skipped.
std::vector<SlurmRow> rows_of_squeue(const std::string& text);

/// MaxArraySize and MaxJobCount of `scontrol show config`; Slurm's defaults where missing.
SlurmLimits limits_of_config(const std::string& text);

/// Waiting and able to start; false for a dependency that can never be satisfied.
bool is_queued(const SlurmRow& row);
/// Queued, but held after a failed launch on its node. The user may release it.
bool is_held_after_failed_launch(const SlurmRow& row);
/// Running, starting or completing.
bool is_running(const SlurmRow& row);

/// The error messages of sbatch and similar commands, in one line.
std::string slurm_message(const std::string& standard_error);

/// Errors are an InputError or its facts, with Slurm's message, or suggesting --local without Slurm.
SlurmLimits query_limits();
struct SubmitResult {
  std::string id;
  std::optional<InputError::Facts> error;  ///< if set, there is no id
};
/// Runs `words` (sbatch ...) in `folder` and returns the printed id.
SubmitResult submit_job(const std::vector<std::string>& words, const std::string& folder);
struct QueueResult {
  std::vector<SlurmRow> rows;
  std::optional<InputError::Facts> error;  ///< if set, there are no rows
};
/// Jobs that Slurm has purged have no row.
QueueResult query_queue(const std::vector<std::string>& ids);
std::optional<InputError::Facts> cancel_jobs(const std::vector<std::string>& ids);
void release_jobs(const std::vector<std::string>& ids);

/// One line of DIR/submitted.jsonl.
struct SubmittedJob {
  std::string id;
  std::string submitted_at;  ///< UTC
  PlannedJob job;            ///< without dependencies
};

/// Appends one line and flushes it to disk, so that no job in Slurm's queue is lost. Returns the facts of an
/// error naming the file.
[[nodiscard]] std::optional<InputError::Facts> append_submitted(const std::string& folder,
                                                                const SubmittedJob& submitted);
/// Damaged or incomplete lines are skipped.
std::vector<SubmittedJob> read_submitted(const std::string& folder);

/// One task in Slurm.
struct SlurmTask {
  std::string job;            ///< "13_3" or "12", of the last job with this task
  SlurmRow row;               ///< state is empty when Slurm has purged the job
  std::string log{};          ///< name of its log, shared by the cases of an array task
  std::int32_t per_task = 1;  ///< cases per array task
};

/// The last submission of each task that was submitted.
std::map<TaskId, SlurmTask> tasks_in_slurm(const Submission& submission,
                                           const std::vector<SubmittedJob>& jobs,
                                           const std::vector<SlurmRow>& rows);

/// Throws InputError whose file is "--cases-per-task" unless queued or running `run` tasks have `requested`
/// cases per task: a task is a range of case numbers, and ranges of different lengths would overlap.
void require_same_cases_per_task(const std::map<TaskId, SlurmTask>& tasks, std::int32_t requested);

}  // namespace vrda::run
