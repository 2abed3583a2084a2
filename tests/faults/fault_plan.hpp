/// The fault to inject, read from the environment once per process. README.md lists the variables.
#pragma once

#include <ctime>

namespace vrda::test {

/// Kinds of calls; those up to `unlink` modify the disk.
enum class Call { write, fsync, rename, truncate, open, close, unlink, read, list, lock };

/// Outcome of one call.
enum class CallOutcome { pass, half, half_then_kill, fail };

struct CallDecision {
  CallOutcome outcome = CallOutcome::pass;
  int error = 0;  ///< errno of a call that fails
};

/// Whether any file is watched; if not, descriptors need not be resolved to paths.
bool is_watching();

/// Counts the call if `path` or `other_path` is a watched file. If the fault is due, kills or holds the
/// process, or returns the outcome to inject.
CallDecision decide_call(Call call, const char* path, const char* other_path = "");

[[noreturn]] void kill_self();

/// The reading of a clock that jumps or runs fast; `now` without a clock fault.
timespec with_clock_fault(timespec now);

}  // namespace vrda::test
