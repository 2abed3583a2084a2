/// Which system call goes wrong, and how: read from the environment once a process. README.md has the
/// variables.
#pragma once

#include <ctime>

namespace vrda::test {

/// Kinds of calls; those up to `unlink` change what stands on a disk.
enum class Call { write, fsync, rename, truncate, open, close, unlink, read, list, lock };

/// What becomes of one call.
enum class Fate { pass, half, half_then_die, fail };

struct Verdict {
  Fate fate = Fate::pass;
  int error = 0;  ///< errno of a call that fails
};

/// Whether any file is watched; when not, there is no need to find out what a descriptor leads to.
bool is_watching();

/// Counts the call when `path` or `other_path` is the watched file, kills or holds the process when it is
/// this call's turn, and says what to do otherwise.
Verdict verdict_on(Call call, const char* path, const char* other_path = "");

[[noreturn]] void die();

/// What a clock that jumps by hours says instead of `now`; `now` where the plan leaves clocks alone.
timespec disturbed(timespec now);

}  // namespace vrda::test
