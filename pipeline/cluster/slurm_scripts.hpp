/// The batch scripts of a submission, the sbatch commands that submit them, and their submission.
#pragma once

#include <string>
#include <vector>

#include "cluster/jobs.hpp"
#include "cluster/slurm.hpp"
#include "cluster/submission.hpp"

namespace vrda {

/// Seconds of a time limit as sbatch takes it: minutes, minutes:seconds, hours:minutes:seconds, days-hours,
/// days-hours:minutes, days-hours:minutes:seconds. Throws InputError whose file is "--time".
std::int64_t seconds_of_time(const std::string& text);

/// How long before the time limit Slurm tells a task to end: a tenth of it, at least 30 s (of short limits a
/// quarter), at most 2 minutes; a busy node and a busy controller take seconds each to begin it again. Slurm
/// may do so up to a minute earlier.
std::int64_t warning_seconds(std::int64_t time_limit_seconds);

/// Slurm restarts a task no more often than this.
inline constexpr int most_restarts = 100;

/// Whether Slurm may be told these. Throws InputError naming the option: a line break would end a script's
/// line, a space an option.
void require_sound(const SlurmOptions& options);
/// Whether logs can stand in the folder: sbatch has its own mind about some bytes of their paths. InputError.
void require_log_folder(const std::string& folder);

/// `text` as one word of a shell's line, whatever bytes it has.
std::string shell_word(const std::string& text);

/// "spine.sbatch", below scripts/.
std::string script_name_of(TaskKind kind);

/// The text of one script: one for each kind, for all cases. `folder` is the submission's, absolute.
std::string script_of(TaskKind kind, const std::string& folder, const Submission& submission);

/// The words of `sbatch ...` for a job, run in the submission's folder; `ids` are those of the jobs before
/// it, in order.
std::vector<std::string> sbatch_words(const std::string& folder, const Submission& submission,
                                      const PlannedJob& job, const std::vector<std::string>& ids);

/// The same as lines for a shell, each keeping its id for those after it: what a dry run prints.
std::string sbatch_lines(const std::string& folder, const Submission& submission,
                         const std::vector<PlannedJob>& jobs);

/// "13_[1-8%4]": how squeue would write it.
std::string id_text(const std::string& id, const PlannedJob& job, const SlurmOptions& options);

/// Writes scripts/<kind>.sbatch of every kind among the jobs. Throws InputError naming the file.
void write_scripts(const std::string& folder, const Submission& submission,
                   const std::vector<PlannedJob>& jobs);

/// Submits the jobs, whose scripts stand, and notes each down at once. When Slurm refuses one, those
/// submitted before go on; its InputError names `vrda resume` then, which adds what is missing. A job that
/// cannot be noted down is cancelled.
std::vector<SubmittedJob> submit_jobs(const std::string& folder, const Submission& submission,
                                      const std::vector<PlannedJob>& jobs);

/// "spine 12, shards 13_[1-8%4], merge 14": a line a case, then one of cases without shards and the index.
std::vector<std::string> lines_of(const Submission& submission, const std::vector<SubmittedJob>& jobs);

}  // namespace vrda
