#include "store/whole_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/error.hpp"
#include "store/seal.hpp"

namespace vrda {
namespace {

[[noreturn]] void fail(const std::string& path, const std::string& what)
{
  throw InputError(
      {path, "", what + " (" + std::strerror(errno) + ")", "a folder and a file that can be written"});
}

/// Waits until the content of a file or folder has reached the disk.
void sync(const std::string& path, int flags)
{
  const int descriptor = open(path.c_str(), flags | O_CLOEXEC);
  if (descriptor < 0) fail(path, "no access");
  const int synced = fsync(descriptor);
  const int kept = errno;
  ::close(descriptor);
  errno = kept;
  if (synced != 0) fail(path, "a failed flush");
}

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

/// The library's reasons are about its own inside; a plain open says what a user can mend.
void require_writable(const std::string& path, const std::string& temporary)
{
  const int descriptor = open(temporary.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) fail(path, "an output that cannot be created");
  ::close(descriptor);
}

}  // namespace

void write_whole(const std::string& path, const std::function<void(const std::string& temporary)>& write)
{
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const Temporary temporary(path + ".partial");
  require_writable(path, temporary.path());
  write(temporary.path());
  seal(temporary.path());
  sync(temporary.path(), O_RDONLY);
  if (std::rename(temporary.path().c_str(), path.c_str()) != 0) fail(path, "a file that cannot be replaced");
  sync(folder, O_RDONLY | O_DIRECTORY);
}

}  // namespace vrda
