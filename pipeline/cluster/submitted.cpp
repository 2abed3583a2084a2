#include "cluster/submitted.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <set>
#include <utility>

#include "cluster/json_fields.hpp"
#include "core/error.hpp"
#include "core/open_file.hpp"

namespace vrda {
namespace {

using Json = nlohmann::ordered_json;

// Whether the last line was cut short, by a kill or a full disk: what follows must not join it.
bool has_torn_end(int descriptor)
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
  fields("at", s.at);
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
      write_all(file.get(), (has_torn_end(file.get()) ? "\n" : "") + Json(submitted).dump() + "\n") &&
      fsync(file.get()) == 0) {
    return std::nullopt;
  }
  return InputError::Facts{path, "",
                           std::string("a file that cannot be written (") + std::strerror(errno) + ")",
                           "room and permission to note down job " + submitted.id};
}

std::vector<SubmittedJob> read_submitted(const std::string& folder)
{
  std::vector<SubmittedJob> jobs;
  std::ifstream file(submitted_file_of(folder), std::ios::binary);
  for (std::string line; std::getline(file, line);) {
    try {
      jobs.push_back(Json::parse(line).get<SubmittedJob>());
    } catch (const Json::exception&) {  // a line cut short
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
