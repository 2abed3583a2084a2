#include "core/process.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <thread>

#include "core/files.hpp"
#include "core/text.hpp"

extern "C" char** environ;

namespace vrda::inline core {
namespace {

// As a shell reports them.
constexpr int exit_code_not_found = 127, exit_code_not_started = 126;

std::vector<char*> pointers_to(const std::vector<std::string>& words)
{
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

std::vector<std::string> inherited_environment(const ProcessOptions& options)
{
  std::vector<std::string> kept;
  for (char** entry = environ; *entry != nullptr; ++entry)
    if (options.is_inherited == nullptr || options.is_inherited(*entry)) kept.emplace_back(*entry);
  return kept;
}

// Restores default handlers and an empty mask, which a child process would inherit.
void reset_signals()
{
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE}) std::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

// The child between fork and exec, where only system calls are allowed. Writes errno to `failure` and ends if
// the program does not start.
[[noreturn]] void become(char* const* arguments, char* const* environment, const ProcessOptions& options,
                         pid_t parent, int failure)
{
  reset_signals();
  if (options.is_tied) {
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(exit_code_not_started);  // the parent has already ended
  }
  const int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
  const std::array<int, 3> streams{options.in, options.out, options.err};
  for (std::size_t k = 0; k < streams.size(); ++k)
    dup2(streams[k] < 0 ? nothing : streams[k], static_cast<int>(k));
  if (options.folder.empty() || chdir(options.folder.c_str()) == 0)
    execvpe(arguments[0], arguments, environment);
  const int error = errno;
  [[maybe_unused]] const ssize_t n = write(failure, &error, sizeof error);
  _exit(error == ENOENT ? exit_code_not_found : exit_code_not_started);
}

// A file in memory for a child's output, which unlike a pipe need not be read while the child writes.
OpenFile output_file()
{
  return OpenFile(memfd_create("vrda", MFD_CLOEXEC));
}

std::string text_in(const OpenFile& memory)
{
  const off_t size = lseek(memory.get(), 0, SEEK_END);
  std::string text(static_cast<std::size_t>(std::max<off_t>(size, 0)), '\0');
  const ssize_t n = pread(memory.get(), text.data(), text.size(), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
  return text;
}

ProcessEnd end_of(pid_t pid, int status)
{
  if (WIFEXITED(status)) return {pid, WEXITSTATUS(status), 0};
  return {pid, -1, WTERMSIG(status)};
}

}  // namespace

StartedProcess start_process(const std::vector<std::string>& words, const ProcessOptions& options)
{
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return {-1, errno};
  const OpenFile failure(ends[0]);
  OpenFile failure_of_child(ends[1]);
  const std::vector<std::string> environment = inherited_environment(options);
  const std::vector<char*> arguments = pointers_to(words), variables = pointers_to(environment);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) return {-1, errno};
  if (pid == 0) become(arguments.data(), variables.data(), options, parent, failure_of_child.get());
  close(failure_of_child.release());
  // Started programs close their end.
  int error = 0;
  while (read(failure.get(), &error, sizeof error) < 0 && errno == EINTR) {
  }
  return {pid, error};
}

ProcessEnd wait_for_process(pid_t pid)
{
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return end_of(pid, status);
}

ProcessEnd poll_processes(const std::vector<pid_t>& children)
{
  for (const pid_t child : children) {
    int status = 0;
    if (waitpid(child, &status, WNOHANG) == child) return end_of(child, status);
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return {};
}

ProgramResult run_program(const std::vector<std::string>& words, ProcessOptions options)
{
  const OpenFile out = output_file(), err = output_file();
  options.out = out.get();
  options.err = err.get();
  const bool has_files = out.is_open() && err.is_open();
  const StartedProcess started = has_files ? start_process(words, options) : StartedProcess{-1, errno};
  if (started.pid < 0) {
    throw InputError({words.front(), "",
                      std::string("an error on creating the process: ") + std::strerror(started.error),
                      "resources for another process and its files"});
  }
  const int exit_code = wait_for_process(started.pid).exit_code;
  return {exit_code, started.error == ENOENT, text_in(out), text_in(err)};
}

std::string program_to_start(const std::string& executable, const std::string& called_by)
{
  const bool is_loader = std::filesystem::path(executable).filename().string().starts_with("ld-linux");
  return is_loader ? called_by : executable;
}

std::string own_program()
{
  std::error_code error;
  const std::filesystem::path executable = std::filesystem::read_symlink("/proc/self/exe", error);
  return error ? "" : program_to_start(executable.string(), program_invocation_name);
}

namespace {

bool has_cpu_controller(const std::string& controllers)
{
  return (',' + controllers + ',').find(",cpu,") != std::string::npos;
}

/// The process's cgroup in the hierarchy of version 2, or in that of version 1 with the controller cpu.
std::string cgroup_path(const std::string& root, bool is_version_2)
{
  std::ifstream cgroups(root + "/proc/self/cgroup");  // "4:cpu,cpuacct:/path" or "0::/path"
  std::string number, controllers, path;
  while (std::getline(cgroups, number, ':') && std::getline(cgroups, controllers, ':') &&
         std::getline(cgroups, path)) {
    if (is_version_2 ? controllers.empty() : has_cpu_controller(controllers)) return path;
  }
  return "";
}

/// Processors that one cgroup may use; infinite without a quota.
double quota_of(const std::string& cgroup)
{
  double quota = 0.0, period = 0.0;
  if (std::ifstream version_2(cgroup + "/cpu.max"); version_2) {
    version_2 >> quota >> period;  // "max 100000" without a quota
  } else {
    std::ifstream(cgroup + "/cpu.cfs_quota_us") >> quota;  // -1 without a quota
    std::ifstream(cgroup + "/cpu.cfs_period_us") >> period;
  }
  return quota > 0.0 && period > 0.0 ? quota / period : std::numeric_limits<double>::infinity();
}

/// The smallest quota of the process's cgroups and those above them, as far as they are mounted.
double cgroup_quota(const std::string& root)
{
  double least = std::numeric_limits<double>::infinity();
  std::ifstream mounts(root + "/proc/self/mountinfo");
  for (std::string line; std::getline(mounts, line);) {
    // "32 31 0:29 /top /sys/fs/cgroup/cpu rw,relatime - cgroup cgroup rw,cpu"
    std::istringstream words(line);
    std::string skipped, top, point, type, options;
    words >> skipped >> skipped >> skipped >> top >> point;
    while (words >> skipped && skipped != "-") continue;
    words >> type >> skipped >> options;
    const bool is_version_2 = type == "cgroup2";
    if (!is_version_2 && !(type == "cgroup" && has_cpu_controller(options))) continue;
    std::string path = cgroup_path(root, is_version_2);
    if (top != "/" && path.starts_with(top)) path.erase(0, top.size());  // a container's top
    for (;; path.erase(path.rfind('/'))) {
      least = std::min(least, quota_of(root + point + path));
      if (path.rfind('/') == std::string::npos) break;
    }
  }
  return least;
}

}  // namespace

int usable_processors(const std::string& root)
{
  cpu_set_t processors;  // a system with more than 1,024 refuses the call
  const double n = sched_getaffinity(0, sizeof processors, &processors) == 0
                       ? CPU_COUNT(&processors)
                       : std::thread::hardware_concurrency();
  return std::max(1, static_cast<int>(std::ceil(std::min(n, cgroup_quota(root)))));
}

}  // namespace vrda::inline core
