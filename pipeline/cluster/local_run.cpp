#include "cluster/local_run.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <map>

#include "cluster/child.hpp"
#include "cluster/task_state.hpp"
#include "core/error.hpp"
#include "core/open_file.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;

constexpr int code_interrupted = 4;

enum class Stage { waiting, running, well, badly, left_out };

int worse_of(int a, int b)
{
  const auto rank = [](int code) { return code == 0 ? 0 : code == 3 ? 1 : code == 5 ? 3 : 2; };
  return rank(b) > rank(a) ? b : a;
}

class LocalRun {
 public:
  LocalRun(const std::string& folder, const Submission& submission, const std::vector<PlannedTask>& tasks,
           const LocalOptions& options)
      : folder_(folder),
        submission_(submission),
        tasks_(tasks),
        options_(options),
        stages_(tasks.size(), Stage::waiting)
  {
  }

  LocalOutcome run()
  {
    try {
      while (true) {
        if (!is_told_ && options_.is_stopped && options_.is_stopped()) tell_to_end();
        if (!is_told_) start_ready();
        if (running_.empty()) break;
        take(wait_a_moment(pids()));
      }
    } catch (...) {
      tell_to_end();
      while (!running_.empty()) running_.erase(wait_a_moment(pids()).pid);
      throw;
    }
    outcome_.n_left_out = static_cast<int>(std::count(stages_.begin(), stages_.end(), Stage::left_out));
    outcome_.is_interrupted = is_told_ || outcome_.is_interrupted;
    return outcome_;
  }

 private:
  std::vector<pid_t> pids() const
  {
    std::vector<pid_t> all;
    for (const auto& [pid, task] : running_) all.push_back(pid);
    return all;
  }

  void tell_to_end()
  {
    is_told_ = true;
    for (const auto& [pid, task] : running_) kill(pid, SIGTERM);
  }

  // In the order of the list: what comes first frees what waits for it.
  void start_ready()
  {
    bool is_changed = true;
    while (is_changed) {
      is_changed = false;
      for (std::size_t k = first_; k < tasks_.size(); ++k) {
        if (running_.size() >= static_cast<std::size_t>(options_.n_workers)) return;
        if (stages_[k] != Stage::waiting) {
          if (k == first_ && stages_[k] != Stage::running) ++first_;
          continue;
        }
        is_changed = consider(k) || is_changed;
      }
    }
  }

  // Whether the stage of the task is another one now.
  bool consider(std::size_t k)
  {
    const PlannedTask& task = tasks_[k];
    const auto has = [&](Stage stage) {
      return std::any_of(task.after.begin(), task.after.end(),
                         [&](std::size_t before) { return stages_[before] == stage; });
    };
    if (has(Stage::waiting) || has(Stage::running)) return false;
    if (!task.is_after_any && (has(Stage::badly) || has(Stage::left_out))) {
      stages_[k] = Stage::left_out;
      return true;
    }
    running_[start_program(words_of(task.task), log_of(task.task))] = k;
    stages_[k] = Stage::running;
    return true;
  }

  std::vector<std::string> words_of(const TaskId& task) const
  {
    std::vector<std::string> words{submission_.program,
                                   "task",
                                   folder_,
                                   "--kind",
                                   name_of(task.kind),
                                   "--cpus",
                                   std::to_string(options_.n_cpus)};
    if (task.case_number >= 0) {
      // By number: a name may look like an option.
      words.insert(words.end(), {"--first", std::to_string(task.case_number + 1)});
    }
    if (task.kind == TaskKind::shard) words.insert(words.end(), {"--shard", std::to_string(task.shard)});
    return words;
  }

  std::string log_of(const TaskId& task) const
  {
    return (fs::path(logs_of(folder_)) / (file_stem_of(task, submission_) + ".log")).string();
  }

  void take(const Ending& ending)
  {
    const auto found = running_.find(ending.pid);
    if (found == running_.end()) return;
    const std::size_t k = found->second;
    running_.erase(found);
    const bool is_well = ending.exit_code == 0 || ending.exit_code == 3;
    stages_[k] = is_well ? Stage::well : Stage::badly;
    if (ending.exit_code == code_interrupted) {
      outcome_.is_interrupted = true;
      return;
    }
    is_well ? ++outcome_.n_done : ++outcome_.n_failed;
    const int code = ending.exit_code >= 0 ? ending.exit_code : 2;
    outcome_.worst_code = worse_of(outcome_.worst_code, code);
    const TaskId& task = tasks_[k].task;
    const std::string reason = reason_of(task, ending);
    if (options_.tell)
      options_.tell(line_of(task) + (is_well ? "done" : "failed") + (reason.empty() ? "" : ": ") + reason);
  }

  std::string line_of(const TaskId& task) const
  {
    const bool has_name = submission_.has_index() && task.case_number >= 0;
    const std::string name =
        has_name ? submission_.cases[static_cast<std::size_t>(task.case_number)].spec.name + " " : "";
    return name + text_of(task, submission_) + ": ";
  }

  // A task that was killed could not say so itself.
  std::string reason_of(const TaskId& task, const Ending& ending) const
  {
    std::optional<TaskState> state = read_task_state(folder_, submission_, task);
    if (state && state->phase != TaskPhase::running) return state->reason;
    const std::string reason = ending.signal != 0 ? "ended by signal " + std::to_string(ending.signal)
                                                  : "could not begin; see " + log_of(task);
    if (!state) {
      state = begun_now(0);
      state->slurm_job.clear();  // of this process, if any
      state->n_restarts = 0;
    }
    state->phase = TaskPhase::failed;
    state->ended = utc_text(std::chrono::system_clock::now());
    state->exit_code = ending.exit_code;
    state->reason = reason;
    write_task_state(folder_, submission_, task, *state);
    return reason;
  }

  const std::string& folder_;
  const Submission& submission_;
  const std::vector<PlannedTask>& tasks_;
  const LocalOptions& options_;
  std::vector<Stage> stages_;
  std::size_t first_ = 0;  // all before it have ended
  std::map<pid_t, std::size_t> running_;
  bool is_told_ = false;
  LocalOutcome outcome_;
};

}  // namespace

LocalOutcome run_local(const std::string& folder, const Submission& submission,
                       const std::vector<PlannedTask>& tasks, const LocalOptions& options)
{
  return LocalRun(folder, submission, tasks, options).run();
}

SubmissionLock::SubmissionLock(const std::string& folder)
{
  const std::string path = (fs::path(folder) / "submission.lock").string();
  OpenFile file(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (file.get() < 0) {
    throw InputError({path, "", std::string("a lock that cannot be taken (") + std::strerror(errno) + ")",
                      "a folder that can be written"});
  }
  if (!lock_without_waiting(file.get(), path)) {
    throw InputError({folder, "", "a submission that another vrda submit or resume is working on",
                      "its end, or its interruption"});
  }
  descriptor_ = file.release();
}

SubmissionLock::~SubmissionLock()
{
  close(descriptor_);
}

}  // namespace vrda
