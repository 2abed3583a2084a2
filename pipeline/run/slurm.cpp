#include "run/slurm.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include "run/child.hpp"
#include "run/json_fields.hpp"
#include "core/error.hpp"
#include "core/open_file.hpp"

namespace vrda::run {
namespace {

// Ids per command line, far below the system's limit.
constexpr std::size_t ids_at_once = 2000;

std::vector<std::string> lines_of(const std::string& text)
{
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string trimmed(const std::string& text)
{
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

std::int32_t number_in(const std::string& text, std::int32_t otherwise)
{
  char* end = nullptr;
  errno = 0;
  const long value = std::strtol(text.c_str(), &end, 10);
  const bool is_number = end != text.c_str() && errno == 0 && value >= 0 && value <= 1'000'000'000;
  return is_number ? static_cast<std::int32_t>(value) : otherwise;
}

InputError::Facts failure_of(const std::vector<std::string>& words, const ProgramResult& result,
                             const char* wanted)
{
  if (result.is_not_found) {
    return {words.front(), "", "no such program: Slurm is not installed here",
            "a machine of a Slurm cluster, or --local"};
  }
  const std::string message = slurm_message(result.err);
  return {words.front(), "", message.empty() ? "exit code " + std::to_string(result.exit_code) : message,
          wanted};
}

bool is_done(const ProgramResult& result)
{
  return !result.is_not_found && result.exit_code == 0;
}

constexpr const char* wanted_controller = "a responding Slurm controller, or --local";

std::string joined(const std::vector<std::string>& words, std::size_t from, std::size_t n)
{
  std::string text;
  for (std::size_t k = from; k < std::min(from + n, words.size()); ++k)
    text += (text.empty() ? "" : ",") + words[k];
  return text;
}

}  // namespace

std::vector<SlurmRow> rows_of_squeue(const std::string& text)
{
  std::vector<SlurmRow> rows;
  for (const std::string& line : lines_of(text)) {
    std::vector<std::string> fields;
    std::size_t from = 0;
    for (int k = 0; k < 4 && from != std::string::npos; ++k) {
      const std::size_t bar = line.find('|', from);
      if (bar == std::string::npos) break;
      fields.push_back(trimmed(line.substr(from, bar - from)));
      from = bar + 1;
    }
    if (fields.size() != 4 || fields[0].empty()) continue;
    rows.push_back({fields[0], number_in(fields[1], 0), fields[2], fields[3], trimmed(line.substr(from))});
  }
  return rows;
}

SlurmLimits limits_of_config(const std::string& text)
{
  SlurmLimits limits;
  for (const std::string& line : lines_of(text)) {
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) continue;
    const std::string key = trimmed(line.substr(0, equals)), value = trimmed(line.substr(equals + 1));
    if (key == "MaxArraySize") limits.max_array_size = number_in(value, limits.max_array_size);
    if (key == "MaxJobCount") limits.max_job_count = number_in(value, limits.max_job_count);
  }
  return limits;
}

bool is_queued(const SlurmRow& row)
{
  constexpr std::array<const char*, 4> states{"PENDING", "REQUEUED", "REQUEUE_HOLD", "SPECIAL_EXIT"};
  const bool is_waiting = std::find(states.begin(), states.end(), row.state) != states.end();
  return is_waiting && row.reason != "DependencyNeverSatisfied";
}

bool is_held_after_failed_launch(const SlurmRow& row)
{
  return is_queued(row) && row.reason.find("launch failed requeued held") != std::string::npos;
}

bool is_running(const SlurmRow& row)
{
  constexpr std::array<const char*, 8> states{"RUNNING", "CONFIGURING", "COMPLETING", "SUSPENDED",
                                              "STOPPED", "SIGNALING",   "STAGE_OUT",  "RESIZING"};
  return std::find(states.begin(), states.end(), row.state) != states.end();
}

std::string slurm_message(const std::string& standard_error)
{
  std::string message;
  for (std::string line : lines_of(standard_error)) {
    line = trimmed(line);
    for (const char* mark : {"error: ", "fatal: "}) {
      const std::size_t at = line.find(mark);
      if (at != std::string::npos) line = line.substr(at + std::strlen(mark));
    }
    if (!line.empty()) message += (message.empty() ? "" : "; ") + line;
  }
  return message;
}

SlurmLimits query_limits()
{
  const std::vector<std::string> words{"scontrol", "show", "config"};
  const ProgramResult result = run_program(words, "");
  if (!is_done(result)) throw InputError(failure_of(words, result, wanted_controller));
  return limits_of_config(result.out);
}

SubmitResult submit_job(const std::vector<std::string>& words, const std::string& folder)
{
  const ProgramResult result = run_program(words, folder);
  const std::string id = trimmed(result.out.substr(0, result.out.find_first_of(";\n")));
  if (is_done(result) && !id.empty()) return {id, std::nullopt};
  return {"", failure_of(words, result, "a job that Slurm accepts")};
}

QueueResult query_queue(const std::vector<std::string>& ids)
{
  QueueResult answer;
  for (std::size_t k = 0; k < ids.size(); k += ids_at_once) {
    const std::vector<std::string> words{
        "squeue",       "--noheader", "--all",       "--array",
        "--states=all", "-o",         squeue_format, "--jobs=" + joined(ids, k, ids_at_once)};
    const ProgramResult result = run_program(words, "");
    // For a single purged job squeue fails instead of printing no row.
    const bool is_purged = result.err.find("Invalid job id") != std::string::npos;
    if (!is_done(result) && !is_purged) return {{}, failure_of(words, result, wanted_controller)};
    const std::vector<SlurmRow> some = rows_of_squeue(result.out);
    answer.rows.insert(answer.rows.end(), some.begin(), some.end());
  }
  return answer;
}

std::optional<InputError::Facts> cancel_jobs(const std::vector<std::string>& ids)
{
  for (std::size_t k = 0; k < ids.size(); k += ids_at_once) {
    std::vector<std::string> words{"scancel"};
    for (std::size_t i = k; i < std::min(k + ids_at_once, ids.size()); ++i) words.push_back(ids[i]);
    const ProgramResult result = run_program(words, "");
    if (!is_done(result)) return failure_of(words, result, "jobs that may be cancelled");
  }
  return std::nullopt;
}

void release_jobs(const std::vector<std::string>& ids)
{
  for (std::size_t k = 0; k < ids.size(); k += ids_at_once) {
    const std::vector<std::string> words{"scontrol", "release", joined(ids, k, ids_at_once)};
    const ProgramResult result = run_program(words, "");
    if (!is_done(result)) throw InputError(failure_of(words, result, "jobs that may be released"));
  }
}

namespace {

using Json = nlohmann::ordered_json;

// Whether the last line is incomplete (killed writer, full disk), so that a line break must be added.
bool has_incomplete_line(int descriptor)
{
  const off_t size = lseek(descriptor, 0, SEEK_END);
  char last = '\n';
  return size > 0 && pread(descriptor, &last, 1, size - 1) == 1 && last != '\n';
}

}  // namespace

template <typename Fields>
void name_fields(const Fields& fields, SubmittedJob& s)
{
  fields("id", s.id);
  fields("at", s.submitted_at);
  std::string kind = name_of(s.job.kind);
  fields("kind", kind);
  const std::optional<TaskKind> known = task_kind_of(kind);
  if (!known) throw Json::other_error::create(501, "an unknown kind of task", nullptr);
  s.job.kind = *known;
  fields("case", s.job.case_number);
  fields("array", s.job.numbers);
  fields("offset", s.job.offset);
  fields("per_task", s.job.per_task);
}

std::optional<InputError::Facts> append_submitted(const std::string& folder, const SubmittedJob& submitted)
{
  const std::string path = submitted_file_of(folder);
  const OpenFile file(open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  if (file.is_open() &&
      write_all(file.get(), (has_incomplete_line(file.get()) ? "\n" : "") + Json(submitted).dump() + "\n") &&
      fsync(file.get()) == 0) {
    return std::nullopt;
  }
  return InputError::Facts{path, "",
                           std::string("a file that cannot be written (") + std::strerror(errno) + ")",
                           "disk space and permission to record job " + submitted.id};
}

std::vector<SubmittedJob> read_submitted(const std::string& folder)
{
  std::vector<SubmittedJob> jobs;
  std::ifstream file(submitted_file_of(folder), std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    try {
      jobs.push_back(Json::parse(line).get<SubmittedJob>());
    } catch (const Json::exception&) {  // an incomplete line
    }
  }
  return jobs;
}

std::map<TaskId, SlurmTask> tasks_in_slurm(const Submission& submission,
                                           const std::vector<SubmittedJob>& jobs,
                                           const std::vector<SlurmRow>& rows)
{
  std::map<std::pair<std::string, std::int32_t>, const SlurmRow*> row_of;
  for (const SlurmRow& row : rows) row_of[{row.id, row.number}] = &row;
  std::map<TaskId, SlurmTask> tasks;
  for (const SubmittedJob& submitted : jobs) {
    const bool has_array = !submitted.job.numbers.empty();
    const std::vector<std::int32_t> numbers =
        has_array ? submitted.job.numbers : std::vector<std::int32_t>{0};
    for (const std::int32_t number : numbers) {
      const auto found = row_of.find({submitted.id, number});
      const std::string job = has_array ? submitted.id + "_" + std::to_string(number) : submitted.id;
      SlurmTask task{job, found == row_of.end() ? SlurmRow{} : *found->second, ""};
      for (const TaskId& id : tasks_of(submission, submitted.job, number)) {
        const bool is_shared = id.kind == TaskKind::run;
        task.per_task = submitted.job.per_task;
        task.log = is_shared ? log_of_runs(submitted.job.offset, std::to_string(number))
                             : file_stem_of(id, submission) + ".log";
        tasks[id] = task;
      }
    }
  }
  return tasks;
}

void require_same_cases_per_task(const std::map<TaskId, SlurmTask>& tasks, std::int32_t requested)
{
  for (const auto& [id, task] : tasks) {
    const bool is_under_way = is_queued(task.row) || is_running(task.row);
    if (id.kind != TaskKind::run || !is_under_way || task.per_task == requested) continue;
    const std::string active = std::to_string(task.per_task);
    throw InputError({"--cases-per-task", "",
                      std::to_string(requested) + ", while tasks of " + active + " are queued or running",
                      active + "; another number after they have ended (scancel ends them)"});
  }
}

}  // namespace vrda::run
