#include "core/open_file.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "core/atomic_file.hpp"
#include "core/error.hpp"

namespace vrda::inline core {

OpenFile::~OpenFile()
{
  const int kept = errno;
  if (value_ >= 0) ::close(value_);
  errno = kept;
}

bool is_open_file_at(int descriptor, const std::string& path)
{
  struct stat opened {
  }, named{};
  return fstat(descriptor, &opened) == 0 && stat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

bool try_lock_file(int descriptor, const std::string& path)
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

void sync_parent_directory(const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const OpenFile descriptor(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.is_open() && fsync(descriptor.get()) == 0) return;
  throw InputError({path, "", std::string("a folder that cannot be flushed (") + std::strerror(errno) + ")",
                    "a folder that can be written and free space"});
}

namespace {

std::string host_name()
{
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown host";
}

OpenFile opened(const std::string& path)
{
  OpenFile file(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (file.is_open() || errno != EACCES) return file;
  OpenFile other(open(path.c_str(), O_RDONLY | O_CLOEXEC));  // another user's file in a shared folder
  if (!other.is_open()) errno = EACCES;
  return other;
}

std::string holder_in(int descriptor)
{
  std::array<char, 512> text{};
  const ssize_t n = pread(descriptor, text.data(), text.size(), 0);
  return n > 0 ? std::string(text.data(), static_cast<std::size_t>(n)) : "another process";
}

}  // namespace

std::optional<OutputLock> OutputLock::acquire(const std::string& output, const std::string& command,
                                              const WaitOptions& waiting)
{
  const std::string path = resolve_links(output) + ".lock";
  for (bool is_announced = false;;) {
    OpenFile file = opened(path);
    if (!file.is_open()) {
      throw InputError({output, "", std::strerror(errno), "a folder that exists and can be written"});
    }
    if (try_lock_file(file.get(), output)) {
      if (!is_open_file_at(file.get(), path)) continue;  // the previous holder has just removed it
      const std::string holder = command + ", process " + std::to_string(getpid()) + " on " + host_name();
      // Informative only: a write error (full disk) is ignored.
      if (ftruncate(file.get(), 0) == 0)
        static_cast<void>(!pwrite(file.get(), holder.data(), holder.size(), 0));
      return OutputLock(path, std::move(file));
    }
    if (!is_announced && waiting.on_wait) waiting.on_wait(holder_in(file.get()));
    is_announced = true;
    if (waiting.is_cancelled()) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

bool OutputLock::is_held(const std::string& output)
{
  const OpenFile file(open((resolve_links(output) + ".lock").c_str(), O_RDONLY | O_CLOEXEC));
  return file.is_open() && flock(file.get(), LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
}

OutputLock::~OutputLock()
{
  if (file_.is_open()) unlink(path_.c_str());  // while locked, so a new holder's file is never removed
}

}  // namespace vrda::inline core
