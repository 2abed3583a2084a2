#include "run/step_log.hpp"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <thread>
#include <utility>

#include "core/console.hpp"
#include "core/error.hpp"
#include "store/journal.hpp"
#include "store/trace_journal.hpp"

namespace vrda::run {
namespace {

StepLog log_of(const std::string& path, store::OpenJournal opened)
{
  const store::JournalContent& content = opened.content;
  if (!content.dropped_reason.empty()) {
    core::log_warning(path + ": dropped " + std::to_string(content.dropped_bytes) + " bytes at the end (" +
                         content.dropped_reason + "); those steps are solved again");
  }
  StepLog log{path, std::move(opened.writer), {}, {}};
  for (const StepRecord& r : content.records) log.known.emplace(r.key, r);
  if (!log.known.empty())
    core::log_info("resuming: " + std::to_string(log.known.size()) + " steps found in " + path);
  return log;
}

bool is_in_place(const StepLog& log)
{
  return log.writer.is_in_place() && (!log.traces || log.traces->is_in_place());
}

}  // namespace

StepLog open_log(const std::string& path, const std::string& key, bool is_fresh)
{
  if (is_fresh) return {path, store::JournalWriter::create(path, key), {}, {}};
  return log_of(path, store::JournalWriter::open(path, key));
}

std::optional<StepLog> open_log_waiting(const std::string& path, const std::string& key, bool is_fresh,
                                        const JournalWait& patience)
{
  if (is_fresh) return open_log(path, key, true);
  constexpr std::chrono::milliseconds pause{100};
  for (std::chrono::milliseconds waited{0};; waited += pause) {
    if (core::is_interrupted()) return std::nullopt;
    if (std::optional<store::OpenJournal> opened = store::JournalWriter::try_open(path, key)) {
      return log_of(path, std::move(*opened));
    }
    if (waited == pause) {
      core::log_info("waiting for the run that writes " + path);
      patience.on_start();
    }
    if (waited >= patience.timeout) return std::nullopt;
    std::this_thread::sleep_for(pause);
  }
}

std::optional<StepRecord> recalled_step(const StepLog& log, const StepKey& key)
{
  const auto found = log.known.find(key);
  return found == log.known.end() ? std::nullopt : std::optional(found->second);
}

void restore_lost_journals(const StepLog& log, const std::string& output)
{
  if (is_in_place(log)) return;
  const std::string found = "a folder that was deleted or moved during the run",
                    wanted = "an unchanged folder";
  try {
    if (!log.writer.is_in_place()) log.writer.restore();
    if (log.traces && !log.traces->is_in_place()) log.traces->restore();
  } catch (const InputError& error) {
    throw InputError({output, "folder", found, wanted + "; the solved steps are lost: " + error.what()});
  }
  const std::size_t n = store::read_journal(log.path).records.size();
  throw InputError({output, "folder", found,
                    wanted + "; it was restored with the journal of all " + std::to_string(n) +
                        " steps solved; run the same command to resume"});
}

namespace {

// The free spine has no cells. A spine cell of the search was solved as a probe, which has the trace.
bool needs_trace(const StepKey& key, const std::map<StepKey, StepRecord>& known)
{
  if (key.kind == StepKind::spine) return !known.contains({StepKind::spine_probe, key.flexion, key.varus});
  return key.kind == StepKind::row || key.kind == StepKind::spine_probe;
}

}  // namespace

core::FrameWriter open_trace_log(const std::string& path, const std::string& key,
                                    const std::string& steps_path, const std::map<StepKey, StepRecord>& known)
{
  if (known.empty()) return store::create_trace_journal(path, key);
  store::TraceJournalContent content;
  if (std::filesystem::exists(path)) {
    content = store::read_trace_journal(path);
    store::require_key(content.summary.key, path, key);
  }
  const auto n_missing = std::count_if(known.begin(), known.end(), [&](const auto& step) {
    return needs_trace(step.first, known) && content.searches.count(step.first) == 0;
  });
  if (n_missing > 0) {
    throw InputError({path, "",
                      "no trace of " + std::to_string(n_missing) + " steps that " + steps_path + " contains",
                      "a run traced from its start; use --fresh to start over, or continue without --trace"});
  }
  if (!content.summary.dropped_reason.empty()) {
    core::log_warning(path + ": dropped " + std::to_string(content.summary.dropped_bytes) +
                         " bytes at the end (" + content.summary.dropped_reason + ")");
  }
  return store::resume_trace_journal(path, content.summary);
}

StepRecord solve_with_trace(core::FrameWriter& log, const StepKey& key, const MovingPose& seed,
                            const std::function<StepRecord(const SearchObserver&)>& solve)
{
  SearchTrace trace;
  trace.key = key;
  trace.seed = seed;
  StepRecord record = solve([&](const SearchMove& move) { trace.moves.push_back(move); });
  trace.status = record.status;
  log.append(store::bytes_of(trace));
  return record;
}

}  // namespace vrda::run
