/// Other programs run as child processes: Slurm's commands, and `vrda` itself as a local worker.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace vrda::run {

struct ProgramResult {
  int exit_code = -1;         ///< -1: ended by a signal
  bool is_not_found = false;  ///< the program was not found
  std::string out;
  std::string err;
};

/// Runs `words` in `folder` (empty: the working folder) to completion, without standard input. The
/// environment omits options of Slurm's programs (SBATCH_... except SBATCH_EXPORT, SQUEUE_..., SCANCEL_...),
/// which would override those of vrda, and variables of an enclosing job (SLURM_JOB..., SLURM_ARRAY_...,
/// SLURM_RESTART_COUNT), which a new job would inherit. Throws InputError when no process can be created.
ProgramResult run_program(const std::vector<std::string>& words, const std::string& folder);

/// Starts `words` in its own process group with both outputs appended to the file `log`. It gets SIGTERM when
/// this process ends first. The environment omits SLURM..., since the child is not a Slurm task. Throws
/// InputError when no process can be created.
pid_t start_program(const std::vector<std::string>& words, const std::string& log);

/// Exit of a child process.
struct ChildExit {
  pid_t pid = 0;
  int exit_code = -1;  ///< -1: ended by `signal`
  int signal = 0;
};

/// The exit of one of `children`, waiting at most 10 ms; pid 0 if none has exited.
ChildExit poll_children(const std::vector<pid_t>& children);

/// Path for starting this program from another process: links resolved, or the launcher's path when run by a
/// bundled loader (scripts/with_glibc). Empty if /proc is not available.
std::string own_program();

/// The same for a given executable (from /proc) and the name that the program was called by.
std::string program_to_start(const std::string& executable, const std::string& called_by);

}  // namespace vrda::run
