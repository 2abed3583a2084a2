#include "cluster/solved_count.hpp"

#include <algorithm>
#include <filesystem>

#include "cluster/shard.hpp"
#include "core/error.hpp"
#include "journal/journal.hpp"

namespace vrda {
namespace {

const SubmittedCase& case_of(const Submission& submission, const TaskId& task)
{
  return submission.cases.at(static_cast<std::size_t>(task.case_number));
}

std::vector<std::int32_t> rows_of(const Submission& submission, const TaskId& task)
{
  return rows_of(Shard{task.shard, submission.n_shards}, case_of(submission, task).n_flexion);
}

}  // namespace

std::vector<std::string> journals_of(const std::string& folder, const Submission& submission,
                                     const TaskId& task)
{
  if (task.case_number < 0) return {};
  const std::string output = output_of(folder, case_of(submission, task));
  switch (task.kind) {
    case TaskKind::spine:
      return {spine_journal_of(output)};
    case TaskKind::shard:
      return {shard_journal_of(output, {task.shard, submission.n_shards}), spine_journal_of(output)};
    case TaskKind::run:
      return {journal_of(output)};
    case TaskKind::merge:
    case TaskKind::index:
      break;
  }
  return {};
}

SolvedCounter::Content SolvedCounter::content_of(const std::string& journal)
{
  Content content;
  std::error_code ignored;
  if (!std::filesystem::exists(journal, ignored)) return content;
  try {
    for (const StepRecord& record : read_journal(journal).records) {
      const StepKey& key = record.key;
      if (key.kind == StepKind::spine || key.kind == StepKind::row)
        content.cells.insert({key.flexion, key.varus});
      if (key.kind == StepKind::free_spine) ++content.n_free_steps;
    }
  } catch (const InputError&) {
    // The task that goes on with it says what is wrong.
  }
  return content;
}

const SolvedCounter::Content& SolvedCounter::spine_of(std::int32_t case_number)
{
  if (spine_case_ != case_number) {
    spine_ = content_of(
        spine_journal_of(output_of(folder_, submission_.cases.at(static_cast<std::size_t>(case_number)))));
    spine_case_ = case_number;
  }
  return spine_;
}

std::int64_t SolvedCounter::total_of(const TaskId& task) const
{
  if (task.case_number < 0) return 0;
  const SubmittedCase& c = case_of(submission_, task);
  if (task.kind == TaskKind::run) return std::int64_t{c.n_flexion} * c.n_varus;
  if (task.kind != TaskKind::shard) return 0;
  return static_cast<std::int64_t>(rows_of(submission_, task).size()) * c.n_varus;
}

SolvedCount SolvedCounter::count(const TaskId& task)
{
  const std::int64_t n_total = total_of(task);
  if (task.kind == TaskKind::run) {
    const Content content = content_of(journals_of(folder_, submission_, task).front());
    return {static_cast<std::int64_t>(content.cells.size()), n_total};
  }
  if (task.kind == TaskKind::spine) {
    const Content content = content_of(journals_of(folder_, submission_, task).front());
    if (content.n_free_steps > 0) return {content.n_free_steps, 0};
    return {static_cast<std::int64_t>(content.cells.size()), case_of(submission_, task).n_flexion};
  }
  if (task.kind != TaskKind::shard) return {};
  std::set<Cell> cells = content_of(journals_of(folder_, submission_, task).front()).cells;
  const std::set<Cell>& spine = spine_of(task.case_number).cells;
  cells.insert(spine.begin(), spine.end());
  const std::vector<std::int32_t> rows = rows_of(submission_, task);
  const auto n_done = std::count_if(cells.begin(), cells.end(), [&](const Cell& cell) {
    return std::binary_search(rows.begin(), rows.end(), cell.first);
  });
  return {n_done, n_total};
}

}  // namespace vrda
