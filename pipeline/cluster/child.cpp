#include "cluster/child.hpp"

#include <fcntl.h>
#include <poll.h>
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
#include <string_view>
#include <thread>
#include <utility>

#include "core/error.hpp"

extern "C" char** environ;

namespace vrda {
namespace {

constexpr int code_of_absence = 127;

// Closes itself.
class Descriptor {
 public:
  explicit Descriptor(int value = -1) : value_(value) {}
  ~Descriptor() { close(); }
  Descriptor(Descriptor&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  int get() const { return value_; }
  void close()
  {
    if (value_ >= 0) ::close(std::exchange(value_, -1));
  }

 private:
  int value_;
};

struct Pipe {
  Descriptor read;
  Descriptor write;
};

[[noreturn]] void fail(const std::string& program, const char* what)
{
  throw InputError({program, "", std::string(what) + " (" + std::strerror(errno) + ")",
                    "room for one more process and its files"});
}

Pipe make_pipe(const std::string& program)
{
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) fail(program, "no pipe");
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

std::vector<char*> pointers_to(const std::vector<std::string>& words)
{
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

// What a user has set for Slurm's programs, which would overrule or filter what we ask them for; and, within
// a job of Slurm's, what tells of that: sbatch hands all of it on to the new one.
constexpr std::array<std::string_view, 6> others_prefixes{
    "SBATCH_", "SQUEUE_", "SCANCEL_", "SLURM_JOB", "SLURM_ARRAY_", "SLURM_RESTART_COUNT="};
constexpr std::string_view wanted_by_sbatch = "SBATCH_EXPORT=";

std::vector<std::string> environment_for_slurm()
{
  std::vector<std::string> kept;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string text = *entry;
    const bool is_others = std::any_of(others_prefixes.begin(), others_prefixes.end(),
                                       [&](std::string_view prefix) { return text.starts_with(prefix); });
    if (!is_others || text.starts_with(wanted_by_sbatch)) kept.push_back(text);
  }
  return kept;
}

std::vector<std::string> environment_without_slurm()
{
  std::vector<std::string> kept;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    if (!std::string_view(*entry).starts_with("SLURM")) kept.emplace_back(*entry);
  }
  return kept;
}

// What a handler or a mask of ours would mean to another program.
void forget_signals()
{
  for (const int signal : {SIGINT, SIGTERM, SIGPIPE}) std::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
}

void read_some(Descriptor& from, std::string& into)
{
  std::array<char, 65536> bytes{};
  const ssize_t n = read(from.get(), bytes.data(), bytes.size());
  if (n > 0) into.append(bytes.data(), static_cast<std::size_t>(n));
  if (n == 0 || (n < 0 && errno != EINTR)) from.close();
}

void read_both(Said& said, Descriptor& out, Descriptor& err)
{
  while (out.get() >= 0 || err.get() >= 0) {
    std::array<pollfd, 2> ends{{{out.get(), POLLIN, 0}, {err.get(), POLLIN, 0}}};
    if (poll(ends.data(), ends.size(), -1) < 0) continue;
    if (ends[0].revents != 0) read_some(out, said.out);
    if (ends[1].revents != 0) read_some(err, said.err);
  }
}

int waited(pid_t pid)
{
  int status = 0;
  while (waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  return status;
}

}  // namespace

Said run_program(const std::vector<std::string>& words, const std::string& folder)
{
  Pipe out = make_pipe(words.front()), err = make_pipe(words.front());
  const std::vector<std::string> environment = environment_for_slurm();
  const std::vector<char*> arguments = pointers_to(words), variables = pointers_to(environment);
  const pid_t pid = fork();
  if (pid < 0) fail(words.front(), "no process");
  if (pid == 0) {
    forget_signals();
    dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
    dup2(out.write.get(), STDOUT_FILENO);
    dup2(err.write.get(), STDERR_FILENO);
    if (folder.empty() || chdir(folder.c_str()) == 0) {
      execvpe(arguments.front(), arguments.data(), variables.data());
    }
    _exit(errno == ENOENT ? code_of_absence : code_of_absence - 1);
  }
  out.write.close();
  err.write.close();
  Said said;
  read_both(said, out.read, err.read);
  const int status = waited(pid);
  said.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  said.is_absent = said.exit_code == code_of_absence && said.out.empty() && said.err.empty();
  return said;
}

pid_t start_program(const std::vector<std::string>& words, const std::string& log)
{
  const Descriptor file(open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  if (file.get() < 0) fail(log, "a log that cannot be opened");
  const std::vector<std::string> environment = environment_without_slurm();
  const std::vector<char*> arguments = pointers_to(words), variables = pointers_to(environment);
  const pid_t parent = getpid();
  const pid_t pid = fork();
  if (pid < 0) fail(words.front(), "no process");
  if (pid > 0) return pid;
  forget_signals();
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(code_of_absence - 1);  // it ended just before
  dup2(open("/dev/null", O_RDONLY | O_CLOEXEC), STDIN_FILENO);
  dup2(file.get(), STDOUT_FILENO);
  dup2(file.get(), STDERR_FILENO);
  execve(arguments.front(), arguments.data(), variables.data());
  _exit(code_of_absence);
}

Ending wait_a_moment(const std::vector<pid_t>& children)
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

}  // namespace vrda
