#include "core/open_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/error.hpp"

namespace vrda {

OpenFile::~OpenFile()
{
  const int kept = errno;
  if (value_ >= 0) ::close(value_);
  errno = kept;
}

bool is_at(int descriptor, const std::string& path)
{
  struct stat opened {
  }, named{};
  return fstat(descriptor, &opened) == 0 && stat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

bool lock_without_waiting(int descriptor, const std::string& path)
{
  while (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) return false;
    if (errno == EINTR) continue;
    throw InputError({path, "", std::string("a lock that cannot be taken (") + std::strerror(errno) + ")",
                      "a file system with flock (Lustre: mounted with -o flock)"});
  }
  return true;
}

bool write_all(int descriptor, std::string_view bytes)
{
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

void sync_folder(const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const OpenFile descriptor(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.is_open() && fsync(descriptor.get()) == 0) return;
  throw InputError({path, "", std::string("a folder that cannot be flushed (") + std::strerror(errno) + ")",
                    "a folder that can be written and free space"});
}

}  // namespace vrda
