#include "run/trace_log.hpp"

#include <algorithm>
#include <filesystem>

#include "core/error.hpp"
#include "journal/journal.hpp"
#include "talk/talk.hpp"

namespace vrda {
namespace {

// A spine cell has been solved as a probe.
bool needs_trace(const StepKey& key)
{
  return key.kind != StepKind::spine;
}

}  // namespace

FrameWriter open_trace_log(const std::string& path, const std::string& key, const std::string& steps_path,
                           const std::map<StepKey, StepRecord>& known)
{
  if (known.empty()) return create_trace_journal(path, key);
  TraceJournalContent content;
  if (std::filesystem::exists(path)) {
    content = read_trace_journal(path);
    require_key(content.facts.key, path, key);
  }
  const auto n_missing = std::count_if(known.begin(), known.end(), [&](const auto& step) {
    return needs_trace(step.first) && content.searches.count(step.first) == 0;
  });
  if (n_missing > 0) {
    throw InputError(
        {path, "", "no trace of " + std::to_string(n_missing) + " steps that " + steps_path + " holds",
         "a run that has been traced from its start: use --fresh to start over, or go on without "
         "--trace"});
  }
  if (!content.facts.dropped_why.empty()) {
    warn(path + ": dropped " + std::to_string(content.facts.dropped_bytes) + " bytes at the end (" +
         content.facts.dropped_why + ")");
  }
  return resume_trace_journal(path, content.facts);
}

StepRecord followed(FrameWriter& log, const StepKey& key, const MovingPose& seed,
                    const std::function<StepRecord(const Watch&)>& solve)
{
  SearchTrace trace;
  trace.key = key;
  trace.seed = seed;
  StepRecord record = solve([&](const SearchMove& move) { trace.moves.push_back(move); });
  trace.status = record.status;
  log.append(bytes_of(trace));
  return record;
}

}  // namespace vrda
