/// Runs the tasks of a submission as local processes, without a cluster: in the order of their dependencies,
/// as many at a time as workers are given.
#pragma once

#include <sys/types.h>

#include <functional>
#include <string>
#include <vector>

#include "core/files.hpp"
#include "run/submission.hpp"

namespace vrda::run {

struct LocalOptions {
  int n_workers = 1;                               ///< concurrent tasks
  int n_cpus = 1;                                  ///< threads per task
  std::function<bool()> is_stop_requested;         ///< polled
  std::function<void(const std::string&)> report;  ///< one line per ended task
};

struct LocalOutcome {
  bool is_interrupted = false;
  int n_done = 0;
  int n_failed = 0;    ///< ended with an error
  int n_skipped = 0;   ///< skipped because a dependency failed
  int worst_code = 0;  ///< exit code; priority 5, 2, 3, 0
};

/// Runs each task (`vrda task`) after its dependencies have succeeded. When stopped it sends SIGTERM to its
/// processes and waits for them. Throws InputError when a process cannot be created.
LocalOutcome run_locally(const std::string& folder, const Submission& submission,
                         const std::vector<PlannedJob>& jobs, const LocalOptions& options);

/// Takes the lock of `vrda submit` and `vrda resume`; throws InputError if another process holds it.
OpenFile locked_submission(const std::string& folder);

// Other programs run as child processes: Slurm's commands, and `vrda` itself as a local worker.

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
