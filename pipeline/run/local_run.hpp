/// Runs the tasks of a submission as local processes, without a cluster: in the order of their dependencies,
/// as many at a time as workers are given.
#pragma once

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

}  // namespace vrda::run
