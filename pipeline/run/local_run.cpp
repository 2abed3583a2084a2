#include "run/local_run.hpp"

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
#include <map>
#include <string_view>
#include <thread>

#include "core/files.hpp"
#include "core/text.hpp"
#include "run/status.hpp"

extern "C" char** environ;

namespace vrda::run {
namespace {

constexpr int code_interrupted = 4;

int worse_of(int a, int b)
{
  const auto rank = [](int code) { return code == 0 ? 0 : code == 3 ? 1 : code == 5 ? 3 : 2; };
  return rank(b) > rank(a) ? b : a;
}

struct LocalJob {
  const PlannedJob* job = nullptr;
  std::vector<TaskId> tasks;
  std::size_t n_started = 0;
  std::size_t n_ended = 0;
  bool is_successful = true;

  bool has_ended() const { return n_ended == tasks.size(); }
};

class LocalRun {
 public:
  LocalRun(const std::string& folder, const Submission& submission, const std::vector<PlannedJob>& jobs,
           const LocalOptions& options)
      : folder_(folder), submission_(submission), options_(options)
  {
    for (const PlannedJob& job : jobs) jobs_.push_back({&job, tasks_of(submission, job)});
  }

  LocalOutcome run()
  {
    try {
      while (true) {
        if (!is_stopping_ && options_.is_stop_requested && options_.is_stop_requested()) terminate_children();
        if (!is_stopping_) start_ready();
        if (running_.empty()) break;
        handle_exit(poll_children(pids()));
      }
    } catch (...) {
      terminate_children();
      while (!running_.empty()) running_.erase(poll_children(pids()).pid);
      throw;
    }
    outcome_.is_interrupted = is_stopping_ || outcome_.is_interrupted;
    return outcome_;
  }

 private:
  struct Running {
    LocalJob* job;
    TaskId task;
  };

  std::vector<pid_t> pids() const
  {
    std::vector<pid_t> all;
    for (const auto& [pid, running] : running_) all.push_back(pid);
    return all;
  }

  void terminate_children()
  {
    is_stopping_ = true;
    for (const auto& [pid, running] : running_) kill(pid, SIGTERM);
  }

  // In the order of the list, since later jobs depend on earlier ones.
  void start_ready()
  {
    while (n_ended_ < jobs_.size() && jobs_[n_ended_].has_ended()) ++n_ended_;
    for (std::size_t k = n_ended_; k < jobs_.size(); ++k) {
      LocalJob& job = jobs_[k];
      const auto all_dependencies = [&](const auto& condition) {
        return std::all_of(job.job->after.begin(), job.job->after.end(),
                           [&](std::size_t b) { return condition(jobs_[b]); });
      };
      if (job.n_started == job.tasks.size() ||
          !all_dependencies([](const LocalJob& b) { return b.has_ended(); }))
        continue;
      if (job.job->kind != TaskKind::index &&
          !all_dependencies([](const LocalJob& b) { return b.is_successful; })) {
        job.n_started = job.n_ended = job.tasks.size();
        job.is_successful = false;
        outcome_.n_skipped += static_cast<int>(job.tasks.size());
        continue;
      }
      while (job.n_started < job.tasks.size()) {
        if (running_.size() >= static_cast<std::size_t>(options_.n_workers)) return;
        start(job, job.tasks[job.n_started++]);
      }
    }
  }

  void start(LocalJob& job, const TaskId& task)
  {
    std::vector<std::string> words{submission_.program,
                                   "task",
                                   folder_,
                                   "--kind",
                                   name_of(task.kind),
                                   "--cpus",
                                   std::to_string(options_.n_cpus)};
    if (task.case_number >= 0) {
      // By number, since a name may look like an option.
      words.insert(words.end(), {"--first", std::to_string(task.case_number + 1)});
    }
    if (task.kind == TaskKind::shard) words.insert(words.end(), {"--shard", std::to_string(task.shard)});
    running_.insert({start_program(words, log_of(task)), {&job, task}});
  }

  std::string log_of(const TaskId& task) const
  {
    return logs_of(folder_) + "/" + file_stem_of(task, submission_) + ".log";
  }

  void handle_exit(const ChildExit& ending)
  {
    const auto found = running_.find(ending.pid);
    if (found == running_.end()) return;
    const auto [job, task] = found->second;
    running_.erase(found);
    const bool is_successful = ending.exit_code == 0 || ending.exit_code == 3;
    ++job->n_ended;
    job->is_successful = job->is_successful && is_successful;
    if (ending.exit_code == code_interrupted) {
      outcome_.is_interrupted = true;
      return;
    }
    is_successful ? ++outcome_.n_done : ++outcome_.n_failed;
    outcome_.worst_code = worse_of(outcome_.worst_code, ending.exit_code >= 0 ? ending.exit_code : 2);
    const std::string reason = reason_of(task, ending);
    if (!options_.report) return;
    options_.report(full_text_of(task, submission_) + (is_successful ? ": done" : ": failed") +
                    (reason.empty() ? "" : ": ") + reason);
  }

  // Records the reason for a task that could not write its final state, e.g. after SIGKILL.
  std::string reason_of(const TaskId& task, const ChildExit& ending) const
  {
    std::optional<TaskState> state = read_task_state(folder_, submission_, task);
    if (state && state->phase != TaskPhase::running) return state->reason;
    if (!state) {
      state = started_now(0);
      state->slurm_job.clear();  // would be the Slurm job of this process
      state->n_restarts = 0;
    }
    state->phase = TaskPhase::failed;
    state->ended = utc_now();
    state->exit_code = ending.exit_code;
    state->reason = ending.signal != 0 ? "ended by signal " + std::to_string(ending.signal)
                                       : "could not start; see " + log_of(task);
    write_task_state(folder_, submission_, task, *state);
    return state->reason;
  }

  const std::string& folder_;
  const Submission& submission_;
  const LocalOptions& options_;
  std::vector<LocalJob> jobs_;
  std::size_t n_ended_ = 0;  // number of leading jobs that have ended
  std::map<pid_t, Running> running_;
  bool is_stopping_ = false;
  LocalOutcome outcome_;
};

}  // namespace

LocalOutcome run_locally(const std::string& folder, const Submission& submission,
                         const std::vector<PlannedJob>& jobs, const LocalOptions& options)
{
  return LocalRun(folder, submission, jobs, options).run();
}

OpenFile locked_submission(const std::string& folder)
{
  const std::string path = folder + "/submission.lock";
  OpenFile file(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (!file.is_open()) {
    throw InputError({path, "", std::string("a lock that cannot be taken (") + std::strerror(errno) + ")",
                      "a folder that can be written"});
  }
  if (try_lock_file(file.get(), path)) return file;
  throw InputError({folder, "", "a submission that another vrda submit or resume is working on",
                    "the end of that process"});
}

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
