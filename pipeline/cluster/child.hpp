/// Other programs, run as children of this one.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace vrda {

struct Said {
  int exit_code = -1;      ///< -1: ended by a signal
  bool is_absent = false;  ///< there is no such program
  std::string out;
  std::string err;
};

/// Runs `words` in `folder` (empty: here) to the end, without standard input. Left out of the environment are
/// options for Slurm's programs (SBATCH_... but for SBATCH_EXPORT, SQUEUE_..., SCANCEL_...), which would
/// overrule what is asked for, and what tells of a job that this is a part of (SLURM_JOB..., SLURM_ARRAY_...,
/// SLURM_RESTART_COUNT), which a new job would take for its own. Throws InputError when the system refuses a
/// process.
Said run_program(const std::vector<std::string>& words, const std::string& folder);

/// Starts `words` with both outputs appended to the file `log`, in a process group of its own; it gets
/// SIGTERM when this process ends first. SLURM... of the environment are left out: it is no task of Slurm's,
/// even within one. Throws InputError when the system refuses.
pid_t start_program(const std::vector<std::string>& words, const std::string& log);

/// How a child ended.
struct Ending {
  pid_t pid = 0;
  int exit_code = -1;  ///< -1: by `signal`
  int signal = 0;
};

/// The ending of one of `children`, waiting at most a hundredth of a second; pid 0 when none ended.
Ending wait_a_moment(const std::vector<pid_t>& children);

/// Path by which another process starts this program: links resolved, or, when a carried loader runs it
/// (scripts/with_glibc), the launcher's. Empty where /proc does not tell.
std::string own_program();

/// The same of an executable by /proc and of the name that the program was called by.
std::string program_to_start(const std::string& executable, const std::string& called_by);

}  // namespace vrda
