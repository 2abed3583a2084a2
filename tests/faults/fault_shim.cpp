// Interposes the C library (LD_PRELOAD) and injects the fault of fault_plan.hpp into system calls. Other
// calls are forwarded to the next library, so that sanitizers still intercept them.
#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstdarg>
#include <cstdio>
#include <cstring>

#include "faults/fault_plan.hpp"

namespace {

using vrda::test::Call;
using vrda::test::CallDecision;
using vrda::test::CallOutcome;
using vrda::test::decide_call;
using vrda::test::is_watching;
using vrda::test::kill_self;

/// The same function of the next library.
template <typename F>
F* next(const char* name)
{
  F* const found = reinterpret_cast<F*>(dlsym(RTLD_NEXT, name));
  if (found == nullptr) kill_self();
  return found;
}

/// A path, or the current path of a descriptor's file.
class Name {
 public:
  explicit Name(int descriptor)
  {
    if (!is_watching()) return;
    const int kept = errno;
    char link[48];
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
    const ssize_t n = readlink(link, text_.data(), text_.size() - 1);
    text_[static_cast<std::size_t>(std::max<ssize_t>(n, 0))] = '\0';
    errno = kept;
  }
  explicit Name(const char* path) : Name(AT_FDCWD, path) {}
  Name(int folder, const char* path)
  {
    if (!is_watching()) return;
    const int kept = errno;
    std::array<char, PATH_MAX> base{};
    if (path[0] != '/') {
      if (folder == AT_FDCWD) {
        if (getcwd(base.data(), base.size() - 1) == nullptr) base[0] = '\0';
      } else {
        base = Name(folder).text_;
      }
    }
    const std::size_t n = std::strlen(base.data());
    std::memcpy(text_.data(), base.data(), n);
    std::snprintf(text_.data() + n, text_.size() - n, n > 0 ? "/%s" : "%s", path);
    errno = kept;
  }
  const char* text() const { return text_.data(); }

 private:
  std::array<char, PATH_MAX> text_{};
};

int failed(const CallDecision& verdict)
{
  errno = verdict.error;
  return -1;
}

/// `write_first(n)` writes the first n of `n_bytes` bytes.
template <typename WriteFirst>
ssize_t written(int descriptor, std::size_t n_bytes, const WriteFirst& write_first)
{
  const CallDecision verdict = decide_call(Call::write, Name(descriptor).text());
  switch (verdict.outcome) {
    case CallOutcome::fail:
      return failed(verdict);
    case CallOutcome::half:
      return write_first(std::max<std::size_t>(n_bytes / 2, std::min<std::size_t>(n_bytes, 1)));
    case CallOutcome::half_then_kill:
      write_first(n_bytes / 2);
      kill_self();
    case CallOutcome::pass:
      break;
  }
  return write_first(n_bytes);
}

/// Half of several buffers: the first non-empty one, or a part of it.
template <typename WriteBuffers>
ssize_t written(int descriptor, const iovec* buffers, int n_buffers, const WriteBuffers& write_buffers)
{
  std::size_t n_bytes = 0;
  for (int i = 0; i < n_buffers; ++i) n_bytes += buffers[i].iov_len;
  return written(descriptor, n_bytes, [&](std::size_t n) -> ssize_t {
    if (n == n_bytes) return write_buffers(buffers, n_buffers);
    const iovec* first =
        std::find_if(buffers, buffers + n_buffers, [](const iovec& b) { return b.iov_len > 0; });
    if (first == buffers + n_buffers) return 0;
    const iovec part{first->iov_base, std::min(first->iov_len, n)};
    return write_buffers(&part, 1);
  });
}

/// A call that either happens or fails.
template <typename Really>
int done(Call call, const Name& name, const char* other, const Really& really)
{
  const CallDecision verdict = decide_call(call, name.text(), other);
  return verdict.outcome == CallOutcome::fail ? failed(verdict) : really();
}
template <typename Really>
int done(Call call, const Name& name, const Really& really)
{
  return done(call, name, "", really);
}

bool is_for_writing(int flags)
{
  return (flags & O_ACCMODE) != O_RDONLY || (flags & (O_CREAT | O_TRUNC)) != 0;
}

template <typename Really>
int opened(const Name& name, int flags, const Really& really)
{
  return is_for_writing(flags) ? done(Call::open, name, really) : really();
}

/// The mode argument exists only if the flags may create a file.
mode_t mode_in(std::va_list words, int flags)
{
  const bool makes_file = (flags & O_CREAT) != 0 || (flags & O_TMPFILE) == O_TMPFILE;
  return makes_file ? va_arg(words, mode_t) : 0;
}

/// A short read requests fewer bytes.
template <typename ReadFirst>
ssize_t taken(int descriptor, std::size_t n_bytes, const ReadFirst& read_first)
{
  const CallDecision verdict = decide_call(Call::read, Name(descriptor).text());
  if (verdict.outcome == CallOutcome::fail) return failed(verdict);
  return read_first(verdict.outcome == CallOutcome::half ? (n_bytes + 1) / 2 : n_bytes);
}

}  // namespace

extern "C" {

// The variants with 64-bit offsets are the same functions on 64-bit machines.
ssize_t pwrite64(int, const void*, std::size_t, off_t) __attribute__((alias("pwrite")));
ssize_t pread64(int, void*, std::size_t, off_t) __attribute__((alias("pread")));
int ftruncate64(int, off_t) noexcept __attribute__((alias("ftruncate")));
int open64(const char*, int, ...) __attribute__((alias("open")));
int openat64(int, const char*, int, ...) __attribute__((alias("openat")));
std::FILE* fopen64(const char*, const char*) __attribute__((alias("fopen")));

ssize_t write(int descriptor, const void* bytes, std::size_t n_bytes)
{
  return written(descriptor, n_bytes, [&](std::size_t n) {
    return next<ssize_t(int, const void*, std::size_t)>("write")(descriptor, bytes, n);
  });
}
ssize_t pwrite(int descriptor, const void* bytes, std::size_t n_bytes, off_t at)
{
  return written(descriptor, n_bytes, [&](std::size_t n) {
    return next<ssize_t(int, const void*, std::size_t, off_t)>("pwrite")(descriptor, bytes, n, at);
  });
}
ssize_t writev(int descriptor, const iovec* buffers, int n_buffers)
{
  return written(descriptor, buffers, n_buffers, [&](const iovec* some, int n) {
    return next<ssize_t(int, const iovec*, int)>("writev")(descriptor, some, n);
  });
}

ssize_t read(int descriptor, void* bytes, std::size_t n_bytes)
{
  return taken(descriptor, n_bytes, [&](std::size_t n) {
    return next<ssize_t(int, void*, std::size_t)>("read")(descriptor, bytes, n);
  });
}
ssize_t pread(int descriptor, void* bytes, std::size_t n_bytes, off_t at)
{
  return taken(descriptor, n_bytes, [&](std::size_t n) {
    return next<ssize_t(int, void*, std::size_t, off_t)>("pread")(descriptor, bytes, n, at);
  });
}

int fsync(int descriptor)
{
  return done(Call::fsync, Name(descriptor), [&] { return next<int(int)>("fsync")(descriptor); });
}
int fdatasync(int descriptor)
{
  return done(Call::fsync, Name(descriptor), [&] { return next<int(int)>("fdatasync")(descriptor); });
}

int ftruncate(int descriptor, off_t size) noexcept
{
  return done(Call::truncate, Name(descriptor),
              [&] { return next<int(int, off_t)>("ftruncate")(descriptor, size); });
}

int flock(int descriptor, int how) noexcept
{
  return done(Call::lock, Name(descriptor), [&] { return next<int(int, int)>("flock")(descriptor, how); });
}

// An entry that fails is omitted, as in a listing from before the file was created.
dirent* readdir(DIR* folder)
{
  for (;;) {
    dirent* const entry = next<dirent*(DIR*)>("readdir")(folder);
    if (entry == nullptr || !is_watching()) return entry;
    const Name path(dirfd(folder), entry->d_name);
    if (decide_call(Call::list, path.text()).outcome != CallOutcome::fail) return entry;
  }
}

dirent64* readdir64(DIR* folder)
{
  return reinterpret_cast<dirent64*>(readdir(folder));
}

int rename(const char* from, const char* to) noexcept
{
  return done(Call::rename, Name(from), Name(to).text(),
              [&] { return next<int(const char*, const char*)>("rename")(from, to); });
}
int renameat(int from_folder, const char* from, int to_folder, const char* to) noexcept
{
  return done(Call::rename, Name(from_folder, from), Name(to_folder, to).text(), [&] {
    return next<int(int, const char*, int, const char*)>("renameat")(from_folder, from, to_folder, to);
  });
}

int unlink(const char* path) noexcept
{
  return done(Call::unlink, Name(path), [&] { return next<int(const char*)>("unlink")(path); });
}
int unlinkat(int folder, const char* path, int flags) noexcept
{
  return done(Call::unlink, Name(folder, path),
              [&] { return next<int(int, const char*, int)>("unlinkat")(folder, path, flags); });
}
int remove(const char* path) noexcept
{
  return done(Call::unlink, Name(path), [&] { return next<int(const char*)>("remove")(path); });
}

int open(const char* path, int flags, ...)
{
  std::va_list words;
  va_start(words, flags);
  const mode_t mode = mode_in(words, flags);
  va_end(words);
  return opened(Name(path), flags,
                [&] { return next<int(const char*, int, ...)>("open")(path, flags, mode); });
}
int openat(int folder, const char* path, int flags, ...)
{
  std::va_list words;
  va_start(words, flags);
  const mode_t mode = mode_in(words, flags);
  va_end(words);
  return opened(Name(folder, path), flags,
                [&] { return next<int(int, const char*, int, ...)>("openat")(folder, path, flags, mode); });
}
std::FILE* fopen(const char* path, const char* mode)
{
  const bool is_writing = mode[0] != 'r' || std::strchr(mode, '+') != nullptr;
  const CallDecision verdict = is_writing ? decide_call(Call::open, Name(path).text()) : CallDecision{};
  if (verdict.outcome != CallOutcome::fail)
    return next<std::FILE*(const char*, const char*)>("fopen")(path, mode);
  errno = verdict.error;
  return nullptr;
}

// A failed close still closes the descriptor, as on Linux.
int close(int descriptor)
{
  const CallDecision verdict = decide_call(Call::close, Name(descriptor).text());
  const int result = next<int(int)>("close")(descriptor);
  return verdict.outcome == CallOutcome::fail ? failed(verdict) : result;
}
int fclose(std::FILE* file)
{
  const CallDecision verdict = decide_call(Call::close, Name(fileno(file)).text());
  const int result = next<int(std::FILE*)>("fclose")(file);
  return verdict.outcome == CallOutcome::fail ? failed(verdict) : result;
}

int clock_gettime(clockid_t clock, timespec* now) noexcept
{
  const int result = next<int(clockid_t, timespec*)>("clock_gettime")(clock, now);
  if (result == 0) *now = vrda::test::with_clock_fault(*now);
  return result;
}

}  // extern "C"
