/// An open file, the lock (`flock`) by which processes take turns, and which process may write an output.
#pragma once

#include <sys/types.h>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace vrda {

/// Closes itself; the destructor leaves errno alone, which a message may be about.
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

/// Whether `path` names the open file: another one may have been renamed to it, or it was removed.
bool is_at(int descriptor, const std::string& path);

/// Locks the open file; false while another process holds it. `path`: for the InputError where the file
/// system has no locks, which must not look like a lock that is held.
bool lock_without_waiting(int descriptor, const std::string& path);

/// Whether all bytes were written; errno says why not.
bool write_all(int descriptor, std::string_view bytes);

/// After a file was made, renamed or removed: its name has reached the disk, too. Throws InputError naming
/// `path`.
void sync_folder(const std::string& path);

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
