#include "run/solve_part.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <thread>

#include "assemble/assemble.hpp"
#include "assemble/case_solver.hpp"
#include "cluster/case_spec.hpp"
#include "core/error.hpp"
#include "run/collect.hpp"
#include "run/run_output.hpp"
#include "run/step_log.hpp"
#include "run/summary.hpp"
#include "store/motion_model_file.hpp"
#include "talk/talk.hpp"

namespace vrda {
namespace {

// Two chains and the restarts; starts propagated from neighbours are not known in advance.
int n_known_starts(const SweepPlan& plan)
{
  return 2 + plan.n_restarts;
}

bool is_counted(const StepKey& key, const SweepPlan& plan, Counted counted)
{
  const bool is_spine = key.kind == StepKind::spine;
  if (counted == Counted::cells) return is_spine || key.kind == StepKind::row;
  if (plan.spine != SpineRule::free_varus) return is_spine;
  return key.kind == StepKind::free_spine && key.varus < n_known_starts(plan);
}

int n_counted(const SweepPlan& plan, Counted counted)
{
  const std::size_t n_flexion = plan.flexion_rad.size();
  const std::size_t n_rows = plan.rows ? plan.rows->size() : n_flexion;
  if (counted == Counted::cells) return static_cast<int>(n_rows * plan.varus_rad.size());
  const int n_starts = plan.spine == SpineRule::free_varus ? n_known_starts(plan) : 1;
  return static_cast<int>(n_flexion) * n_starts;
}

bool is_of_plan(const StepKey& key, const SweepPlan& plan)
{
  return !plan.rows || std::find(plan.rows->begin(), plan.rows->end(), key.flexion) != plan.rows->end();
}

int n_counted_of(const std::map<StepKey, StepRecord>& steps, const SweepPlan& plan, Counted counted)
{
  return static_cast<int>(std::count_if(steps.begin(), steps.end(), [&](const auto& step) {
    const bool is_here = counted == Counted::spine || is_of_plan(step.first, plan);
    return is_here && is_counted(step.first, plan, counted);
  }));
}

}  // namespace

SweepResult solve_part(const Case& job_case, const SweepPlan& plan, Counted counted,
                       const RunOptions& options, StepLog& log, const std::map<StepKey, StepRecord>& spine)
{
  const int n_threads = threads_or_all(options.n_threads);
  CaseSolver solver(job_case, n_threads);
  const int n_total = n_counted(plan, counted);
  const int n_known = n_counted_of(log.known, plan, counted) + n_counted_of(spine, plan, counted);
  if (options.begun) options.begun();
  const char* what = counted == Counted::cells ? "attitudes" : "steps of the spine";
  Progress progress(progress_style_of(options.progress), what, n_total, n_known);

  const SolveStep solve = [&](const StepTask& task) {
    if (!log.traces) return solver(task);
    return followed(*log.traces, task.key, task.seed,
                    [&](const Watch& watch) { return solver(task, watch); });
  };
  SweepHooks hooks;
  hooks.recall = [&](const StepKey& key) -> std::optional<StepRecord> {
    const auto found = spine.find(key);
    return found == spine.end() ? recalled(log, key) : std::optional(found->second);
  };
  hooks.keep = [&](const StepRecord& record) {
    log.writer.append(record);
    if (is_counted(record.key, plan, counted)) progress.advance();
  };
  hooks.is_stopped = is_interrupted;
  SweepResult result = sweep(plan, solve, hooks, n_threads);
  if (log.traces) log.traces->flush();
  log.writer.flush();
  return result;
}

ExitCode say_interrupted(const StepLog& log)
{
  say("interrupted: solved steps are in " + log.path + "; run the same command to resume");
  return ExitCode::interrupted;
}

namespace {

// A restarted task may find its predecessor still ending.
constexpr std::chrono::seconds own_journal_timeout{60};
// The task that solves the spine holds its lock until it is complete.
constexpr std::chrono::hours spine_journal_timeout{24 * 365};

using Steps = std::map<StepKey, StepRecord>;

struct ShardedRun {
  Case job_case;
  std::string output;
  std::string key;
};

ShardedRun prepared(const RunOptions& options)
{
  if (options.writes_trace) {
    throw InputError({"--trace", "", "a part of a run", "a complete run, without --spine and --shard"});
  }
  ShardedRun run{announced_case(options.job_file, {options.data_directory, options.overrides}),
                 output_of(options.output, options.job_file), ""};
  make_folder_of(run.output);
  finished_result(run.job_case, run.output, options.may_replace);  // throws for that of another job
  run.key = fingerprint_of(run.job_case);
  watch_for_interrupts();
  return run;
}

SweepPlan plan_of_rows(const Case& job_case, std::vector<std::int32_t> rows)
{
  SweepPlan plan = plan_of(job_case);
  plan.rows = std::move(rows);
  return plan;
}

// The steps in a journal; empty without a file.
Steps steps_in(const std::string& path, const std::string& key)
{
  return access(path.c_str(), F_OK) == 0 ? collect({path}, key).steps : Steps{};
}

bool has_whole_spine(const ShardedRun& run, const Steps& steps)
{
  return missing_steps(plan_of_rows(run.job_case, {}), steps).is_spine_complete;
}

// Called under the lock of the spine's journal, so that only one task writes the shared files.
void write_shared_files(const ShardedRun& run, const RunOptions& options)
{
  write_case_file(case_file_of(run.output),
                  {case_of_job(options.job_file, options.data_directory, options.overrides), ""});
  if (has_start_file(run.output, run.job_case.resolved_job)) return;
  write_motion_model(start_file_of(run.output), pending_model_of(run.job_case));
}

// Empty when interrupted.
std::optional<Steps> solved_spine(const ShardedRun& run, const RunOptions& options, bool is_fresh)
{
  const std::string path = spine_journal_of(run.output);
  Patience patience = options.patience.value_or(Patience{});
  patience.longest = spine_journal_timeout;
  std::optional<StepLog> log = open_log_waiting(path, run.key, is_fresh, patience);
  if (!log) return std::nullopt;
  const bool is_complete = putting_back_lost(*log, run.output, [&] {
    write_shared_files(run, options);
    const SweepPlan plan = plan_of_rows(run.job_case, {});
    return solve_part(run.job_case, plan, Counted::spine, options, *log).is_complete;
  });
  if (is_complete) return steps_in(path, run.key);
  say_interrupted(*log);
  return std::nullopt;
}

ExitCode solve_rows(const ShardedRun& run, const RunOptions& options, const Steps& spine)
{
  const std::string path = shard_journal_of(run.output, *options.shard);
  std::optional<StepLog> log = open_log_waiting(path, run.key, options.is_fresh,
                                                options.patience.value_or(Patience{own_journal_timeout}));
  if (!log && is_interrupted()) return ExitCode::interrupted;
  if (!log) {
    throw InputError({path, "", "a journal that another run is writing", "no other run of the same shard"});
  }
  const auto n_rows = static_cast<std::int32_t>(run.job_case.grid.flexion_deg.size());
  const SweepPlan plan = plan_of_rows(run.job_case, rows_of(*options.shard, n_rows));
  const bool is_complete = putting_back_lost(*log, run.output, [&] {
    return solve_part(run.job_case, plan, Counted::cells, options, *log, spine).is_complete;
  });
  if (!is_complete) return say_interrupted(*log);
  std::printf("%s\n", path.c_str());
  return ExitCode::done;
}

}  // namespace

ExitCode spine_command(const RunOptions& options)
{
  const ShardedRun run = prepared(options);
  const auto spine =
      telling_differences(run.job_case, [&] { return solved_spine(run, options, options.is_fresh); });
  if (!spine) return ExitCode::interrupted;
  std::printf("%s\n", spine_journal_of(run.output).c_str());
  return ExitCode::done;
}

ExitCode shard_command(const RunOptions& options)
{
  const ShardedRun run = prepared(options);
  return telling_differences(run.job_case, [&] {
    std::optional<Steps> spine = steps_in(spine_journal_of(run.output), run.key);
    if (!has_whole_spine(run, *spine)) spine = solved_spine(run, options, false);
    return spine ? solve_rows(run, options, *spine) : ExitCode::interrupted;
  });
}

}  // namespace vrda
