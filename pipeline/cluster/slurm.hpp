/// Slurm's own commands, as an ordinary user runs them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cluster/jobs.hpp"

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

/// All of these throw InputError: naming --local where there is no Slurm, else with Slurm's own reason.
SlurmLimits ask_limits();
/// The id that `words` (sbatch ...), run in `folder`, prints.
std::string submit_job(const std::vector<std::string>& words, const std::string& folder);
/// Jobs that Slurm has forgotten are left out.
std::vector<SlurmRow> ask_rows(const std::vector<std::string>& ids);
void cancel_jobs(const std::vector<std::string>& ids);
void release_jobs(const std::vector<std::string>& ids);

}  // namespace vrda
