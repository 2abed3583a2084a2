#include "cluster/collect.hpp"

#include <algorithm>
#include <utility>

#include "core/error.hpp"
#include "core/number_text.hpp"
#include "journal/journal.hpp"
#include "journal/record_bytes.hpp"

namespace vrda {
namespace {

// A replay stops at the first step that is not there.
SweepResult followed(SweepPlan plan, const std::map<StepKey, StepRecord>& steps)
{
  const SolveStep nothing = [](const StepTask&) -> StepRecord {
    throw InternalError("a replay solves nothing");
  };
  SweepHooks hooks;
  hooks.recall = [&](const StepKey& key) -> std::optional<StepRecord> {
    const auto found = steps.find(key);
    return found == steps.end() ? std::nullopt : std::optional(found->second);
  };
  hooks.is_stopped = [] { return true; };
  return sweep(plan, nothing, hooks, 1);
}

bool is_complete(SweepPlan plan, const std::map<StepKey, StepRecord>& steps, std::vector<std::int32_t> rows)
{
  plan.rows = std::move(rows);
  return followed(std::move(plan), steps).is_complete;
}

std::vector<std::int32_t> rows_asked(const SweepPlan& plan)
{
  if (plan.rows) return *plan.rows;
  std::vector<std::int32_t> all;
  for (std::size_t i = 0; i < plan.flexion_rad.size(); ++i) all.push_back(static_cast<std::int32_t>(i));
  return all;
}

std::int32_t cells_missing(const SweepPlan& plan, const std::map<StepKey, StepRecord>& steps,
                           std::int32_t row)
{
  const auto n_varus = static_cast<std::int32_t>(plan.varus_rad.size());
  std::int32_t n = 0;
  for (std::int32_t j = 0; j < n_varus; ++j) {
    n += steps.count({StepKind::row, row, j}) + steps.count({StepKind::spine, row, j}) == 0 ? 1 : 0;
  }
  return n;
}

void take(CollectedSteps& collected, std::map<StepKey, std::string>& came_from, const StepRecord& record,
          const std::string& journal)
{
  const auto [there, is_new] = collected.steps.emplace(record.key, record);
  if (is_new) {
    came_from.emplace(record.key, journal);
    return;
  }
  if (bytes_of(there->second) == bytes_of(record)) {
    ++collected.n_doubled;
    return;
  }
  throw InputError({journal,
                    std::string(name_of(record.key.kind)) + " step at flexion " +
                        std::to_string(record.key.flexion) + ", varus " + std::to_string(record.key.varus) +
                        " of the grid",
                    "another result than in " + came_from.at(record.key),
                    "the same: equal jobs give equal steps; leave out the journal you do not trust"});
}

}  // namespace

CollectedSteps collect(const std::vector<std::string>& journals, const std::string& key)
{
  CollectedSteps collected;
  std::map<StepKey, std::string> came_from;
  for (const std::string& journal : journals) {
    const JournalContent content = read_journal(journal);
    require_key(content.key, journal, key);
    if (!content.dropped_why.empty()) {
      collected.remarks.push_back(journal + ": dropped " + std::to_string(content.dropped_bytes) +
                                  " bytes at the end (" + content.dropped_why + ")");
    }
    for (const StepRecord& record : content.records) take(collected, came_from, record, journal);
  }
  return collected;
}

MissingSteps missing_steps(const SweepPlan& plan, const std::map<StepKey, StepRecord>& steps)
{
  MissingSteps missing;
  const std::vector<std::int32_t> rows = rows_asked(plan);
  if (is_complete(plan, steps, rows)) {  // one walk instead of one a row
    missing.is_spine_complete = true;
    return missing;
  }
  missing.is_spine_complete = is_complete(plan, steps, {});
  for (const std::int32_t row : rows) {
    if (missing.is_spine_complete && is_complete(plan, steps, {row})) continue;
    missing.rows.push_back(row);
    missing.n_attitudes += cells_missing(plan, steps, row);
  }
  return missing;
}

SweepResult replayed(const SweepPlan& plan, const std::map<StepKey, StepRecord>& steps)
{
  SweepResult result = followed(plan, steps);
  check(result.is_complete, "a replay has every step it needs");
  return result;
}

std::string flexions_text(const std::vector<std::int32_t>& rows, const std::vector<double>& flexion_deg)
{
  const auto degrees = [&](std::size_t k) {
    return shortest(flexion_deg[static_cast<std::size_t>(rows[k])]);
  };
  std::vector<std::string> parts;
  for (std::size_t first = 0, last = 0; first < rows.size(); first = last + 1) {
    last = first;
    while (last + 1 < rows.size() && rows[last + 1] == rows[last] + 1) ++last;
    if (last >= first + 2) {
      parts.push_back(degrees(first) + " to " + degrees(last));
    } else {
      for (std::size_t k = first; k <= last; ++k) parts.push_back(degrees(k));
    }
  }
  std::string text;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    text += k == 0 ? "" : k + 1 == parts.size() ? " and " : ", ";
    text += parts[k];
  }
  return text;
}

}  // namespace vrda
