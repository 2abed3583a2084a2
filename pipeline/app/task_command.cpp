#include "app/cluster_commands.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "cluster/slurm_scripts.hpp"
#include "cluster/status.hpp"
#include "cluster/submission.hpp"
#include "cluster/task_state.hpp"
#include "core/error.hpp"
#include "core/open_file.hpp"
#include "run/merge_command.hpp"
#include "run/run_command.hpp"
#include "talk/talk.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// Slurm may send the warning signal up to a minute early.
constexpr std::int64_t slurm_slack_s = 60;
// A predecessor on a slow or lost node may hold the journal. Slurm ends it eventually, or ends this task at
// its time limit and restarts it. A local task has no such supervisor.
constexpr std::chrono::hours patience_in_slurm{24 * 365};
constexpr std::chrono::seconds patience_here{60};

class Task {
 public:
  Task(const std::string& folder, const Submission& submission, const TaskId& id, int n_cpus)
      : folder_(folder), submission_(submission), id_(id), n_cpus_(n_cpus)
  {
  }

  ExitCode run()
  {
    if (is_in_slurm()) return run_alone();
    const std::optional<OutputLock> lock = locked();
    return lock ? run_alone() : ExitCode::interrupted;
  }

 private:
  ExitCode run_alone()
  {
    if (id_.case_number >= 0 && is_made(folder_, submitted_case())) {
      say(submitted_case().output + " is already complete");
      return ExitCode::done;
    }
    begin();
    try {
      return end(execute());
    } catch (const InputError& error) {
      return fail(ExitCode::bad_input, error.what());
    } catch (const std::exception& error) {
      return fail(ExitCode::our_mistake, std::string("internal error: ") + error.what());
    }
  }

  const SubmittedCase& submitted_case() const { return case_of(submission_, id_); }
  bool is_in_slurm() const { return !state_.slurm_job.empty(); }

  // The lock marks a local task as running (Slurm reports its own tasks). Empty if interrupted.
  std::optional<OutputLock> locked() const
  {
    const std::string file = task_file_of(folder_, submission_, id_);
    std::string holder;
    const Clock::time_point begin = Clock::now();
    const auto on_wait = [&](const std::string& text) {
      holder = text;
      say("waiting for " + holder + ", which runs the same task");
    };
    const auto has_timed_out = [&] { return is_interrupted() || Clock::now() - begin > patience_here; };
    std::optional<OutputLock> lock = OutputLock::take(file, "vrda task", {on_wait, has_timed_out});
    if (lock || is_interrupted()) return lock;
    throw InputError({file, "", "a task that " + holder + " runs", "a task that no process runs"});
  }

  std::int64_t n_done() const { return SolvedCounter(folder_, submission_).count(id_).n_done; }

  std::uintmax_t journal_bytes() const
  {
    std::uintmax_t n_bytes = 0;
    for (const std::string& journal : journals_of(folder_, submission_, id_)) {
      std::error_code error;
      const std::uintmax_t n = fs::file_size(journal, error);
      if (!error) n_bytes += n;
    }
    return n_bytes;
  }

  void begin()
  {
    n_bytes_at_begin_ = journal_bytes();
    state_ = begun_now(n_done());
    write();
  }

  // Slurm may have restarted the task elsewhere after losing this node; the state file then belongs to that
  // task.
  bool has_successor() const
  {
    const std::optional<TaskState> there = read_task_state(folder_, submission_, id_);
    return there && !is_same_start(*there, state_);
  }

  // Called after loading; the rate is measured from here.
  void begin_solving()
  {
    // Creating a journal does not count as progress.
    if (!std::exchange(is_solving_, true)) n_bytes_at_begin_ = journal_bytes();
    is_waiting_ = false;
    if (has_successor()) return;
    state_.reason.clear();
    state_.n_done_at_begin = n_done();
    write();
  }

  // `vrda status` prints the reason.
  void begin_waiting()
  {
    is_waiting_ = true;
    if (has_successor()) return;
    state_.reason = "waiting for another process that writes the journal";
    write();
  }

  void write() { write_task_state(folder_, submission_, id_, state_); }

  ExitCode execute()
  {
    if (id_.kind == TaskKind::index) return write_index_of({folder_, false, n_cpus_}, submission_);
    const CaseSpec& spec = submitted_case().spec;
    const std::string output = output_of(folder_, submitted_case());
    if (id_.kind == TaskKind::merge) {
      MergeOptions merge;
      merge.output = output;
      merge.n_shards = submission_.n_shards;
      merge.job_file = spec.job_file;
      merge.data_directory = spec.data_directory;
      merge.overrides = spec.overrides;
      merge.n_threads = n_cpus_;
      return merge_command(merge);
    }
    RunOptions run;
    run.job_file = spec.job_file;
    run.output = output;
    run.data_directory = spec.data_directory;
    run.overrides = spec.overrides;
    run.n_threads = n_cpus_;
    run.progress = "plain";
    run.only_spine = id_.kind == TaskKind::spine;
    if (id_.kind == TaskKind::shard) run.shard = Shard{id_.shard, submission_.n_shards};
    run.begun = [this] { begin_solving(); };
    run.patience = Patience{is_in_slurm() ? patience_in_slurm : patience_here, [this] { begin_waiting(); }};
    return run_command(run);
  }

  ExitCode end(ExitCode code)
  {
    if (code == ExitCode::interrupted) {
      if (is_fruitless()) {
        const std::string why = is_all_solved() ? "the model was not made" : "no step was solved";
        return fail(
            ExitCode::bad_input,
            InputError({"--time", "", submission_.slurm.time + " in which " + why, "a longer time limit"})
                .what());
      }
      return finish(TaskPhase::interrupted, code, "");
    }
    const bool is_short = code == ExitCode::too_many_unsolved;
    return finish(TaskPhase::done, code, is_short ? "more attitudes are unsolved than the job allows" : "");
  }

  ExitCode fail(ExitCode code, const std::string& reason)
  {
    std::fprintf(stderr, "vrda: %s\n", reason.c_str());
    return finish(TaskPhase::failed, code, reason);
  }

  ExitCode finish(TaskPhase phase, ExitCode code, const std::string& reason)
  {
    state_.phase = phase;
    state_.exit_code = static_cast<std::int32_t>(code);
    state_.reason = reason;
    state_.ended = utc_now();
    try {
      if (!has_successor()) write();
    } catch (const InputError& error) {
      warn(error.what());  // the task's results are still valid
    }
    return code;
  }

  // The remaining work (merging, smoothing) has no journal, so it must fit into one time limit.
  bool is_all_solved() const
  {
    if (id_.kind == TaskKind::merge) return true;
    const SolvedCount solved = SolvedCounter(folder_, submission_).count(id_);
    return solved.n_total > 0 && solved.n_done == solved.n_total;
  }

  // False for a task that was preempted before its time limit or waited for another process: a restart may
  // succeed.
  bool is_fruitless() const
  {
    if (is_waiting_ || !is_in_slurm() || submission_.slurm.time.empty()) return false;
    const std::int64_t limit = seconds_of_time(submission_.slurm.time);
    const std::chrono::seconds least(limit - warning_seconds(limit) - slurm_slack_s);
    return Clock::now() - start_ >= least && journal_bytes() <= n_bytes_at_begin_;
  }

  const std::string& folder_;
  const Submission& submission_;
  const TaskId id_;
  const int n_cpus_;
  const Clock::time_point start_ = Clock::now();
  TaskState state_ = begun_now(0);
  std::uintmax_t n_bytes_at_begin_ = 0;
  bool is_solving_ = false;
  bool is_waiting_ = false;
};

std::vector<TaskId> tasks_asked(const TaskOptions& options, const Submission& submission)
{
  const std::optional<TaskKind> named = task_kind_of(options.kind);
  if (!named) {
    throw InputError(
        {"--kind", "", options.kind.empty() ? "nothing" : options.kind, "spine, shard, merge, run or index"});
  }
  const TaskKind kind = *named;
  if (kind == TaskKind::index) return {{kind, -1, 0}};
  const auto n_cases = static_cast<int>(submission.cases.size());
  const int first = options.case_name.empty() ? options.first - 1 : case_named(submission, options.case_name);
  if (first < 0 || first >= n_cases) {
    throw InputError({"--first", "", std::to_string(options.first), "from 1 to " + std::to_string(n_cases)});
  }
  const bool is_shard = kind == TaskKind::shard;
  if (is_shard && (options.shard < 1 || options.shard > submission.n_shards)) {
    throw InputError(
        {"--shard", "", std::to_string(options.shard), "from 1 to " + std::to_string(submission.n_shards)});
  }
  std::vector<TaskId> tasks;
  const int end = std::min(first + (kind == TaskKind::run ? options.count : 1), n_cases);
  for (int k = first; k < end; ++k) tasks.push_back({kind, k, is_shard ? options.shard : 0});
  return tasks;
}

// Marks the running one of these tasks as ended by a signal.
ExitCode record_ended(const std::string& folder, const Submission& submission,
                      const std::vector<TaskId>& tasks, int ended)
{
  constexpr int signal_base = 128, kill_signal = 9;
  const int signal = ended - signal_base;
  const TaskState own = begun_now(0);
  for (const TaskId& id : tasks) {
    std::optional<TaskState> state = read_task_state(folder, submission, id);
    if (!state || !is_same_start(*state, own) || state->phase != TaskPhase::running) continue;
    state->phase = TaskPhase::failed;
    state->ended = utc_now();
    state->exit_code = ended;
    state->reason = "ended by signal " + std::to_string(signal) +
                    (signal == kill_signal ? " (SIGKILL), possibly out of memory" : "");
    write_task_state(folder, submission, id, *state);
  }
  return ExitCode::done;
}

// The exit code of a case that failed before Slurm restarted this task. It would fail again and use the time
// of the other cases of the task.
std::optional<ExitCode> failure_before_restart(const std::string& folder, const Submission& submission,
                                               const TaskId& id)
{
  const TaskState own = begun_now(0);
  if (own.slurm_job.empty() || own.n_restarts == 0) return std::nullopt;
  const std::optional<TaskState> state = read_task_state(folder, submission, id);
  const bool has_failed = state && state->phase == TaskPhase::failed && state->slurm_job == own.slurm_job &&
                          state->n_restarts < own.n_restarts;
  if (!has_failed) return std::nullopt;
  const bool is_ours = state->exit_code == static_cast<std::int32_t>(ExitCode::our_mistake);
  return is_ours ? ExitCode::our_mistake : ExitCode::bad_input;
}

// The more severe of two: internal error, bad input, too many unsolved, done.
ExitCode worse_of(ExitCode a, ExitCode b)
{
  const auto rank = [](ExitCode code) {
    return code == ExitCode::done ? 0 : code == ExitCode::too_many_unsolved ? 1 : static_cast<int>(code);
  };
  return rank(b) > rank(a) ? b : a;
}

}  // namespace

ExitCode task_command(const TaskOptions& options)
{
  bear_repeated_terms();
  watch_for_interrupts();
  const std::string folder = absolute_folder(options.folder);
  const Submission submission = read_submission(folder);
  const std::vector<TaskId> tasks = tasks_asked(options, submission);
  if (options.ended > 0) return record_ended(folder, submission, tasks, options.ended);
  ExitCode code = ExitCode::done;
  for (const TaskId& id : tasks) {
    if (const auto before = failure_before_restart(folder, submission, id); before && tasks.size() > 1) {
      say(file_stem_of(id, submission) + " failed before this restart; continuing with the other cases");
      code = worse_of(code, *before);
      continue;
    }
    const ExitCode one =
        is_interrupted() ? ExitCode::interrupted : Task(folder, submission, id, options.n_cpus).run();
    if (one == ExitCode::interrupted) return one;
    code = worse_of(code, one);
  }
  return code;
}

}  // namespace vrda
