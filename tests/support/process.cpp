#include "support/process.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <stdexcept>

#include "support/scratch.hpp"

namespace vrda::test {
namespace {

std::filesystem::path temporary_file()
{
  std::string name = (std::filesystem::temp_directory_path() / "vrda-said-XXXXXX").string();
  const int descriptor = mkstemp(name.data());
  if (descriptor < 0) throw std::runtime_error("cannot make a temporary file");
  close(descriptor);
  return name;
}

[[noreturn]] void become(const Command& command, const std::filesystem::path& out,
                         const std::filesystem::path& err)
{
  dup2(open(out.c_str(), O_WRONLY | O_TRUNC), STDOUT_FILENO);
  dup2(open(err.c_str(), O_WRONLY | O_TRUNC), STDERR_FILENO);
  for (const auto& [name, value] : command.environment) setenv(name.c_str(), value.c_str(), 1);
  if (!command.folder.empty() && chdir(command.folder.c_str()) != 0) _exit(126);
  std::vector<char*> words{const_cast<char*>(command.program.c_str())};
  for (const std::string& word : command.arguments) words.push_back(const_cast<char*>(word.c_str()));
  words.push_back(nullptr);
  execv(command.program.c_str(), words.data());
  _exit(127);
}

}  // namespace

Process::Process(const Command& command) : out_(temporary_file()), err_(temporary_file())
{
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error("cannot fork");
  if (pid_ == 0) become(command, out_, err_);
}

Process::~Process()
{
  if (is_running()) {
    send(SIGKILL);
    wait();
  }
  std::error_code ignored;
  std::filesystem::remove(out_, ignored);
  std::filesystem::remove(err_, ignored);
}

void Process::reap(int options)
{
  rusage used{};
  if (is_reaped_ || wait4(pid_, &status_, options, &used) != pid_) return;
  is_reaped_ = true;
  peak_kb_ = used.ru_maxrss;
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  processor_s_ = seconds(used.ru_utime) + seconds(used.ru_stime);
}

bool Process::is_running()
{
  reap(WNOHANG);
  return !is_reaped_;
}

void Process::send(int signal) const
{
  kill(pid_, signal);
}

std::string Process::said() const
{
  return read_bytes(err_);
}

bool Process::runs_until(const std::function<bool()>& condition)
{
  while (is_running() && !condition()) usleep(2000);
  return is_running();
}

bool Process::runs_until_file(const std::filesystem::path& file)
{
  return runs_until([&] { return std::filesystem::exists(file); });
}

bool Process::runs_until_said(const std::string& text)
{
  return runs_until([&] { return said().find(text) != std::string::npos; });
}

Ended Process::wait()
{
  reap(0);
  return {WIFEXITED(status_) ? WEXITSTATUS(status_) : -1, read_bytes(out_), read_bytes(err_), peak_kb_,
          processor_s_};
}

Ended run(const Command& command)
{
  return Process(command).wait();
}

}  // namespace vrda::test
