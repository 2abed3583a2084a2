/// Which process may read, change and write an output file: one at a time.
#pragma once

#include <functional>
#include <optional>
#include <string>

#include "core/open_file.hpp"

namespace vrda {

/// A lock on "<output>.lock", a file of its own that no rename replaces; it names its holder and is removed
/// on release. A killed process leaves the file, not the lock. Links to the output share its lock.
class OutputLock {
 public:
  struct Waiting {
    /// Called once with the holder ("vrda smooth, process 12 on node3") when there is one.
    std::function<void(const std::string& holder)> begins;
    /// Asked every 50 ms; true gives up.
    std::function<bool()> is_stopped = [] { return false; };
  };

  /// Waits for the present holder. Nothing when `waiting.is_stopped`. `command` is for those who wait. Throws
  /// InputError where the folder cannot be written or has no locks.
  static std::optional<OutputLock> take(const std::string& output, const std::string& command,
                                        const Waiting& waiting);
  /// Whether a process holds it now.
  static bool is_held(const std::string& output);
  ~OutputLock();
  OutputLock(OutputLock&&) = default;
  OutputLock& operator=(OutputLock&&) = delete;

 private:
  OutputLock(std::string path, OpenFile file) : path_(std::move(path)), file_(std::move(file)) {}

  std::string path_;
  OpenFile file_;
};

}  // namespace vrda
