#include "run/sharded_run.hpp"

#include <unistd.h>

#include <cstdio>
#include <thread>

#include "assemble/assemble.hpp"
#include "assemble/prepare.hpp"
#include "cluster/case_spec.hpp"
#include "core/error.hpp"
#include "run/announced_case.hpp"
#include "run/collect.hpp"
#include "run/existing_result.hpp"
#include "run/run_output.hpp"
#include "run/solve_part.hpp"
#include "run/step_log.hpp"
#include "store/motion_model_file.hpp"
#include "talk/interrupt.hpp"

namespace vrda {
namespace {

// One that is begun again may find its predecessor about to end.
constexpr std::chrono::seconds patience_for_own{60};
// Whoever solves the spine holds its lock for as long as that takes.
constexpr std::chrono::hours patience_for_spine{24 * 365};

using Steps = std::map<StepKey, StepRecord>;

struct ShardedRun {
  Case job_case;
  std::string output;
  std::string key;
};

ShardedRun prepared(const RunOptions& options)
{
  if (options.writes_trace) {
    throw InputError({"--trace", "", "a part of a run", "a whole run, without --spine and --shard"});
  }
  ShardedRun run{announced_case(options.job_file, {options.data_directory, options.overrides}),
                 output_of(options.output, options.job_file), ""};
  make_folder_of(run.output);
  finished_result(run.job_case, run.output, options.may_replace);  // refuses that of another job
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

// The steps in a journal; none where there is no such file.
Steps steps_in(const std::string& path, const std::string& key)
{
  return access(path.c_str(), F_OK) == 0 ? collect({path}, key).steps : Steps{};
}

bool has_whole_spine(const ShardedRun& run, const Steps& steps)
{
  return missing_steps(plan_of_rows(run.job_case, {}), steps).is_spine_complete;
}

// Under the lock of the spine's journal, so that only one task writes what all of them share.
void write_shared_files(const ShardedRun& run, const RunOptions& options)
{
  write_case_file(case_file_of(run.output),
                  {case_of_job(options.job_file, options.data_directory, options.overrides), ""});
  if (has_start_file(run.output, run.job_case.resolved_job)) return;
  write_motion_model(start_file_of(run.output), pending_model_of(run.job_case));
}

// Nothing when interrupted.
std::optional<Steps> solved_spine(const ShardedRun& run, const RunOptions& options, bool is_fresh)
{
  const std::string path = spine_journal_of(run.output);
  Patience patience = options.patience.value_or(Patience{});
  patience.longest = patience_for_spine;
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
                                                options.patience.value_or(Patience{patience_for_own}));
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
