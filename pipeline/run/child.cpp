#include "run/child.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <thread>

#include "core/error.hpp"
#include "core/open_file.hpp"

extern "C" char** environ;

namespace vrda::run {
namespace {

constexpr int exit_code_not_found = 127;

[[noreturn]] void fail(const std::string& program, const char* what)
{
  throw InputError({program, "", std::string(what) + ": " + std::strerror(errno),
                    "resources for another process and its files"});
}

// A file in memory for a child's output, which unlike a pipe need not be read while the child writes.
OpenFile output_file(const std::string& program)
{
  OpenFile memory(memfd_create("vrda", MFD_CLOEXEC));
  if (!memory.is_open()) fail(program, "no memory for the program's output");
  return memory;
}

std::string text_in(const OpenFile& memory)
{
  const off_t size = lseek(memory.get(), 0, SEEK_END);
  std::string text(static_cast<std::size_t>(std::max<off_t>(size, 0)), '\0');
  const ssize_t n = pread(memory.get(), text.data(), text.size(), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
  return text;
}

std::vector<char*> pointers_to(const std::vector<std::string>& words)
{
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

// User settings that would override or filter our options of Slurm's programs, and variables of an enclosing
// Slurm job, which sbatch would propagate to the new job.
constexpr std::array<std::string_view, 6> excluded_prefixes{
    "SBATCH_", "SQUEUE_", "SCANCEL_", "SLURM_JOB", "SLURM_ARRAY_", "SLURM_RESTART_COUNT="};
constexpr std::string_view sbatch_export = "SBATCH_EXPORT=";

bool is_for_slurm(std::string_view entry)
{
  return entry.starts_with(sbatch_export) ||
         std::none_of(excluded_prefixes.begin(), excluded_prefixes.end(),
                      [&](std::string_view prefix) { return entry.starts_with(prefix); });
}

bool is_not_slurms(std::string_view entry)
{
  return !entry.starts_with("SLURM");
}

std::vector<std::string> environment_where(bool (*is_kept)(std::string_view))
{
  std::vector<std::string> kept;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (is_kept(*entry)) kept.emplace_back(*entry);
  }
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

int wait_for_exit(pid_t pid)
{
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

ProgramResult run_program(const std::vector<std::string>& words, const std::string& folder)
{
  const OpenFile out = output_file(words.front()), err = output_file(words.front());
  const std::vector<std::string> environment = environment_where(is_for_slurm);
  const std::vector<char*> arguments = pointers_to(words), variables = pointers_to(environment);
  const pid_t pid = fork();
  if (pid < 0) fail(words.front(), "an error on creating the process");
  if (pid == 0) {
    reset_signals();
    dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
    dup2(out.get(), STDOUT_FILENO);
    dup2(err.get(), STDERR_FILENO);
    if (folder.empty() || chdir(folder.c_str()) == 0) {
      execvpe(arguments.front(), arguments.data(), variables.data());
    }
    _exit(errno == ENOENT ? exit_code_not_found : exit_code_not_found - 1);
  }
  const int status = wait_for_exit(pid);
  ProgramResult result{WIFEXITED(status) ? WEXITSTATUS(status) : -1, false, text_in(out), text_in(err)};
  result.is_not_found = result.exit_code == exit_code_not_found && result.out.empty() && result.err.empty();
  return result;
}

pid_t start_program(const std::vector<std::string>& words, const std::string& log)
{
  const OpenFile file(open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  if (!file.is_open()) fail(log, "an error on opening the log");
  const std::vector<std::string> environment = environment_where(is_not_slurms);
  const std::vector<char*> arguments = pointers_to(words), variables = pointers_to(environment);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) fail(words.front(), "an error on creating the process");
  if (pid > 0) return pid;
  reset_signals();
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(exit_code_not_found - 1);  // the parent has already ended
  dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
  dup2(file.get(), STDOUT_FILENO);
  dup2(file.get(), STDERR_FILENO);
  execve(arguments.front(), arguments.data(), variables.data());
  _exit(exit_code_not_found);
}

ChildExit poll_children(const std::vector<pid_t>& children)
{
  for (const pid_t child : children) {
    int status = 0;
    if (waitpid(child, &status, WNOHANG) != child) continue;
    if (WIFEXITED(status)) return {child, WEXITSTATUS(status), 0};
    return {child, -1, WTERMSIG(status)};
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(10));
  return {};
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

}  // namespace vrda::run
