/// The tasks of a submission as processes of this machine, without a cluster.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cluster/submission.hpp"
#include "cluster/work.hpp"

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

/// Runs each task, `vrda task`, once those it waits for have ended well. When stopped it tells its processes
/// to end, and waits for them. Throws InputError when the system refuses a process.
LocalOutcome run_local(const std::string& folder, const Submission& submission,
                       const std::vector<PlannedTask>& tasks, const LocalOptions& options);

/// Held while somebody hands out tasks of a submission: a second one gets an InputError.
class SubmissionLock {
 public:
  explicit SubmissionLock(const std::string& folder);
  ~SubmissionLock();
  SubmissionLock(const SubmissionLock&) = delete;
  SubmissionLock& operator=(const SubmissionLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace vrda
