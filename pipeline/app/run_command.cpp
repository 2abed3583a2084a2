#include "app/run_command.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>

#include "app/assemble.hpp"
#include "app/assemble_trace.hpp"
#include "app/case_solver.hpp"
#include "app/interrupt.hpp"
#include "app/prepare.hpp"
#include "app/progress.hpp"
#include "app/run_record.hpp"
#include "app/scaling_text.hpp"
#include "app/solved_model.hpp"
#include "app/summary.hpp"
#include "app/trace_log.hpp"
#include "audit/recontact.hpp"
#include "core/error.hpp"
#include "journal/journal.hpp"
#include "reduce/reduce.hpp"
#include "smooth/smooth.hpp"
#include "store/motion_model_file.hpp"
#include "store/trace_file.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;

// Steps solved in earlier runs, and the journals the others go to.
struct Log {
  JournalWriter writer;
  std::map<StepKey, StepRecord> known;
  std::optional<FrameWriter> traces;
};

// Every file of a run stands beside its output.
std::string journal_of(const std::string& output)
{
  return output + ".journal";
}
std::string trace_journal_of(const std::string& output)
{
  return output + ".trace.journal";
}

std::string output_of(const RunOptions& options)
{
  if (!options.output.empty()) return options.output;
  const std::string name = fs::path(options.job_file).stem().string();
  return (fs::path("results") / name / (name + ".h5")).string();
}

void make_folder_of(const std::string& file)
{
  const fs::path folder = fs::path(file).parent_path();
  if (folder.empty()) return;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw InputError({file, "folder", error.message(), "a folder that can be written"});
}

// What stands where the model or its trace will go must be one itself: never a job, a mesh or a folder.
void require_replaceable(const std::string& output, const std::string& what)
{
  if (!fs::exists(output)) return;
  const std::string wanted = "a new name, or " + what + " to replace";
  if (!fs::is_regular_file(output)) throw InputError({output, "output", "something that is no file", wanted});
  std::array<char, 8> head{};
  std::ifstream(output, std::ios::binary).read(head.data(), head.size());
  constexpr std::array<char, 8> hdf5{'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
  if (head != hdf5) throw InputError({output, "output", "a file that is not HDF5", wanted});
  if (access(output.c_str(), W_OK) != 0)
    throw InputError({output, "output", "a file without write permission", wanted});
}

// Only the search moves step by step, and a trace knows one Delta.
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

Log open_log(const std::string& path, const std::string& key, bool is_fresh)
{
  if (is_fresh || !fs::exists(path)) return {JournalWriter::create(path, key), {}, {}};
  const JournalContent content = read_journal(path);
  require_key(content.key, path, key);
  if (!content.dropped_why.empty()) {
    warn(path + ": dropped " + std::to_string(content.dropped_bytes) + " bytes at the end (" +
         content.dropped_why + "); those steps are solved again");
  }
  std::map<StepKey, StepRecord> known;
  for (const StepRecord& r : content.records) known.emplace(r.key, r);
  say("resuming: " + std::to_string(known.size()) + " steps found in " + path);
  return {JournalWriter::resume(path, content), std::move(known), {}};
}

bool is_cell(const StepKey& key)
{
  return key.kind == StepKind::spine || key.kind == StepKind::row;
}

int n_cells_known(const Log& log)
{
  return static_cast<int>(std::count_if(log.known.begin(), log.known.end(),
                                        [](const auto& entry) { return is_cell(entry.first); }));
}

SweepResult solve_all(const Case& job_case, const RunOptions& options, Log& log)
{
  CaseSolver solver(job_case, threads_or_all(options.n_threads));
  const SweepPlan plan = plan_of(job_case);
  const auto n_cells = static_cast<int>(plan.flexion_rad.size() * plan.varus_rad.size());
  Progress progress(progress_style_of(options.progress), n_cells, n_cells_known(log));

  const SolveStep solve = [&](const StepTask& task) {
    if (!log.traces) return solver(task);
    return followed(*log.traces, task.key, task.seed,
                    [&](const Watch& watch) { return solver(task, watch); });
  };
  SweepHooks hooks;
  hooks.recall = [&](const StepKey& key) -> std::optional<StepRecord> {
    const auto found = log.known.find(key);
    return found == log.known.end() ? std::nullopt : std::optional(found->second);
  };
  hooks.keep = [&](const StepRecord& record) {
    log.writer.append(record);
    if (is_cell(record.key)) progress.advance();
  };
  hooks.is_stopped = is_interrupted;
  return sweep(plan, solve, hooks, threads_or_all(options.n_threads));
}

void add_smoothed(MotionModel& model, const Case& job_case, const std::string& output, int n_threads)
{
  const SmoothInput input = smooth_input(model, output);
  const int largest = largest_degree(input);
  for (const std::int32_t degree : job_case.smooth_degrees) {
    if (degree > largest) {
      warn("smooth.degrees: found " + std::to_string(degree) + ", wanted " +
           std::to_string(std::max(largest, 0)) +
           " at most on this grid with these solved cells; that degree is left out");
      continue;
    }
    SmoothedSet set = smooth(input, degree, {job_case.smooth_robust});
    if (job_case.smooth_recontact) set.recontact_mm = recontact(model, set, n_threads);
    model = with_smoothed(std::move(model), std::move(set));
  }
}

// Of the raw poses. A joint or a result that has no such motion goes without.
void add_zero_varus(MotionModel& model)
{
  if (!is_reducible(model)) return;
  ZeroVarus zero_varus = reduce(model, "raw");
  if (n_reduced(zero_varus) > 0) model.zero_varus = std::move(zero_varus);
}

// The traces are read back: a run keeps none of them in memory.
void write_trace_of(const Case& job_case, const SweepResult& result, const std::string& output)
{
  const TraceJournalContent content = read_trace_journal(trace_journal_of(output));
  check(content.facts.dropped_why.empty(), "a journal of traces just written is whole");
  const std::string path = trace_name(output);
  write_trace(path, trace_of(job_case, fingerprint_of(job_case), content.searches, result.spine_column));
  say("trace of " + std::to_string(content.searches.size()) + " searches: " + path);
}

ExitCode finish(const Case& job_case, const MotionModel& model, const std::string& output,
                const RunRecord& record)
{
  write_motion_model(output, model);
  std::error_code ignored;
  fs::remove(journal_of(output), ignored);
  fs::remove(trace_journal_of(output), ignored);
  fs::remove(output + ".start.h5", ignored);
  try {  // last: on a full disk there is room again
    record.write(output + ".run.json");
  } catch (const InputError& error) {
    warn(error.what());  // the model is whole; times and host are not worth failing for
  }
  say(status_line(model));
  const double unsolved = unsolved_fraction(model);
  if (unsolved <= job_case.unsolved_fraction) return ExitCode::done;
  warn(output + ": limits.unsolved_fraction: found " + std::to_string(unsolved) + ", wanted at most " +
       std::to_string(job_case.unsolved_fraction));
  return ExitCode::too_many_unsolved;
}

ExitCode solve_and_write(const Case& job_case, const RunOptions& options, Log& log, const std::string& output)
{
  const RunRecord record(threads_or_all(options.n_threads), static_cast<int>(log.known.size()));
  const SweepResult result = solve_all(job_case, options, log);
  if (log.traces) log.traces->flush();
  log.writer.flush();
  if (!result.is_complete) {
    say("interrupted: what is solved stands in " + journal_of(output) +
        "; the same command goes on from there");
    return ExitCode::interrupted;
  }
  if (log.traces) write_trace_of(job_case, result, output);
  MotionModel model = motion_model_of(job_case, result);
  add_smoothed(model, job_case, output, threads_or_all(options.n_threads));
  add_zero_varus(model);
  const ExitCode code = finish(job_case, model, output, record);
  std::printf("%s\n", output.c_str());
  return code;
}

bool is_in_place(const Log& log)
{
  return log.writer.is_in_place() && (!log.traces || log.traces->is_in_place());
}

// The output's folder was deleted or moved under a run: the journals, which are still open, go back to their
// places.
[[noreturn]] void put_back(const Log& log, const std::string& output)
{
  const std::string found = "a folder that was deleted or moved during the run";
  try {
    if (!log.writer.is_in_place()) log.writer.restore();
    if (log.traces && !log.traces->is_in_place()) log.traces->restore();
  } catch (const InputError& error) {
    throw InputError(
        {output, "folder", found, std::string("it left alone; what was solved is lost: ") + error.what()});
  }
  const std::size_t n = read_journal(journal_of(output)).records.size();
  throw InputError({output, "folder", found,
                    "it left alone; it is there again with the journal of all " + std::to_string(n) +
                        " steps solved, and the same command goes on from them"});
}

}  // namespace

ExitCode run_command(const RunOptions& options)
{
  progress_style_of(options.progress);  // a wrong word before any work
  const Case job_case = load_case(options.job_file, {options.data_directory, options.overrides});
  for (const std::string& line : job_case.warnings) warn(line);
  if (const std::string line = scaling_line(job_case); !line.empty()) say(line);
  if (options.writes_trace) require_traceable(job_case, options.job_file);
  const std::string output = output_of(options);
  const std::string journal = journal_of(output);
  make_folder_of(output);
  require_replaceable(output, "a motion model");
  if (options.writes_trace) require_replaceable(trace_name(output), "a trace");
  const std::string key = fingerprint_of(job_case);
  Log log = open_log(journal, key, options.is_fresh);
  if (options.writes_trace) {
    log.traces.emplace(open_trace_log(trace_journal_of(output), key, journal, log.known));
  }
  // A resumed run has its start file, and a disk that filled up may have no room for a second one.
  const std::string start = output + ".start.h5";
  if (log.known.empty() || !fs::exists(start)) write_motion_model(start, pending_model_of(job_case));
  watch_for_interrupts();

  try {
    return solve_and_write(job_case, options, log, output);
  } catch (const InputError&) {
    if (is_in_place(log)) throw;
  }
  put_back(log, output);
}

}  // namespace vrda
