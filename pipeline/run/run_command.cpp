#include "run/run_command.hpp"

#include <unistd.h>

#include <cstdio>

#include "core/console.hpp"
#include "core/error.hpp"
#include "run/result.hpp"
#include "run/run_output.hpp"
#include "run/solve_part.hpp"
#include "run/solve_samples.hpp"
#include "run/step_log.hpp"
#include "run/summary.hpp"
#include "store/trace_journal.hpp"
#include "solve/case_solver.hpp"
#include "solve/model_build.hpp"
#include "store/motion_model_file.hpp"
#include "store/trace_file.hpp"

namespace vrda::run {
namespace {

// A trace has a single Delta and the varus of each cell; a free varus is the best of many starts.
void require_traceable(const job::Case& job_case, const std::string& job_file)
{
  if (job_case.is_varus_free)
    throw InputError({job_file, "grid.varus", "\"free\" with --trace", "values of varus"});
  for (const job::Push& push : job_case.push) {
    if (push.delta == job_case.frame.delta) continue;
    throw InputError(
        {job_file, "push.delta", "directions that differ over flexion with --trace", "one direction"});
  }
}

// Reads the traces back from their journal: a run does not keep them in memory.
void write_trace_of(const job::Case& job_case, const solve::SweepResult& result, const std::string& output)
{
  const store::TraceJournalContent content = store::read_trace_journal(store::trace_journal_of(output));
  check(content.summary.dropped_reason.empty(), "the journal of traces is undamaged");
  const std::string path = store::trace_name(output);
  store::write_trace(path, solve::trace_of(job_case, solve::fingerprint_of(job_case),
                                                 content.searches, result.spine_column));
  core::log_info("trace of " + std::to_string(content.searches.size()) + " searches: " + path);
}

/// Files to remove when the model is complete. The journal of steps comes first: without its traces it could
/// not be resumed with --trace.
std::vector<std::string> obsolete_files(const StepLog& log, const std::string& output)
{
  return {log.path, store::trace_journal_of(output), store::start_file_of(output)};
}

core::ExitCode solve_and_write(const job::Case& job_case, const RunOptions& options, StepLog& log,
                                  const std::string& output)
{
  const int n_threads = thread_count_or_all(options.n_threads);
  RunRecord record(n_threads, static_cast<int>(log.known.size()));
  const solve::SweepPlan plan = solve::plan_of(job_case);
  const solve::SweepResult result = solve_part(job_case, plan, ProgressUnit::cells, options, log);
  if (!result.is_complete) return report_interrupted(log);
  const auto samples = solve_samples(job_case, plan, result, all_samples(job_case), options, log);
  if (!samples) return report_interrupted(log);
  record.end_phase(solving_phase);
  if (log.traces) write_trace_of(job_case, result, output);
  const std::optional<store::MotionModel> model =
      build_result(job_case, result, *samples, output, n_threads, core::is_interrupted, record);
  if (!model) return report_interrupted(log);
  const core::ExitCode code = write_result(job_case, *model, output, obsolete_files(log, output), record);
  if (options.has_profile) record.report_profile();
  return code;
}

/// An existing result of this job that includes the requested trace. Throws if it is another job's.
std::optional<store::MotionModel> finished_before(const job::Case& job_case, const RunOptions& options,
                                                  const std::string& output)
{
  std::optional<store::MotionModel> model = existing_result(job_case, output, options.may_replace);
  const bool has_trace = !options.writes_trace || access(store::trace_name(output).c_str(), F_OK) == 0;
  return options.is_fresh || !has_trace ? std::nullopt : std::move(model);
}

// Empty when interrupted.
std::optional<StepLog> opened_log(const RunOptions& options, const std::string& output,
                                  const std::string& key)
{
  const std::string path = store::journal_of(output);
  if (!options.journal_wait) return open_log(path, key, options.is_fresh);
  std::optional<StepLog> log = open_log_waiting(path, key, options.is_fresh, *options.journal_wait);
  return log || core::is_interrupted() ? std::move(log) : open_log(path, key, options.is_fresh);
}

core::ExitCode whole_run(const RunOptions& options)
{
  const job::Case job_case =
      load_and_report_case(options.job_file, {options.data_directory, options.overrides});
  if (options.writes_trace) require_traceable(job_case, options.job_file);
  const std::string output = output_path_of(options.output, options.job_file);
  make_parent_folder(output);
  finished_before(job_case, options, output);  // throws for another job's result before anything is written
  if (options.writes_trace) require_replaceable(store::trace_name(output), "a trace");
  const std::string key = solve::fingerprint_of(job_case);
  std::optional<StepLog> opened =
      with_difference_in_errors(job_case, [&] { return opened_log(options, output, key); });
  if (!opened) return core::ExitCode::interrupted;
  StepLog& log = *opened;
  const std::optional<OutputLock> lock = lock_output(output, "vrda run");
  if (!lock) return core::ExitCode::interrupted;
  // Checked again under both locks: another run may have written it meanwhile.
  if (const auto model = finished_before(job_case, options, output)) {
    core::log_info(output + ": this job is finished; --fresh solves it again");
    return finish_existing_result(job_case, *model, output, obsolete_files(log, output),
                                  thread_count_or_all(options.n_threads));
  }
  if (options.writes_trace) {
    log.traces.emplace(open_trace_log(store::trace_journal_of(output), key, log.path, log.known));
  }
  // A resumed run keeps its start file: a full disk may have no space for a second one.
  if (log.known.empty() || !has_start_file(output, job_case.resolved_job)) {
    store::write_motion_model(store::start_file_of(output), solve::pending_model_of(job_case));
  }
  if (!options.is_hosted) core::install_signal_handlers();
  return with_journal_restore(log, output, [&] { return solve_and_write(job_case, options, log, output); });
}

}  // namespace

core::ExitCode run_command(const RunOptions& options)
{
  core::progress_style_of(options.progress);  // throws for an invalid style before any work
  if (options.only_spine) return spine_command(options);
  if (options.shard) return shard_command(options);
  const core::ExitCode code = whole_run(options);
  if (code != core::ExitCode::interrupted && !options.is_hosted)
    std::printf("%s\n", output_path_of(options.output, options.job_file).c_str());
  return code;
}

}  // namespace vrda::run
