/// Child processes of both programs: start, wait, capture output; the path of this program, and the
/// processors that it may use.
#pragma once

#include <sys/types.h>

#include <string>
#include <string_view>
#include <vector>

namespace vrda::inline core {

/// What a child process gets from this one.
struct ProcessOptions {
  /// Descriptors that become its standard streams; -1: /dev/null. They stay open here.
  int in = -1, out = -1, err = -1;
  std::string folder = {};  ///< working folder; empty: that of this process
  /// Which entries "NAME=value" of the environment it inherits; null: all.
  bool (*is_inherited)(std::string_view entry) = nullptr;
  /// It has its own process group, and gets SIGTERM when the thread that started it ends first.
  bool is_tied = false;
};

struct StartedProcess {
  pid_t pid = -1;  ///< to be waited for, also after an error of starting the program; -1: no process
  int error = 0;   ///< errno of starting the program; the process then ends with 127 (not found) or 126
};

/// Starts the program `words[0]`, looked up in PATH without a slash, with the arguments `words`. Its signal
/// mask is empty, and SIGINT, SIGTERM and SIGPIPE have their default action. Other descriptors of this
/// process must be close-on-exec. Blocks until the program has started.
StartedProcess start_process(const std::vector<std::string>& words, const ProcessOptions& options = {});

/// How a child process ended.
struct ProcessEnd {
  pid_t pid = 0;       ///< 0: none has ended
  int exit_code = -1;  ///< -1: ended by `signal`
  int signal = 0;
};

/// Waits until the child process has ended.
ProcessEnd wait_for_process(pid_t pid);

/// The end of one of `children`, waiting at most 10 ms.
ProcessEnd poll_processes(const std::vector<pid_t>& children);

struct ProgramResult {
  int exit_code = -1;         ///< -1: ended by a signal
  bool is_not_found = false;  ///< no such program
  std::string out;
  std::string err;
};

/// Runs `words` to completion and captures both outputs; `options.out` and `err` are ignored. Throws
/// InputError naming the program when no process can be created.
ProgramResult run_program(const std::vector<std::string>& words, ProcessOptions options);

/// Path for starting this program from another process: links resolved, or the launcher's path when run by a
/// bundled loader (scripts/with_glibc). Empty if /proc is not available.
std::string own_program();

/// The same for a given executable (from /proc) and the name that the program was called by.
std::string program_to_start(const std::string& executable, const std::string& called_by);

/// Processors that this process may use, at least 1: those of its affinity, and at most the quota of its
/// cgroups (version 1 or 2), rounded up. `root` is the folder with the system's /proc and /sys.
int usable_processors(const std::string& root = "");

}  // namespace vrda::inline core
