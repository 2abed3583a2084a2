/// Work on bytes from outside in a process that may end badly.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace vrda {

struct ProcessLimits {
  std::uint64_t memory_bytes = std::uint64_t{512} << 20;  ///< beyond what this process has mapped already
  std::uint64_t answer_bytes = std::uint64_t{256} << 20;
  unsigned processor_s = 5;  ///< several hundred times what a model takes
};

/// How the process ended.
struct SeparateAnswer {
  bool is_whole = false;
  std::string text;  ///< what `work` returned; where it returned nothing, how it ended instead: "signal 11"
};

/// Work on its way in a copy of this process, which goes on meanwhile. The copy has the limits and none of
/// this process's open files, writes no core and nothing to the terminal, and goes when this process goes;
/// what `work` changes is lost with it. `work` must not throw. Threads are not copied: locks that others hold
/// at the call stay locked there, so call it while no other thread uses what `work` does. Under address and
/// thread sanitizers, which map more than any limit, memory is not limited. Throws InputError naming
/// `subject` where no process can be made.
class SeparateWork {
 public:
  SeparateWork(const std::function<std::string()>& work, std::string subject,
               const ProcessLimits& limits = {});
  /// Ends the copy when nobody waited for it.
  ~SeparateWork();
  SeparateWork(const SeparateWork&) = delete;
  SeparateWork& operator=(const SeparateWork&) = delete;

  /// Waits for the work's end. Once only.
  SeparateAnswer answer();

 private:
  int wait();  // how the copy ended, as waitpid tells it

  std::string subject_;
  ProcessLimits limits_;
  int file_ = -1;   // takes the answer
  int child_ = -1;  // until it was waited for
};

/// The answer of such work, waited for.
SeparateAnswer answer_apart(const std::function<std::string()>& work, const std::string& subject,
                            const ProcessLimits& limits = {});

}  // namespace vrda
