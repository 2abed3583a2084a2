/// What a submission still needs.
#pragma once

#include <string>
#include <vector>

#include "cluster/jobs.hpp"
#include "cluster/status.hpp"

namespace vrda {

struct Missing {
  Work work;
  std::vector<std::string> reasons;    ///< one line a task that is to be done again: which and why
  std::vector<std::string> to_cancel;  ///< Slurm's jobs that can no longer begin, or begin too early
  std::int32_t n_under_way = 0;        ///< tasks that Slurm has queued or runs, which are left alone
};

/// Reads the journals of the tasks that ended well in cases that are not made: what they hold counts, not
/// what was said of them. A local task that still runs is missing, too: whoever repeats it waits for its
/// lock, and finds what it did.
Missing missing_of(const std::string& folder, const Submission& submission, const StatusView& status,
                   const SubmissionSnapshot& seen);

}  // namespace vrda
