/// Runs work on untrusted bytes in a separate process that may crash.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace vrda::store {

struct ProcessLimits {
  std::uint64_t memory_bytes = std::uint64_t{512} << 20;  ///< beyond the memory this process has mapped
  std::uint64_t result_bytes = std::uint64_t{256} << 20;
  unsigned processor_s = 5;  ///< several hundred times the time of a typical model
};

/// How the process ended.
struct ProcessResult {
  bool is_complete = false;
  std::string text;  ///< result of `work`; if not complete, how the process ended: "signal 11"
};

/// Runs `work` in a forked child process while this process continues. The child has the limits and no open
/// files of this process, writes no core and no terminal output, and ends with this process; side effects of
/// `work` are lost. `work` must not throw. Threads are not copied: locks that other threads hold at the fork
/// stay locked in the child, so no other thread may use what `work` uses. Memory is not limited under address
/// and thread sanitizers. Throws InputError naming `subject` if the process cannot be created.
class SeparateProcess {
 public:
  SeparateProcess(const std::function<std::string()>& work, std::string subject,
                  const ProcessLimits& limits = {});
  /// Kills the child if its result was not taken.
  ~SeparateProcess();
  SeparateProcess(const SeparateProcess&) = delete;
  SeparateProcess& operator=(const SeparateProcess&) = delete;

  /// Waits for the end of the child. May be called once.
  ProcessResult wait_for_result();

 private:
  int wait();  // status of the child from waitpid

  std::string subject_;
  ProcessLimits limits_;
  int file_ = -1;   // result of the child
  int child_ = -1;  // -1 after wait()
};

/// Runs `work` in a child process and waits for its result.
ProcessResult run_separately(const std::function<std::string()>& work, const std::string& subject,
                             const ProcessLimits& limits = {});

}  // namespace vrda::store
