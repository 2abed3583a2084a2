#include "run/solve_part.hpp"

#include <algorithm>

#include "assemble/case_solver.hpp"
#include "run/solved_model.hpp"
#include "run/trace_log.hpp"
#include "talk/interrupt.hpp"
#include "talk/progress.hpp"

namespace vrda {
namespace {

// Two chains and the restarts; what neighbours hand on comes to that.
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
  say("interrupted: what is solved stands in " + log.path + "; the same command goes on from there");
  return ExitCode::interrupted;
}

}  // namespace vrda
