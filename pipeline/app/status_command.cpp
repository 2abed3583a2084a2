// `vrda status` and `vrda index`: progress of a submission, and a table of its results.
#include <algorithm>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/printing.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "run/index.hpp"
#include "run/run_output.hpp"
#include "run/status.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

/// `vrda status`: prints the progress of the tasks of a submission.
struct StatusOptions {
  std::string folder;
  std::string case_name;  ///< print this case's tasks; empty: the only case's, or one line per campaign case
  bool as_json = false;   ///< print all cases and tasks
};

std::string amount_text(const run::TaskView& task)
{
  if (task.n_total > 0) return std::to_string(task.n_done) + " of " + std::to_string(task.n_total);
  return task.n_done > 0 ? std::to_string(task.n_done) + " steps" : "";
}

void print_task(const run::TaskView& task, const run::Submission& submission)
{
  std::string line = run::text_of(task.task, submission);
  const auto pad = [&](std::size_t width) { line.resize(std::max(line.size() + 1, width), ' '); };
  constexpr std::size_t state_column = 18, amount_column = 31, rest_column = 46;
  pad(state_column);
  line += core::name_of(task.status);
  pad(amount_column);
  line += amount_text(task);
  pad(rest_column);
  if (task.status == run::TaskStatus::running) line += task.host;
  if (task.status != run::TaskStatus::running && !task.slurm_job.empty()) line += task.slurm_job;
  if (task.per_second) line += "  " + run::rate_text(*task.per_second, task.seconds_left);
  if (!task.reason.empty()) line += (line.back() == ' ' ? "" : "  ") + task.reason;
  if (task.n_restarts > 0) {
    const std::string times = task.n_restarts == 1 ? "once" : std::to_string(task.n_restarts) + " times";
    line += "  (restarted " + times + ")";
  }
  line.erase(line.find_last_not_of(' ') + 1);
  std::printf("%s\n", line.c_str());
}

void print_case(const run::CaseView& view, const run::Submission& submission)
{
  std::int64_t n_done = 0, n_total = 0;
  std::string reason;
  for (const run::TaskView& task : view.tasks) {
    if (task.status == view.status && reason.empty() && !task.reason.empty()) {
      reason = run::text_of(task.task, submission) + ": " + task.reason;
    }
    if (task.task.kind != run::TaskKind::shard && task.task.kind != run::TaskKind::run) continue;
    n_done += task.n_done;
    n_total += task.n_total;
  }
  const std::string& name = submission.cases[static_cast<std::size_t>(view.case_number)].spec.name;
  std::printf("%-40s %-12s %lld of %lld%s%s\n", name.c_str(), core::name_of(view.status),
              static_cast<long long>(n_done), static_cast<long long>(n_total), reason.empty() ? "" : "  ",
              reason.c_str());
}

Json json_of(const run::TaskView& task)
{
  return {{"kind", core::name_of(task.task.kind)},
          {"shard", task.task.shard > 0 ? Json(task.task.shard) : Json()},
          {"state", core::name_of(task.status)},
          {"reason", task.reason},
          {"host", task.host},
          {"slurm_job", task.slurm_job},
          {"restarts", task.n_restarts},
          {"done", task.n_done},
          {"total", task.n_total > 0 ? Json(task.n_total) : Json()},
          {"per_second", json_value(task.per_second)},
          {"seconds_left", json_value(task.seconds_left)}};
}

Json json_of(const run::CaseView& view, const std::string& folder, const run::Submission& submission)
{
  const run::SubmittedCase& c = submission.cases[static_cast<std::size_t>(view.case_number)];
  Json tasks = Json::array();
  for (const run::TaskView& task : view.tasks) tasks.push_back(json_of(task));
  return {{"name", c.spec.name},
          {"state", core::name_of(view.status)},
          {"made", view.is_complete},
          {"output", run::output_of(folder, c)},
          {"tasks", tasks}};
}

Json json_of(const run::StatusView& status, const std::string& folder, const run::Submission& submission)
{
  Json cases = Json::array();
  for (const run::CaseView& view : status.cases) cases.push_back(json_of(view, folder, submission));
  return {{"folder", folder},        {"summary", run::summary_of(status, submission)},
          {"remark", status.remark}, {"shards", submission.n_shards},
          {"cases", cases},          {"index", status.index ? json_of(*status.index) : Json()}};
}

void print_tasks(const run::CaseView& view, const run::Submission& submission)
{
  for (const run::TaskView& task : view.tasks) print_task(task, submission);
}

}  // namespace

core::ExitCode status_command(const StatusOptions& options)
{
  const std::string folder = run::absolute_folder(options.folder);
  const run::Submission submission = run::read_submission(folder);
  const run::StatusView status = run::status_of(folder, submission, run::take_snapshot(folder, submission));
  if (!status.remark.empty()) core::log_warning(status.remark);
  if (options.as_json) {
    print_json(json_of(status, folder, submission));
    return core::ExitCode::done;
  }
  if (!options.case_name.empty()) {
    const auto number = static_cast<std::size_t>(run::case_named(submission, options.case_name));
    print_tasks(status.cases[number], submission);
    return core::ExitCode::done;
  }
  std::printf("%s\n", run::summary_of(status, submission).c_str());
  if (!submission.has_index()) {
    print_tasks(status.cases.front(), submission);
    return core::ExitCode::done;
  }
  for (const run::CaseView& view : status.cases) print_case(view, submission);
  print_task(*status.index, submission);
  return core::ExitCode::done;
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
std::map<std::int32_t, std::string> failures_of(const std::string& folder, const run::Submission& submission)
{
  std::map<std::int32_t, std::string> reasons;
  for (const auto& [task, state] : run::read_task_states(folder, submission)) {
    if (task.case_number < 0 || state.status != run::TaskStatus::failed) continue;
    reasons[task.case_number] = run::text_of(task, submission) + ": " + without_folder(state.reason, folder);
  }
  return reasons;
}

std::vector<run::IndexRow> rows_of_submission(const IndexOptions& options, const run::Submission& submission)
{
  std::vector<run::IndexedCase> cases;
  for (const run::SubmittedCase& c : submission.cases)
    cases.push_back({c.spec.name, c.levels, run::output_of(options.folder, c)});
  std::vector<run::IndexRow> rows = run::index_rows(cases, run::thread_count_or_all(options.n_processes));
  for (const auto& [number, reason] : failures_of(options.folder, submission)) {
    run::IndexRow& row = rows[static_cast<std::size_t>(number)];
    if (row.status == run::CaseStatus::done) continue;
    row.status = run::CaseStatus::failed;
    row.remark = reason;
  }
  return rows;
}

std::map<run::CaseStatus, int> counts_of(const std::vector<run::IndexRow>& rows)
{
  std::map<run::CaseStatus, int> counts{{run::CaseStatus::done, 0},
                                        {run::CaseStatus::partial, 0},
                                        {run::CaseStatus::failed, 0},
                                        {run::CaseStatus::missing, 0}};
  for (const run::IndexRow& row : rows) ++counts[row.status];
  return counts;
}

}  // namespace

core::ExitCode write_submission_index(const IndexOptions& options, const run::Submission& submission)
{
  const std::string& folder = options.folder;
  // Locked before the cases are read: an older table must not replace a newer one.
  std::optional<Publication> result = run::begin_result(run::index_file_of(folder), "vrda index");
  if (!result) return core::ExitCode::interrupted;
  const std::vector<run::IndexRow> rows = rows_of_submission(options, submission);
  run::publish_index(*result, folder, submission.title, submission.axes, rows);
  nlohmann::ordered_json json;
  std::string line = std::to_string(rows.size()) + " cases:";
  for (const auto& [status, n] : counts_of(rows)) {
    json[core::name_of(status)] = n;
    if (n > 0) line += (line.back() == ':' ? " " : ", ") + std::to_string(n) + " " + core::name_of(status);
  }
  core::log_info(line);
  for (const char* name : {"index.csv", "index.h5", "index.times.csv"}) {
    json["files"].push_back(folder + "/" + name);
    if (!options.as_json) std::printf("%s/%s\n", folder.c_str(), name);
  }
  if (options.as_json) print_json(json);
  return core::ExitCode::done;
}

core::ExitCode index_command(const IndexOptions& options)
{
  const std::string folder = run::absolute_folder(options.folder);
  return write_submission_index({folder, options.as_json, options.n_processes}, run::read_submission(folder));
}

void declare_status(Command& c)
{
  auto& o = c.options<StatusOptions>();
  c.option("folder", o.folder, "Folder of the submission").required();
  c.option("--case", o.case_name, "Print the tasks of this case of a campaign");
  c.json(o.as_json, "Print everything as JSON");
  c.runs([&o] { return status_command(o); });
}

void declare_index(Command& c)
{
  auto& o = c.options<IndexOptions>();
  c.option("folder", o.folder, "Folder of the submission").required();
  c.option("--cpus", o.n_processes, "Processes that read motion models; default: one per processor")
      .whole_number(1, 1024);
  c.json(o.as_json);
  c.runs([&o] { return index_command(o); });
}

}  // namespace vrda::app
