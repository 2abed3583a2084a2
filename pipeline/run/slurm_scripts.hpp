/// Batch scripts of a submission and their sbatch commands.
#pragma once

#include <string>
#include <vector>

#include "run/jobs.hpp"
#include "run/slurm.hpp"
#include "run/submission.hpp"

namespace vrda::run {

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
