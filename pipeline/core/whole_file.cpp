#include "core/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <utility>

#include "core/error.hpp"

namespace vrda {
namespace {

/// Takes errno for the reason.
[[noreturn]] void fail(const std::string& path, const std::string& what)
{
  throw InputError(
      {path, "", what + " (" + std::strerror(errno) + ")", "a folder that can be written and free space"});
}

/// Closes itself; the destructor leaves errno alone, which a message may be about.
class Descriptor {
 public:
  explicit Descriptor(int value) : value_(value) {}
  ~Descriptor()
  {
    const int kept = errno;
    if (value_ >= 0) ::close(value_);
    errno = kept;
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return value_; }
  /// Some file systems tell of a full disk only here.
  bool close() { return ::close(std::exchange(value_, -1)) == 0; }

 private:
  int value_;
};

/// Removes the temporary file unless it got its final name.
class Temporary {
 public:
  explicit Temporary(std::string path) : path_(std::move(path)) {}
  ~Temporary() { std::remove(path_.c_str()); }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

bool is_written(int descriptor, std::string_view bytes)
{
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

/// The new name has reached the disk, too.
void sync_folder(const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const Descriptor descriptor(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.get() < 0 || fsync(descriptor.get()) != 0) fail(path, "a folder that cannot be flushed");
}

}  // namespace

void write_whole(const std::string& path, std::initializer_list<std::string_view> pieces)
{
  const Temporary temporary(path + ".partial");
  Descriptor file(open(temporary.path().c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) fail(path, "an output that cannot be created");
  const bool are_written = std::all_of(pieces.begin(), pieces.end(),
                                       [&](std::string_view piece) { return is_written(file.get(), piece); });
  if (!are_written || fsync(file.get()) != 0 || !file.close()) {
    std::size_t n_bytes = 0;
    for (const std::string_view piece : pieces) n_bytes += piece.size();
    fail(path, "an output of " + std::to_string(n_bytes) + " bytes that cannot be written");
  }
  if (std::rename(temporary.path().c_str(), path.c_str()) != 0) fail(path, "a file that cannot be replaced");
  sync_folder(path);
}

}  // namespace vrda
