#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "app/cluster_commands.hpp"
#include "cluster/status.hpp"
#include "cluster/submission.hpp"
#include "cluster/task_state.hpp"
#include "index/index.hpp"
#include "run/run_output.hpp"
#include "run/summary.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;

std::string amount_text(const TaskView& task)
{
  if (task.n_total > 0) return std::to_string(task.n_done) + " of " + std::to_string(task.n_total);
  return task.n_done > 0 ? std::to_string(task.n_done) + " steps" : "";
}

void print_task(const TaskView& task, const Submission& submission)
{
  std::string line = text_of(task.task, submission);
  const auto pad = [&](std::size_t width) { line.resize(std::max(line.size() + 1, width), ' '); };
  constexpr std::size_t state_column = 18, amount_column = 31, rest_column = 46;
  pad(state_column);
  line += name_of(task.standing);
  pad(amount_column);
  line += amount_text(task);
  pad(rest_column);
  if (task.standing == TaskStanding::running) line += task.host;
  if (task.standing != TaskStanding::running && !task.slurm_job.empty()) line += task.slurm_job;
  if (task.per_second) line += "  " + rate_text(*task.per_second, task.seconds_left);
  if (!task.reason.empty()) line += (line.back() == ' ' ? "" : "  ") + task.reason;
  if (task.n_restarts > 0) {
    const std::string times = task.n_restarts == 1 ? "once" : std::to_string(task.n_restarts) + " times";
    line += "  (restarted " + times + ")";
  }
  line.erase(line.find_last_not_of(' ') + 1);
  std::printf("%s\n", line.c_str());
}

void print_case(const CaseView& view, const Submission& submission)
{
  std::int64_t n_done = 0, n_total = 0;
  std::string reason;
  for (const TaskView& task : view.tasks) {
    if (task.standing == view.standing && reason.empty() && !task.reason.empty()) {
      reason = text_of(task.task, submission) + ": " + task.reason;
    }
    if (task.task.kind != TaskKind::shard && task.task.kind != TaskKind::run) continue;
    n_done += task.n_done;
    n_total += task.n_total;
  }
  const std::string& name = submission.cases[static_cast<std::size_t>(view.case_number)].spec.name;
  std::printf("%-40s %-12s %lld of %lld%s%s\n", name.c_str(), name_of(view.standing),
              static_cast<long long>(n_done), static_cast<long long>(n_total), reason.empty() ? "" : "  ",
              reason.c_str());
}

Json optional_number(const std::optional<double>& value)
{
  return value ? Json(*value) : Json();
}

Json json_of(const TaskView& task)
{
  return {{"kind", name_of(task.task.kind)},
          {"shard", task.task.shard > 0 ? Json(task.task.shard) : Json()},
          {"state", name_of(task.standing)},
          {"reason", task.reason},
          {"host", task.host},
          {"slurm_job", task.slurm_job},
          {"restarts", task.n_restarts},
          {"done", task.n_done},
          {"total", task.n_total > 0 ? Json(task.n_total) : Json()},
          {"per_second", optional_number(task.per_second)},
          {"seconds_left", optional_number(task.seconds_left)}};
}

Json json_of(const CaseView& view, const std::string& folder, const Submission& submission)
{
  const SubmittedCase& c = submission.cases[static_cast<std::size_t>(view.case_number)];
  Json tasks = Json::array();
  for (const TaskView& task : view.tasks) tasks.push_back(json_of(task));
  return {{"name", c.spec.name},
          {"state", name_of(view.standing)},
          {"made", view.is_made},
          {"output", output_of(folder, c)},
          {"tasks", tasks}};
}

void print_json(const StatusView& status, const std::string& folder, const Submission& submission)
{
  Json cases = Json::array();
  for (const CaseView& view : status.cases) cases.push_back(json_of(view, folder, submission));
  const Json json = {{"folder", folder},        {"summary", summary_of(status, submission)},
                     {"remark", status.remark}, {"shards", submission.n_shards},
                     {"cases", cases},          {"index", status.index ? json_of(*status.index) : Json()}};
  std::printf("%s\n", json.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

void print_tasks(const CaseView& view, const Submission& submission)
{
  for (const TaskView& task : view.tasks) print_task(task, submission);
}

}  // namespace

ExitCode status_command(const StatusOptions& options)
{
  const std::string folder = absolute_folder(options.folder);
  const Submission submission = read_submission(folder);
  const StatusView status = status_of(folder, submission, take_snapshot(folder, submission));
  if (!status.remark.empty()) warn(status.remark);
  if (options.as_json) {
    print_json(status, folder, submission);
    return ExitCode::done;
  }
  if (!options.case_name.empty()) {
    const auto number = static_cast<std::size_t>(case_named(submission, options.case_name));
    print_tasks(status.cases[number], submission);
    return ExitCode::done;
  }
  std::printf("%s\n", summary_of(status, submission).c_str());
  if (!submission.has_index()) {
    print_tasks(status.cases.front(), submission);
    return ExitCode::done;
  }
  for (const CaseView& view : status.cases) print_case(view, submission);
  print_task(*status.index, submission);
  return ExitCode::done;
}

namespace {

// The text with paths relative to the submission, wherever it is.
std::string without_folder(std::string text, const std::string& folder)
{
  for (std::size_t at = text.find(folder + "/"); at != std::string::npos; at = text.find(folder + "/", at)) {
    text.erase(at, folder.size() + 1);
  }
  return text;
}

// For each case with failed tasks: the reason of the last failure.
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
  // Locked before the cases are read: an older table must not replace a newer one.
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
