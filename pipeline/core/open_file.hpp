/// An open file, and the lock (`flock`) by which processes take turns.
#pragma once

#include <sys/types.h>

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

}  // namespace vrda
