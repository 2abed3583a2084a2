/// File descriptors, advisory file locks (`flock`), and the lock that gives one process write access to an
/// output.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/text.hpp"

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
/// `path` where the file system does not support locks, unless permit_missing_locks() was called.
bool try_lock_file(int descriptor, const std::string& path);

/// From now on a lock that the file system does not support counts as taken (--no-lock). `report` gets a
/// warning for the first one.
void permit_missing_locks(std::function<void(const std::string& warning)> report);
bool are_missing_locks_permitted();
/// That warning, for the results of this process; empty while every lock was taken.
const std::string& missing_lock_warning();

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
  /// Whether a process currently holds the lock; on a file system without locks, whether the process that
  /// the file names runs on this host.
  static bool is_held(const std::string& output);
  ~OutputLock();
  OutputLock(OutputLock&&) = default;
  OutputLock& operator=(OutputLock&&) = delete;

 private:
  OutputLock(std::string path, OpenFile file) : path_(std::move(path)), file_(std::move(file)) {}

  std::string path_;
  OpenFile file_;
};

// Atomic file replacement: a reader finds the old file or the complete new one.

/// The error of a path that the system refuses: too long, a cycle of links, without permission.
InputError input_error_of(const std::filesystem::filesystem_error& error);

/// `path` with symbolic links resolved; the target need not exist. Throws InputError on a cycle of links.
std::string resolve_links(const std::string& path);

/// File type by its first bytes: "an HDF5 file", "a JSON file", "a text file", ...; empty for no bytes.
std::string_view file_type_of(std::string_view head);

/// Throws InputError where write_atomically would refuse `path`: a file without write permission, or of
/// another type than one that begins with `head`.
void require_same_file_type(const std::string& path, std::string_view head);

/// The content of a small file; empty where it cannot be opened.
std::optional<std::string> read_text_file(const std::string& path);

/// A complete new file beside `path`, which keeps its old content until swap_in(). Throws InputError as
/// write_atomically. The destructor removes the new file unless it was swapped in.
class NewFile {
 public:
  NewFile(const std::string& path, std::initializer_list<std::string_view> pieces);
  /// Takes `file`, which another program has written in the folder of the target.
  static NewFile of_written(const std::string& path, const std::string& file);
  NewFile(NewFile&&) noexcept;
  ~NewFile();

  /// Renames the file to its target.
  void swap_in();

 private:
  class Temporary;
  explicit NewFile(const std::string& path);
  std::string path_, target_;
  std::unique_ptr<Temporary> temporary_;  ///< none for a device, which was written directly
};

/// Writes the concatenated pieces to a unique temporary file in the same folder, flushes and renames it.
/// Links are followed; a replaced file's mode, owner and group are kept. Temporary files of dead writers are
/// removed. A target that is not a regular file (device, pipe) is written directly. Throws InputError naming
/// `path` and the system's reason, and where `path` has no write permission or another type than the new
/// file; the temporary file is then removed.
void write_atomically(const std::string& path, std::initializer_list<std::string_view> pieces);

// The one operation that puts a result under its name: lock, check, write beside, swap.

/// A result of one file, or of several of which readers open `main`. `main` is removed before the first file
/// is replaced and written last, so that no reader takes files of two results for one.
class Publication {
 public:
  /// Takes the lock of `main`, held by the Publication; a device or pipe has none. Empty if the wait is
  /// cancelled. Throws InputError where `main` is a folder, or as OutputLock::acquire.
  static std::optional<Publication> begin(const std::string& main, const std::string& command,
                                          const OutputLock::WaitOptions& waiting = {});

  /// Throws InputError for the first of `files` that exists, with the other facts of `refusal`, unless a
  /// publication of `main` that was killed has left it.
  void require_absent(const std::vector<std::string>& files, InputError::Facts refusal) const;

  /// Writes another file of the result beside its target. Throws InputError as write_atomically.
  void add(const std::string& file, std::string_view bytes);

  /// Writes `main` and swaps all files in; removes those of `obsolete` that were not added.
  void publish(std::string_view main_bytes, const std::vector<std::string>& obsolete = {});

  /// The same with `file`, which another program has written in the folder of `main`, as `main`.
  void publish_written(const std::string& file);

 private:
  Publication(std::string main, std::optional<OutputLock> lock);

  std::string note() const;
  std::string name_in_note(const std::string& file) const;
  void publish(NewFile main, const std::vector<std::string>& obsolete);
  void start_swap();
  void swap_added();

  std::string main_;
  std::optional<OutputLock> lock_;
  std::set<std::string> left_;   ///< files of a killed publication, as in its note
  std::set<std::string> names_;  ///< files added, as in the note
  std::vector<NewFile> added_;   ///< not yet swapped in
};

}  // namespace vrda::inline core
