#include "store/separate_process.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <utility>

#include "core/error.hpp"
#include "store/confinement.hpp"

namespace vrda::store {
namespace {

constexpr int done = 0, not_written = 1;

/// Bytes mapped by this process.
std::uint64_t mapped_bytes()
{
  unsigned long long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%llu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void limit(int what, std::uint64_t value)
{
  const rlimit both{value, value};
  setrlimit(static_cast<__rlimit_resource_t>(what), &both);  // a stricter limit remains in force
}

/// `answer` is the descriptor of the result file, the only one that stays open.
void restrict_this_process(const ProcessLimits& limits, int answer)
{
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, limits.processor_s);
  limit(RLIMIT_FSIZE, limits.result_bytes);
  limit(RLIMIT_NPROC, 0);
  if (!is_sanitized) limit(RLIMIT_AS, mapped_bytes() + limits.memory_bytes);
  // The C library would print to the terminal on heap corruption, which the caller reports.
  const int null_device = open("/dev/null", O_RDWR | O_CLOEXEC);
  if (null_device >= 0) {
    dup2(null_device, STDOUT_FILENO);
    dup2(null_device, STDERR_FILENO);
  }
  close_range(STDERR_FILENO + 1, static_cast<unsigned>(answer) - 1, 0);
  close_range(static_cast<unsigned>(answer) + 1, ~0U, 0);
  if (is_sanitized) return;  // keep the sanitizers' signal handlers
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU, SIGXFSZ, SIGINT, SIGTERM})
    std::signal(signal, SIG_DFL);
}

bool write_all(int file, const std::string& text)
{
  std::size_t n_written = 0;
  while (n_written < text.size()) {
    const ssize_t n = ::write(file, text.data() + n_written, text.size() - n_written);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    n_written += static_cast<std::size_t>(n);
  }
  return true;
}

std::string read_all(int file)
{
  struct stat facts = {};
  std::string text(fstat(file, &facts) == 0 ? static_cast<std::size_t>(facts.st_size) : 0, '\0');
  std::size_t n_read = 0;
  while (n_read < text.size()) {
    const ssize_t n = pread(file, text.data() + n_read, text.size() - n_read, static_cast<off_t>(n_read));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    n_read += static_cast<std::size_t>(n);
  }
  text.resize(n_read);
  return text;
}

std::string ending_of(int status, const ProcessLimits& limits)
{
  if (WIFEXITED(status)) return "exit code " + std::to_string(WEXITSTATUS(status));
  const int signal = WTERMSIG(status);
  // Hard and soft limits are equal; at the hard limit the kernel sends SIGKILL.
  if (signal == SIGXCPU) return "more than " + std::to_string(limits.processor_s) + " s of processor time";
  if (signal == SIGXFSZ) return "more than " + std::to_string(limits.result_bytes) + " bytes of values";
  return "signal " + std::to_string(signal);
}

constexpr const char* wanted_process = "resources for another process";

}  // namespace

SeparateProcess::SeparateProcess(const std::function<std::string()>& work, std::string subject,
                                 const ProcessLimits& limits)
    : subject_(std::move(subject)), limits_(limits)
{
  // A file in memory instead of a pipe: the parent need not read while the child writes.
  file_ = memfd_create("vrda", MFD_CLOEXEC);
  if (file_ < 0) throw InputError({subject_, "", std::strerror(errno), wanted_process});
  child_ = fork();
  if (child_ < 0) {
    const int error = errno;
    ::close(file_);
    throw InputError({subject_, "", std::strerror(error), wanted_process});
  }
  if (child_ > 0) return;
  restrict_this_process(limits_, file_);
  _exit(write_all(file_, work()) ? done : not_written);
}

SeparateProcess::~SeparateProcess()
{
  if (child_ > 0) {
    ::kill(child_, SIGKILL);
    wait();
  }
  ::close(file_);
}

int SeparateProcess::wait()
{
  int status = 0;
  pid_t ended = -1;
  do {
    ended = waitpid(child_, &status, 0);
  } while (ended < 0 && errno == EINTR);
  child_ = -1;
  return ended < 0 ? -1 : status;
}

ProcessResult SeparateProcess::wait_for_result()
{
  check(child_ > 0, "the result may be taken once");
  const int status = wait();
  if (status < 0) throw InputError({subject_, "", std::strerror(errno), "the end of a process"});
  if (WIFEXITED(status) && WEXITSTATUS(status) == done) return {true, read_all(file_)};
  return {false, ending_of(status, limits_)};
}

ProcessResult run_separately(const std::function<std::string()>& work, const std::string& subject,
                             const ProcessLimits& limits)
{
  return SeparateProcess(work, subject, limits).wait_for_result();
}

}  // namespace vrda::store
