/// File descriptors, advisory file locks (`flock`), and the lock that gives one process write access to an
/// output.
#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace vrda::inline core {

/// An owned file descriptor. The destructor closes it and preserves errno for messages.
class OpenFile {
 public:
  explicit OpenFile(int value) : value_(value) {}
  ~OpenFile();
  OpenFile(OpenFile&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
  OpenFile& operator=(OpenFile&&) = delete;
  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  int get() const { return value_; }
  bool is_open() const { return value_ >= 0; }
  int release() { return std::exchange(value_, -1); }

 private:
  int value_;
};

/// Whether `path` still names the open file: it may have been replaced by a rename, or removed.
bool is_open_file_at(int descriptor, const std::string& path);

/// Locks the open file without blocking; false while another process holds the lock. Throws InputError naming
/// `path` where the file system does not support locks.
bool try_lock_file(int descriptor, const std::string& path);

/// Writes all bytes; on failure returns false and sets errno.
bool write_all(int descriptor, std::string_view bytes);

/// Flushes the directory entry of a file that was created, renamed or removed. Throws InputError naming
/// `path`.
void sync_parent_directory(const std::string& path);

/// A lock on "<output>.lock", a separate file that no rename replaces; it names its holder and is removed on
/// release. A killed process leaves the file but not the lock. Links to the output share its lock.
class OutputLock {
 public:
  struct WaitOptions {
    /// Called once with the holder ("vrda smooth, process 12 on node3") if the lock is held.
    std::function<void(const std::string& holder)> on_wait;
    /// Polled every 50 ms; true cancels the wait.
    std::function<bool()> is_cancelled = [] { return false; };
  };

  /// Waits for the current holder; empty if cancelled. `command` is reported to waiting processes. Throws
  /// InputError where the folder is not writable or does not support locks.
  static std::optional<OutputLock> acquire(const std::string& output, const std::string& command,
                                           const WaitOptions& waiting);
  /// Whether a process currently holds the lock.
  static bool is_held(const std::string& output);
  ~OutputLock();
  OutputLock(OutputLock&&) = default;
  OutputLock& operator=(OutputLock&&) = delete;

 private:
  OutputLock(std::string path, OpenFile file) : path_(std::move(path)), file_(std::move(file)) {}

  std::string path_;
  OpenFile file_;
};

}  // namespace vrda::inline core
