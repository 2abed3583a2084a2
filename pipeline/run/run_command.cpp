#include "run/run_command.hpp"

#include <unistd.h>

#include "assemble/assemble.hpp"
#include "assemble/case_solver.hpp"
#include "core/error.hpp"
#include "journal/trace_journal.hpp"
#include "run/result.hpp"
#include "run/run_output.hpp"
#include "run/solve_part.hpp"
#include "run/step_log.hpp"
#include "run/summary.hpp"
#include "store/motion_model_file.hpp"
#include "store/trace_file.hpp"
#include "talk/talk.hpp"

namespace vrda {
namespace {

// Only the stability search has moves, and a trace has a single Delta.
void require_traceable(const Case& job_case, const std::string& job_file)
{
  if (job_case.method != "stability-search") {
    throw InputError({job_file, "solver.method", "\"" + job_case.method + "\" with --trace",
                      "\"stability-search\", which has moves to trace"});
  }
  for (const Push& push : job_case.push) {
    if (push.delta == job_case.frame.delta) continue;
    throw InputError(
        {job_file, "push.delta", "directions that differ over flexion with --trace", "one direction"});
  }
}

// Reads the traces back from their journal: a run does not keep them in memory.
void write_trace_of(const Case& job_case, const SweepResult& result, const std::string& output)
{
  const TraceJournalContent content = read_trace_journal(trace_journal_of(output));
  check(content.facts.dropped_why.empty(), "the journal of traces is undamaged");
  const std::string path = trace_name(output);
  write_trace(path, trace_of(job_case, fingerprint_of(job_case), content.searches, result.spine_column));
  say("trace of " + std::to_string(content.searches.size()) + " searches: " + path);
}

/// Files to remove when the model is complete. The journal of steps comes first: without its traces it could
/// not be resumed with --trace.
std::vector<std::string> obsolete_files(const StepLog& log, const std::string& output)
{
  return {log.path, trace_journal_of(output), start_file_of(output)};
}

ExitCode solve_and_write(const Case& job_case, const RunOptions& options, StepLog& log,
                         const std::string& output)
{
  const int n_threads = threads_or_all(options.n_threads);
  RunRecord record(n_threads, static_cast<int>(log.known.size()));
  const SweepResult result = solve_part(job_case, plan_of(job_case), Counted::cells, options, log);
  if (!result.is_complete) return say_interrupted(log);
  record.note_solved();
  if (log.traces) write_trace_of(job_case, result, output);
  const std::optional<MotionModel> model = result_of(job_case, result, output, n_threads, is_interrupted);
  if (!model) return say_interrupted(log);
  return write_result(job_case, *model, output, obsolete_files(log, output), record);
}

/// An existing result of this job that includes the requested trace. Throws if it is another job's.
std::optional<MotionModel> finished_before(const Case& job_case, const RunOptions& options,
                                           const std::string& output)
{
  std::optional<MotionModel> model = finished_result(job_case, output, options.may_replace);
  const bool has_trace = !options.writes_trace || access(trace_name(output).c_str(), F_OK) == 0;
  return options.is_fresh || !has_trace ? std::nullopt : std::move(model);
}

// Empty when interrupted.
std::optional<StepLog> opened_log(const RunOptions& options, const std::string& output,
                                  const std::string& key)
{
  const std::string path = journal_of(output);
  if (!options.patience) return open_log(path, key, options.is_fresh);
  std::optional<StepLog> log = open_log_waiting(path, key, options.is_fresh, *options.patience);
  return log || is_interrupted() ? std::move(log) : open_log(path, key, options.is_fresh);
}

ExitCode whole_run(const RunOptions& options)
{
  const Case job_case = announced_case(options.job_file, {options.data_directory, options.overrides});
  if (options.writes_trace) require_traceable(job_case, options.job_file);
  const std::string output = output_of(options.output, options.job_file);
  make_folder_of(output);
  finished_before(job_case, options, output);  // throws for another job's result before anything is written
  if (options.writes_trace) require_replaceable(trace_name(output), "a trace");
  const std::string key = fingerprint_of(job_case);
  std::optional<StepLog> opened =
      telling_differences(job_case, [&] { return opened_log(options, output, key); });
  if (!opened) return ExitCode::interrupted;
  StepLog& log = *opened;
  const std::optional<OutputLock> lock = locked_output(output, "vrda run");
  if (!lock) return ExitCode::interrupted;
  // Checked again under both locks: another run may have written it meanwhile.
  if (const auto model = finished_before(job_case, options, output)) {
    say(output + ": this job is finished; --fresh solves it again");
    return keep_result(job_case, *model, output, obsolete_files(log, output),
                       threads_or_all(options.n_threads));
  }
  if (options.writes_trace) {
    log.traces.emplace(open_trace_log(trace_journal_of(output), key, log.path, log.known));
  }
  // A resumed run keeps its start file: a full disk may have no space for a second one.
  if (log.known.empty() || !has_start_file(output, job_case.resolved_job)) {
    write_motion_model(start_file_of(output), pending_model_of(job_case));
  }
  watch_for_interrupts();
  return putting_back_lost(log, output, [&] { return solve_and_write(job_case, options, log, output); });
}

}  // namespace

ExitCode run_command(const RunOptions& options)
{
  progress_style_of(options.progress);  // throws for an invalid style before any work
  if (options.only_spine) return spine_command(options);
  return options.shard ? shard_command(options) : whole_run(options);
}

}  // namespace vrda
