#include "core/open_file.hpp"

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
  return fstat(descriptor, &opened) == 0 && stat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
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

}  // namespace vrda
