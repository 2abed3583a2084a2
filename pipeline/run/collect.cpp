#include "run/collect.hpp"

#include <utility>

#include "core/error.hpp"
#include "core/text.hpp"
#include "store/journal.hpp"
#include "store/record_bytes.hpp"

namespace vrda::run {
namespace {

// Stops at the first missing step.
solve::SweepResult replay(solve::SweepPlan plan, const std::map<StepKey, StepRecord>& steps)
{
  const solve::SolveStep nothing = [](const solve::StepTask&) -> StepRecord {
    throw InternalError("a replay solves no step");
  };
  solve::SweepHooks hooks;
  hooks.recall = [&](const StepKey& key) -> std::optional<StepRecord> {
    const auto found = steps.find(key);
    return found == steps.end() ? std::nullopt : std::optional(found->second);
  };
  hooks.is_stopped = [] { return true; };
  return solve::sweep(plan, nothing, hooks, 1);
}

bool is_complete(solve::SweepPlan plan, const std::map<StepKey, StepRecord>& steps,
                 std::vector<std::int32_t> rows)
{
  plan.rows = std::move(rows);
  return replay(std::move(plan), steps).is_complete;
}

std::vector<std::int32_t> rows_of_plan(const solve::SweepPlan& plan)
{
  if (plan.rows) return *plan.rows;
  std::vector<std::int32_t> all;
  for (std::size_t i = 0; i < plan.flexion_rad.size(); ++i) all.push_back(static_cast<std::int32_t>(i));
  return all;
}

// Adds an incomplete row.
void add_row(MissingSteps& missing, const solve::SweepPlan& plan, const std::map<StepKey, StepRecord>& steps,
             std::int32_t row)
{
  IncompleteRow part{row, {}};
  bool has_results = false;
  for (std::int32_t j = 0; j < static_cast<std::int32_t>(plan.varus_rad.size()); ++j) {
    const bool is_solved = steps.count({StepKind::row, row, j}) > 0;
    has_results = has_results || is_solved;
    if (!is_solved && steps.count({StepKind::spine, row, j}) == 0) part.columns.push_back(j);
  }
  missing.rows.push_back(row);
  missing.n_attitudes += static_cast<std::int32_t>(part.columns.size());
  if (has_results && !part.columns.empty()) missing.incomplete_rows.push_back(std::move(part));
}

void take(CollectedSteps& collected, std::map<StepKey, std::string>& came_from, const StepRecord& record,
          const std::string& journal)
{
  const auto [there, is_new] = collected.steps.emplace(record.key, record);
  if (is_new) {
    came_from.emplace(record.key, journal);
    return;
  }
  if (store::bytes_of(there->second) == store::bytes_of(record)) {
    ++collected.n_duplicates;
    collected.duplicate_rows.insert(record.key.flexion);
    collected.duplicate_journals.insert({came_from.at(record.key), journal});
    return;
  }
  throw InputError({journal,
                    std::string(name_of(record.key.kind)) + " step at flexion " +
                        std::to_string(record.key.flexion) + ", varus " + std::to_string(record.key.varus) +
                        " of the grid",
                    "a result that differs from that in " + came_from.at(record.key),
                    "the same result, since the job is the same; leave out the wrong journal"});
}

}  // namespace

CollectedSteps collect_steps(const std::vector<std::string>& journals, const std::string& key)
{
  CollectedSteps collected;
  std::map<StepKey, std::string> came_from;
  for (const std::string& journal : journals) {
    const store::JournalContent content = store::read_journal(journal);
    if (content.key != key) {
      throw InputError({journal, "key", "the journal of another job (" + content.key + ")",
                        key + "; leave it out, or pass its own job"});
    }
    if (!content.dropped_reason.empty()) {
      collected.warnings.push_back(journal + ": dropped " + std::to_string(content.dropped_bytes) +
                                   " bytes at the end (" + content.dropped_reason + ")");
    }
    for (const StepRecord& record : content.records) take(collected, came_from, record, journal);
  }
  return collected;
}

MissingSteps missing_steps(const solve::SweepPlan& plan, const std::map<StepKey, StepRecord>& steps)
{
  MissingSteps missing;
  const std::vector<std::int32_t> rows = rows_of_plan(plan);
  if (is_complete(plan, steps, rows)) {  // one replay instead of one per row
    missing.is_spine_complete = true;
    return missing;
  }
  missing.is_spine_complete = is_complete(plan, steps, {});
  for (const std::int32_t row : rows) {
    if (missing.is_spine_complete && is_complete(plan, steps, {row})) continue;
    add_row(missing, plan, steps, row);
  }
  return missing;
}

solve::SweepResult replay_sweep(const solve::SweepPlan& plan, const std::map<StepKey, StepRecord>& steps)
{
  solve::SweepResult result = replay(plan, steps);
  check(result.is_complete, "a replay needs every step");
  return result;
}

std::string angles_text(const std::vector<std::int32_t>& indices, const std::vector<double>& angles_deg)
{
  const auto degrees = [&](std::size_t k) {
    return shortest_decimal(angles_deg[static_cast<std::size_t>(indices[k])]);
  };
  std::vector<std::string> parts;
  for (std::size_t first = 0, last = 0; first < indices.size(); first = last + 1) {
    last = first;
    while (last + 1 < indices.size() && indices[last + 1] == indices[last] + 1) ++last;
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

std::string missing_text(const MissingSteps& missing, const std::vector<double>& flexion_deg,
                         const std::vector<double>& varus_deg)
{
  if (missing.rows.empty()) return {};
  if (missing.n_attitudes == 0 && missing.is_spine_complete) {
    return "no rotation band at flexion " + angles_text(missing.rows, flexion_deg);
  }
  if (missing.n_attitudes == 0) return {};
  std::vector<std::int32_t> whole;
  std::size_t next = 0;
  for (const std::int32_t row : missing.rows) {
    if (next < missing.incomplete_rows.size() && missing.incomplete_rows[next].row == row) {
      ++next;
    } else {
      whole.push_back(row);
    }
  }
  std::string text = "no result for " + std::to_string(missing.n_attitudes) + " of " +
                     std::to_string(flexion_deg.size() * varus_deg.size()) + " attitudes";
  if (!whole.empty()) text += ", at flexion " + angles_text(whole, flexion_deg);
  for (const IncompleteRow& part : missing.incomplete_rows) {
    text += std::string(text.ends_with("attitudes") ? "," : ", and") + " at flexion " +
            angles_text({part.row}, flexion_deg) + " of varus " + angles_text(part.columns, varus_deg);
  }
  return text;
}

}  // namespace vrda::run
