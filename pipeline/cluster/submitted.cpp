#include "cluster/submitted.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "core/open_file.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;

std::string line_of(const SubmittedJob& s)
{
  const Json json = {{"id", s.id},
                     {"at", s.at},
                     {"kind", name_of(s.job.kind)},
                     {"case", s.job.case_number},
                     {"array", s.job.numbers},
                     {"offset", s.job.offset},
                     {"per_task", s.job.per_task}};
  return json.dump() + "\n";
}

SubmittedJob submitted_of(const Json& json)
{
  SubmittedJob s;
  s.id = json.at("id");
  s.at = json.at("at");
  s.job.kind = task_kind_of(json.at("kind"));
  s.job.case_number = json.at("case");
  s.job.numbers = json.at("array").get<std::vector<std::int32_t>>();
  s.job.offset = json.at("offset");
  s.job.per_task = json.at("per_task");
  return s;
}

// Whether the last line was cut short, by a kill or a full disk: what follows must not join it.
bool has_torn_end(int descriptor)
{
  const off_t size = lseek(descriptor, 0, SEEK_END);
  char last = '\n';
  return size > 0 && pread(descriptor, &last, 1, size - 1) == 1 && last != '\n';
}

// The tasks of number `number` of a job (0: of a job without an array).
std::vector<TaskId> tasks_of(const Submission& submission, const PlannedJob& job, std::int32_t number)
{
  if (job.kind == TaskKind::shard) return {{job.kind, job.case_number, number}};
  if (job.kind != TaskKind::run) return {{job.kind, job.case_number, 0}};
  std::vector<TaskId> tasks;
  for (const std::int32_t k : cases_of_task(job, number, submission.cases.size())) {
    tasks.push_back({TaskKind::run, k, 0});
  }
  return tasks;
}

}  // namespace

void append_submitted(const std::string& folder, const SubmittedJob& submitted)
{
  const std::string path = submitted_file_of(folder);
  const OpenFile file(open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
  if (file.is_open() && write_all(file.get(), (has_torn_end(file.get()) ? "\n" : "") + line_of(submitted)) &&
      fsync(file.get()) == 0) {
    return;
  }
  throw InputError({path, "", std::string("a file that cannot be written (") + std::strerror(errno) + ")",
                    "room and permission to note down job " + submitted.id});
}

std::vector<SubmittedJob> read_submitted(const std::string& folder)
{
  std::vector<SubmittedJob> jobs;
  std::ifstream file(submitted_file_of(folder), std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    try {
      jobs.push_back(submitted_of(Json::parse(line)));
    } catch (const Json::exception&) {
    } catch (const InputError&) {
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

void require_same_span(const std::map<TaskId, SlurmTask>& tasks, std::int32_t asked)
{
  for (const auto& [id, task] : tasks) {
    const bool is_under_way = is_queued(task.row) || is_running(task.row);
    if (id.kind != TaskKind::run || !is_under_way || task.per_task == asked) continue;
    const std::string there = std::to_string(task.per_task);
    throw InputError({"--cases-per-task", "",
                      std::to_string(asked) + ", while tasks of " + there + " are queued or running",
                      there + "; another number once they have ended (scancel ends them)"});
  }
}

}  // namespace vrda
