/// Slurm's user commands, and the record of submitted jobs: DIR/submitted.jsonl, one line per job, in order.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/process.hpp"
#include "core/text.hpp"
#include "run/submission.hpp"

namespace vrda::run {

/// Runs a program of Slurm in `folder` (empty: the working folder) to completion, without standard input. The
/// environment omits options of Slurm's programs (SBATCH_... except SBATCH_EXPORT, SQUEUE_..., SCANCEL_...),
/// which would override those of vrda, and variables of an enclosing job (SLURM_JOB..., SLURM_ARRAY_...,
/// SLURM_RESTART_COUNT), which a new job would inherit. Throws InputError when no process can be created.
ProgramResult run_slurm(const std::vector<std::string>& words, const std::string& folder = "");

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
constexpr auto fields_of(const SubmittedJob*)
{
  return std::tuple{Field{"id", &SubmittedJob::id}, Field{"at", &SubmittedJob::submitted_at},
                    Field{"", &SubmittedJob::job}};
}

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

// Batch scripts of a submission and their sbatch commands.

/// Seconds of a time limit as sbatch takes it: minutes, minutes:seconds, hours:minutes:seconds, days-hours,
/// days-hours:minutes, days-hours:minutes:seconds. Throws InputError whose file is "--time".
std::int64_t seconds_of_time(const std::string& text);

/// Time before the limit at which Slurm sends SIGTERM: a tenth of the limit, at least 30 s (a quarter for
/// short limits), at most 2 minutes. A busy node and controller each need seconds for a restart. Slurm may
/// send the signal up to a minute earlier.
std::int64_t warning_seconds(std::int64_t time_limit_seconds);

/// Maximum number of restarts of a task.
inline constexpr int max_restarts = 100;

/// Throws InputError naming an invalid option: a line break would end a script's line, a space an option.
void require_valid_options(const SlurmOptions& options);
/// Throws InputError if `folder` has characters that sbatch interprets in log paths.
void require_log_folder(const std::string& folder);

/// `text` quoted as one shell word, for any bytes.
std::string shell_word(const std::string& text);

/// "spine.sbatch", below scripts/.
std::string script_name_of(TaskKind kind);

/// The script of one kind of task, for all cases. `folder` is the submission's, absolute.
std::string script_of(TaskKind kind, const std::string& folder, const Submission& submission);

/// The words of `sbatch ...` for a job, run in the submission's folder; `ids` are the ids of the earlier
/// jobs, in order.
std::vector<std::string> sbatch_words(const std::string& folder, const Submission& submission,
                                      const PlannedJob& job, const std::vector<std::string>& ids);

/// The sbatch commands as shell lines with ids in variables, as printed by a dry run.
std::string sbatch_lines(const std::string& folder, const Submission& submission,
                         const std::vector<PlannedJob>& jobs);

/// "13_[1-8%4]", as in squeue.
std::string id_text(const std::string& id, const PlannedJob& job, const SlurmOptions& options);

/// Writes scripts/<kind>.sbatch of every kind among the jobs. Throws InputError naming the file.
void write_scripts(const std::string& folder, const Submission& submission,
                   const std::vector<PlannedJob>& jobs);

/// Submits the jobs (their scripts must exist) and records each one immediately. When Slurm rejects one, the
/// earlier ones continue, and the InputError names `vrda resume`, which submits the others. A job that cannot
/// be recorded is cancelled.
std::vector<SubmittedJob> submit_jobs(const std::string& folder, const Submission& submission,
                                      const std::vector<PlannedJob>& jobs);

/// "spine 12, shards 13_[1-8%4], merge 14": one line per case, then one for unsharded cases and the index.
std::vector<std::string> lines_of(const Submission& submission, const std::vector<SubmittedJob>& jobs);

}  // namespace vrda::run
