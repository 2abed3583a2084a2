// `vrda task`: one task of a submission, started by its Slurm script or by a local worker.

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>

#include "app/commands.hpp"
#include "core/console.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "run/run_command.hpp"
#include "run/slurm.hpp"
#include "run/status.hpp"

namespace vrda::app {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// `vrda task`: the command that each Slurm task or local process of a submission runs.
struct TaskOptions {
  std::string folder;     ///< of the submission
  std::string kind;       ///< "spine", "shard", "merge", "run" or "index"
  std::string case_name;  ///< empty: use `first`
  int first = 1;          ///< number of the case, from 1
  int count = 1;          ///< number of cases that a `run` task solves in sequence
  int shard = 0;
  int n_cpus = 1;
  /// 128 + the signal that ended the task: record that instead of running the task; 0: run it.
  int recorded_exit_code = 0;
};

// Slurm may send the warning signal up to a minute early.
constexpr std::int64_t slurm_slack_s = 60;
// A predecessor on a slow or lost node may hold the journal. Slurm ends it eventually, or ends this task at
// its time limit and restarts it. A local task has no such supervisor.
constexpr std::chrono::hours patience_in_slurm{24 * 365};
constexpr std::chrono::seconds patience_here{60};

class Task {
 public:
  Task(const std::string& folder, const run::Submission& submission, const run::TaskId& id, int n_cpus)
      : folder_(folder), submission_(submission), id_(id), n_cpus_(n_cpus)
  {
  }

  core::ExitCode run()
  {
    if (is_in_slurm()) return run_alone();
    const std::optional<OutputLock> lock = locked();
    return lock ? run_alone() : core::ExitCode::interrupted;
  }

 private:
  core::ExitCode run_alone()
  {
    if (id_.case_number >= 0 && run::is_case_complete(folder_, submitted_case())) {
      core::log_info(submitted_case().output + " is already complete");
      return core::ExitCode::done;
    }
    begin();
    try {
      return end(execute());
    } catch (const InputError& error) {
      return fail(core::ExitCode::bad_input, error.what());
    } catch (const std::exception& error) {
      return fail(core::ExitCode::internal_error, std::string("internal error: ") + error.what());
    }
  }

  const run::SubmittedCase& submitted_case() const { return run::case_of(submission_, id_); }
  bool is_in_slurm() const { return !state_.slurm_job.empty(); }

  // The lock marks a local task as running (Slurm reports its own tasks). Empty if interrupted.
  std::optional<OutputLock> locked() const
  {
    const std::string file = run::task_file_of(folder_, submission_, id_);
    std::string holder;
    const Clock::time_point begin = Clock::now();
    const auto on_wait = [&](const std::string& text) {
      holder = text;
      core::log_info("waiting for " + holder + ", which runs the same task");
    };
    const auto has_timed_out = [&] { return core::is_interrupted() || Clock::now() - begin > patience_here; };
    std::optional<OutputLock> lock = OutputLock::acquire(file, "vrda task", {on_wait, has_timed_out});
    if (lock || core::is_interrupted()) return lock;
    throw InputError({file, "", "a task that " + holder + " runs", "a task that no process runs"});
  }

  std::int64_t n_done() const { return run::SolvedCounter(folder_, submission_).count(id_).n_done; }

  std::uintmax_t journal_bytes() const
  {
    std::uintmax_t n_bytes = 0;
    for (const std::string& journal : run::journals_of(folder_, submission_, id_)) {
      std::error_code error;
      const std::uintmax_t n = fs::file_size(journal, error);
      if (!error) n_bytes += n;
    }
    return n_bytes;
  }

  void begin()
  {
    n_bytes_at_begin_ = journal_bytes();
    state_ = run::started_now(n_done());
    write();
  }

  // Slurm may have restarted the task elsewhere after losing this node; the state file then belongs to that
  // task.
  bool has_successor() const
  {
    const std::optional<run::TaskState> there = run::read_task_state(folder_, submission_, id_);
    return there && !run::is_same_start(*there, state_);
  }

  // Called after loading; the rate is measured from here.
  void begin_solving()
  {
    // Creating a journal does not count as progress.
    if (!std::exchange(is_solving_, true)) n_bytes_at_begin_ = journal_bytes();
    is_waiting_ = false;
    if (has_successor()) return;
    state_.reason.clear();
    state_.n_done_at_start = n_done();
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

  void write() { run::write_task_state(folder_, submission_, id_, state_); }

  core::ExitCode execute()
  {
    if (id_.kind == run::TaskKind::index)
      return write_submission_index({folder_, false, n_cpus_}, submission_);
    const run::CaseSpec& spec = submitted_case().spec;
    const std::string output = run::output_of(folder_, submitted_case());
    if (id_.kind == run::TaskKind::merge) {
      run::MergeOptions merge;
      static_cast<job::JobSource&>(merge) = spec.source();
      merge.output = output;
      merge.n_shards = submission_.n_shards;
      merge.n_threads = n_cpus_;
      return run::merge_command(merge);
    }
    run::RunOptions run;
    static_cast<job::JobSource&>(run) = spec.source();
    run.output = output;
    run.n_threads = n_cpus_;
    run.progress = "plain";
    run.only_spine = id_.kind == run::TaskKind::spine;
    if (id_.kind == run::TaskKind::shard) run.shard = store::Shard{id_.shard, submission_.n_shards};
    run.on_solving_start = [this] { begin_solving(); };
    run.journal_wait =
        run::JournalWait{is_in_slurm() ? patience_in_slurm : patience_here, [this] { begin_waiting(); }};
    return run::run_command(run);
  }

  core::ExitCode end(core::ExitCode code)
  {
    if (code == core::ExitCode::interrupted) {
      if (is_fruitless()) {
        const std::string why = is_all_solved() ? "the model was not made" : "no step was solved";
        return fail(
            core::ExitCode::bad_input,
            InputError({"--time", "", submission_.slurm.time + " in which " + why, "a longer time limit"})
                .what());
      }
      return finish(run::TaskStatus::interrupted, code, "");
    }
    const bool is_short = code == core::ExitCode::incomplete;
    return finish(run::TaskStatus::done, code,
                  is_short ? "more attitudes are unsolved than the job allows" : "");
  }

  core::ExitCode fail(core::ExitCode code, const std::string& reason)
  {
    std::fprintf(stderr, "vrda: %s\n", reason.c_str());
    return finish(run::TaskStatus::failed, code, reason);
  }

  core::ExitCode finish(run::TaskStatus phase, core::ExitCode code, const std::string& reason)
  {
    state_.status = phase;
    state_.exit_code = static_cast<std::int32_t>(code);
    state_.reason = reason;
    state_.ended = run::utc_now();
    try {
      if (!has_successor()) write();
    } catch (const InputError& error) {
      core::log_warning(error.what());  // the task's results are still valid
    }
    return code;
  }

  // The remaining work (merging, smoothing) has no journal, so it must fit into one time limit.
  bool is_all_solved() const
  {
    if (id_.kind == run::TaskKind::merge) return true;
    const run::SolvedCount solved = run::SolvedCounter(folder_, submission_).count(id_);
    return solved.n_total > 0 && solved.n_done == solved.n_total;
  }

  // False for a task that was preempted before its time limit or waited for another process: a restart may
  // succeed.
  bool is_fruitless() const
  {
    if (is_waiting_ || !is_in_slurm() || submission_.slurm.time.empty()) return false;
    const std::int64_t limit = run::seconds_of_time(submission_.slurm.time);
    const std::chrono::seconds least(limit - run::warning_seconds(limit) - slurm_slack_s);
    return Clock::now() - start_ >= least && journal_bytes() <= n_bytes_at_begin_;
  }

  const std::string& folder_;
  const run::Submission& submission_;
  const run::TaskId id_;
  const int n_cpus_;
  const Clock::time_point start_ = Clock::now();
  run::TaskState state_ = run::started_now(0);
  std::uintmax_t n_bytes_at_begin_ = 0;
  bool is_solving_ = false;
  bool is_waiting_ = false;
};

std::vector<run::TaskId> requested_tasks(const TaskOptions& options, const run::Submission& submission)
{
  const std::optional<run::TaskKind> named = core::value_named<run::TaskKind>(options.kind);
  if (!named) {
    throw InputError(
        {"--kind", "", options.kind.empty() ? "nothing" : options.kind, "spine, shard, merge, run or index"});
  }
  const run::TaskKind kind = *named;
  if (kind == run::TaskKind::index) return {{kind, -1, 0}};
  const auto n_cases = static_cast<int>(submission.cases.size());
  const int first =
      options.case_name.empty() ? options.first - 1 : run::case_named(submission, options.case_name);
  if (first < 0 || first >= n_cases) {
    throw InputError({"--first", "", std::to_string(options.first), "from 1 to " + std::to_string(n_cases)});
  }
  const bool is_shard = kind == run::TaskKind::shard;
  if (is_shard && (options.shard < 1 || options.shard > submission.n_shards)) {
    throw InputError(
        {"--shard", "", std::to_string(options.shard), "from 1 to " + std::to_string(submission.n_shards)});
  }
  std::vector<run::TaskId> tasks;
  const int end = std::min(first + (kind == run::TaskKind::run ? options.count : 1), n_cases);
  for (int k = first; k < end; ++k) tasks.push_back({kind, k, is_shard ? options.shard : 0});
  return tasks;
}

// Marks the running one of these tasks as ended by a signal.
core::ExitCode record_ended(const std::string& folder, const run::Submission& submission,
                            const std::vector<run::TaskId>& tasks, int ended)
{
  constexpr int signal_base = 128, kill_signal = 9;
  const int signal = ended - signal_base;
  const run::TaskState own = run::started_now(0);
  for (const run::TaskId& id : tasks) {
    std::optional<run::TaskState> state = run::read_task_state(folder, submission, id);
    if (!state || !run::is_same_start(*state, own) || state->status != run::TaskStatus::running) continue;
    state->status = run::TaskStatus::failed;
    state->ended = run::utc_now();
    state->exit_code = ended;
    state->reason = "ended by signal " + std::to_string(signal) +
                    (signal == kill_signal ? " (SIGKILL), possibly out of memory" : "");
    run::write_task_state(folder, submission, id, *state);
  }
  return core::ExitCode::done;
}

// The exit code of a case that failed before Slurm restarted this task. It would fail again and use the time
// of the other cases of the task.
std::optional<core::ExitCode> failure_before_restart(const std::string& folder,
                                                     const run::Submission& submission, const run::TaskId& id)
{
  const run::TaskState own = run::started_now(0);
  if (own.slurm_job.empty() || own.n_restarts == 0) return std::nullopt;
  const std::optional<run::TaskState> state = run::read_task_state(folder, submission, id);
  const bool has_failed = state && state->status == run::TaskStatus::failed &&
                          state->slurm_job == own.slurm_job && state->n_restarts < own.n_restarts;
  if (!has_failed) return std::nullopt;
  const bool is_internal = state->exit_code == static_cast<std::int32_t>(core::ExitCode::internal_error);
  return is_internal ? core::ExitCode::internal_error : core::ExitCode::bad_input;
}

// The more severe of two: internal error, bad input, incomplete, done.
core::ExitCode worse_of(core::ExitCode a, core::ExitCode b)
{
  const auto rank = [](core::ExitCode code) {
    return code == core::ExitCode::done ? 0 : code == core::ExitCode::incomplete ? 1 : static_cast<int>(code);
  };
  return rank(b) > rank(a) ? b : a;
}

// Runs the requested tasks in this process and writes the state of each before and after. Skips a task whose
// case is finished. Returns the worst exit code; an interruption ends the list. An interruption at the time
// limit without a solved step is a failure, since a restart would end the same way.
core::ExitCode task_command(const TaskOptions& options)
{
  core::ignore_repeated_sigterm();
  core::install_signal_handlers();
  const std::string folder = run::absolute_folder(options.folder);
  const run::Submission submission = run::read_submission(folder);
  if (submission.permits_missing_locks) permit_missing_locks(core::log_warning);
  const std::vector<run::TaskId> tasks = requested_tasks(options, submission);
  if (options.recorded_exit_code > 0)
    return record_ended(folder, submission, tasks, options.recorded_exit_code);
  core::ExitCode code = core::ExitCode::done;
  for (const run::TaskId& id : tasks) {
    if (const auto before = failure_before_restart(folder, submission, id); before && tasks.size() > 1) {
      core::log_info(run::file_stem_of(id, submission) +
                     " failed before this restart; continuing with the other cases");
      code = worse_of(code, *before);
      continue;
    }
    const core::ExitCode one = core::is_interrupted() ? core::ExitCode::interrupted
                                                      : Task(folder, submission, id, options.n_cpus).run();
    if (one == core::ExitCode::interrupted) return one;
    code = worse_of(code, one);
  }
  return code;
}

}  // namespace

void declare_task(Command& c)
{
  auto& o = c.options<TaskOptions>();
  c.option("folder", o.folder, "Folder of the submission").required();
  c.option("--kind", o.kind, "spine, shard, merge, run or index").required();
  const Option name = c.option("--case", o.case_name, "Name of the case");
  c.option("--first", o.first, "Number of the case, from 1").excludes(name);
  c.option("--count", o.count, "Cases to run in sequence").whole_number(1, most_tasks);
  c.option("--shard", o.shard, "Number of the shard, from 1");
  c.option("--cpus", o.n_cpus, "Threads").whole_number(1, 1024);
  c.option("--ended", o.recorded_exit_code,
           "Only record that a signal ended the task, with this exit code of its script")
      .whole_number(129, 255);
  c.runs([&o] { return task_command(o); });
}

}  // namespace vrda::app
