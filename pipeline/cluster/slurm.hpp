/// Slurm's own commands, as an ordinary user runs them, and what was handed to it: DIR/submitted.jsonl, one
/// line a job, in order.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cluster/jobs.hpp"
#include "cluster/submission.hpp"
#include "core/error.hpp"

namespace vrda {

/// What squeue knows of a job or of one task of an array.
struct SlurmRow {
  std::string id;           ///< of the job or the whole array
  std::int32_t number = 0;  ///< in the array; 0: no array
  std::string state;        ///< "PENDING", "RUNNING", "TIMEOUT", ...
  std::string node;
  std::string reason;  ///< "Priority", "Dependency", "NonZeroExitCode", ...
};

/// The format that rows_of_squeue() reads.
inline constexpr const char* squeue_format = "%F|%K|%T|%N|%r";
/// Lines that are none are left out.
std::vector<SlurmRow> rows_of_squeue(const std::string& text);

/// MaxArraySize and MaxJobCount of `scontrol show config`; Slurm's defaults where they are not there.
SlurmLimits limits_of_config(const std::string& text);

/// Waiting and may yet begin; a dependency that never can be is none.
bool is_queued(const SlurmRow& row);
/// Queued, but held: its node could not begin it, as Slurm says. Its user may release it.
bool is_held_after_failed_launch(const SlurmRow& row);
/// Begun, or just about to begin or to end.
bool is_running(const SlurmRow& row);

/// The messages that sbatch and its kin print, in one line.
std::string slurm_message(const std::string& standard_error);

/// What goes wrong with these is an InputError or its facts: naming --local where there is no Slurm, else
/// with Slurm's own reason.
SlurmLimits ask_limits();
struct SubmitAnswer {
  std::string id;
  std::optional<InputError::Facts> fault;  ///< then there is no id
};
/// The id that `words` (sbatch ...), run in `folder`, prints.
SubmitAnswer submit_job(const std::vector<std::string>& words, const std::string& folder);
struct QueueAnswer {
  std::vector<SlurmRow> rows;
  std::optional<InputError::Facts> fault;  ///< then there are no rows
};
/// Jobs that Slurm has forgotten are left out.
QueueAnswer ask_rows(const std::vector<std::string>& ids);
std::optional<InputError::Facts> cancel_jobs(const std::vector<std::string>& ids);
void release_jobs(const std::vector<std::string>& ids);

/// What was handed to Slurm: DIR/submitted.jsonl, one line a job, in order.
struct SubmittedJob {
  std::string id;
  std::string at;  ///< UTC
  PlannedJob job;  ///< without what it waits for
};

/// One line at the end, on the disk when it returns: a job that is in Slurm's queue must not be forgotten.
/// Throws InputError naming the file.
[[nodiscard]] std::optional<InputError::Facts> append_submitted(const std::string& folder,
                                                                const SubmittedJob& submitted);
/// Lines that are damaged or cut short are left out.
std::vector<SubmittedJob> read_submitted(const std::string& folder);

/// One task as Slurm has it.
struct SlurmTask {
  std::string job;            ///< "13_3" or "12", of the last job that had this task
  SlurmRow row;               ///< its state is empty when Slurm has forgotten the job
  std::string log{};          ///< name of its log; of cases that share a task the same
  std::int32_t per_task = 1;  ///< cases that share it
};

/// Of each task that was ever submitted, the last time it was.
std::map<TaskId, SlurmTask> tasks_in_slurm(const Submission& submission,
                                           const std::vector<SubmittedJob>& jobs,
                                           const std::vector<SlurmRow>& rows);

/// Throws InputError whose file is "--cases-per-task" unless runs queued or under way have `asked` cases a
/// task: a task is a span of case numbers, and spans of two lengths would share cases.
void require_same_span(const std::map<TaskId, SlurmTask>& tasks, std::int32_t asked);

}  // namespace vrda
