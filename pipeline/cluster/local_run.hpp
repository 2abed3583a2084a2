/// The jobs of a submission as processes of this machine, without a cluster.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cluster/jobs.hpp"
#include "cluster/submission.hpp"
#include "core/open_file.hpp"

namespace vrda {

struct LocalOptions {
  int n_workers = 1;                             ///< tasks at once
  int n_cpus = 1;                                ///< threads a task
  std::function<bool()> is_stopped;              ///< asked all the time
  std::function<void(const std::string&)> tell;  ///< one line a task that ended
};

struct LocalOutcome {
  bool is_interrupted = false;
  int n_done = 0;
  int n_failed = 0;    ///< ended badly
  int n_left_out = 0;  ///< waited for one of those
  int worst_code = 0;  ///< exit code: 5 over 2 over 3 over 0
};

/// Runs each task, `vrda task`, once the jobs it waits for have ended well. When stopped it tells its
/// processes to end, and waits for them. Throws InputError when the system refuses a process.
LocalOutcome run_locally(const std::string& folder, const Submission& submission,
                         const std::vector<PlannedJob>& jobs, const LocalOptions& options);

/// The lock that `vrda submit` and `vrda resume` hold: a second one gets an InputError.
OpenFile locked_submission(const std::string& folder);

}  // namespace vrda
