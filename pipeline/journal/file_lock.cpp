#include "journal/file_lock.hpp"

#include <sys/file.h>

#include <cerrno>
#include <cstring>

#include "core/error.hpp"

namespace vrda {

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
