/// `vrda task`: what each Slurm task or local process of a submission runs.
#pragma once

#include <string>

#include "talk/talk.hpp"

namespace vrda {

struct TaskOptions {
  std::string folder;     ///< of the submission
  std::string kind;       ///< "spine", "shard", "merge", "run" or "index"
  std::string case_name;  ///< empty: by number
  int first = 1;          ///< number of the case, from 1
  int count = 1;          ///< cases of a `run`, one after the other
  int shard = 0;
  int n_cpus = 1;
  /// 128 and the number of the signal that ended the task: note that down instead of running it; 0: run it.
  int ended = 0;
};

/// Runs the tasks asked for, in this process, and leaves the state of each before and after. A task whose
/// case is made already is done. The worst of their exit codes; an interruption ends the list. An
/// interruption at the time limit that solved nothing is a failure: the next start would do no better.
ExitCode task_command(const TaskOptions& options);

}  // namespace vrda
