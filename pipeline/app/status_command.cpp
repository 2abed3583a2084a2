#include "app/status_command.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "cluster/status.hpp"
#include "run/json_number.hpp"

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
  constexpr std::size_t standing_column = 18, amount_column = 31, rest_column = 46;
  pad(standing_column);
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
    line += "  (begun again " + times + ")";
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
  return value ? number_or_null(*value) : Json();
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

}  // namespace vrda
