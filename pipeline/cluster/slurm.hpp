/// Slurm's own commands, as an ordinary user runs them.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cluster/jobs.hpp"
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

}  // namespace vrda
