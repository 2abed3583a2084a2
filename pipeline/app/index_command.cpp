#include "app/index_command.hpp"

#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "cluster/submission.hpp"
#include "cluster/task_state.hpp"
#include "index/index.hpp"
#include "run/run_output.hpp"
#include "run/solved_model.hpp"

namespace vrda {
namespace {

// The same wherever the submission stands.
std::string without_folder(std::string text, const std::string& folder)
{
  for (std::size_t at = text.find(folder + "/"); at != std::string::npos; at = text.find(folder + "/", at)) {
    text.erase(at, folder.size() + 1);
  }
  return text;
}

// Of each case whose tasks failed, why the last of them did.
std::map<std::int32_t, std::string> failures_of(const std::string& folder, const Submission& submission)
{
  std::map<std::int32_t, std::string> reasons;
  for (const auto& [task, state] : read_task_states(folder, submission)) {
    if (task.case_number < 0 || state.phase != TaskPhase::failed) continue;
    reasons[task.case_number] = text_of(task, submission) + ": " + without_folder(state.reason, folder);
  }
  return reasons;
}

std::vector<IndexRow> rows_of_submission(const IndexOptions& options, const Submission& submission)
{
  std::vector<IndexedCase> cases;
  for (const SubmittedCase& c : submission.cases)
    cases.push_back({c.spec.name, c.levels, output_of(options.folder, c)});
  std::vector<IndexRow> rows = index_rows(cases, threads_or_all(options.n_processes));
  for (const auto& [number, reason] : failures_of(options.folder, submission)) {
    IndexRow& row = rows[static_cast<std::size_t>(number)];
    if (row.status == CaseStatus::done) continue;
    row.status = CaseStatus::failed;
    row.remark = reason;
  }
  return rows;
}

std::map<CaseStatus, int> counts_of(const std::vector<IndexRow>& rows)
{
  std::map<CaseStatus, int> counts{
      {CaseStatus::done, 0}, {CaseStatus::partial, 0}, {CaseStatus::failed, 0}, {CaseStatus::missing, 0}};
  for (const IndexRow& row : rows) ++counts[row.status];
  return counts;
}

}  // namespace

ExitCode write_index_of(const IndexOptions& options, const Submission& submission)
{
  const std::string& folder = options.folder;
  // From the first look at the cases on: a table that was begun before must not replace one that knows more.
  const std::optional<OutputLock> lock = locked_output(folder + "/index.h5", "vrda index");
  if (!lock) return ExitCode::interrupted;
  const std::vector<IndexRow> rows = rows_of_submission(options, submission);
  write_index(folder, submission.title, submission.axes, rows);
  nlohmann::ordered_json json;
  std::string line = std::to_string(rows.size()) + " cases:";
  for (const auto& [status, n] : counts_of(rows)) {
    json[name_of(status)] = n;
    if (n > 0) line += (line.back() == ':' ? " " : ", ") + std::to_string(n) + " " + name_of(status);
  }
  say(line);
  for (const char* name : {"index.csv", "index.h5", "index.times.csv"}) {
    json["files"].push_back(folder + "/" + name);
    if (!options.as_json) std::printf("%s/%s\n", folder.c_str(), name);
  }
  if (options.as_json) std::printf("%s\n", json.dump(2).c_str());
  return ExitCode::done;
}

ExitCode index_command(const IndexOptions& options)
{
  const std::string folder = absolute_folder(options.folder);
  return write_index_of({folder, options.as_json, options.n_processes}, read_submission(folder));
}

}  // namespace vrda
