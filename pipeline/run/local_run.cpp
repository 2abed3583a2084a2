#include "run/local_run.hpp"

#include <fcntl.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <map>
#include <string_view>

#include "core/process.hpp"
#include "core/text.hpp"
#include "run/status.hpp"

namespace vrda::run {
namespace {

constexpr int code_interrupted = 4;

int worse_of(int a, int b)
{
  const auto rank = [](int code) { return code == 0 ? 0 : code == 3 ? 1 : code == 5 ? 3 : 2; };
  return rank(b) > rank(a) ? b : a;
}

bool is_not_slurms(std::string_view entry)
{
  return !entry.starts_with("SLURM");
}

/// A process with both outputs appended to the file `log`. It is not a Slurm task, even within one.
pid_t started(const std::vector<std::string>& words, const std::string& log)
{
  const auto refuse = [](const std::string& file, const char* what, int error) {
    throw InputError({file, "", std::string(what) + ": " + std::strerror(error),
                      "resources for another process and its files"});
  };
  const OpenFile file(open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  if (!file.is_open()) refuse(log, "an error on opening the log", errno);
  const StartedProcess process = start_process(
      words,
      {.out = file.get(), .err = file.get(), .folder = "", .is_inherited = is_not_slurms, .is_tied = true});
  if (process.pid < 0) refuse(words.front(), "an error on creating the process", process.error);
  return process.pid;
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
        handle_exit(poll_processes(pids()));
      }
    } catch (...) {
      terminate_children();
      while (!running_.empty()) running_.erase(poll_processes(pids()).pid);
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
    running_.insert({started(words, log_of(task)), {&job, task}});
  }

  std::string log_of(const TaskId& task) const
  {
    return logs_of(folder_) + "/" + file_stem_of(task, submission_) + ".log";
  }

  void handle_exit(const ProcessEnd& ending)
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
  std::string reason_of(const TaskId& task, const ProcessEnd& ending) const
  {
    std::optional<TaskState> state = read_task_state(folder_, submission_, task);
    if (state && state->status != TaskStatus::running) return state->reason;
    if (!state) {
      state = started_now(0);
      state->slurm_job.clear();  // would be the Slurm job of this process
      state->n_restarts = 0;
    }
    state->status = TaskStatus::failed;
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

}  // namespace vrda::run
