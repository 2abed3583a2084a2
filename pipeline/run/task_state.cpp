#include "run/task_state.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <set>

#include "run/json_fields.hpp"
#include "core/atomic_file.hpp"

namespace vrda::run {
namespace {

constexpr std::array<const char*, 4> phase_names{"running", "done", "failed", "interrupted"};

std::string environment(const char* name)
{
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

std::string slurm_job()
{
  const std::string array = environment("SLURM_ARRAY_JOB_ID");
  if (!array.empty()) return array + "_" + environment("SLURM_ARRAY_TASK_ID");
  return environment("SLURM_JOB_ID");
}

}  // namespace

template <typename Fields>
void name_fields(const Fields& fields, TaskState& s)
{
  std::string phase = name_of(s.phase);
  fields("state", phase);
  const auto named = std::find(phase_names.begin(), phase_names.end(), phase);
  if (named == phase_names.end()) throw nlohmann::json::other_error::create(501, "an unknown state", nullptr);
  s.phase = static_cast<TaskPhase>(named - phase_names.begin());
  fields("host", s.host);
  fields("begun", s.started);
  fields("ended", s.ended);
  fields("attitudes_at_begin", s.n_done_at_start);
  fields("slurm_job", s.slurm_job);
  fields("restarts", s.n_restarts);
  fields("exit_code", s.exit_code);
  fields("reason", s.reason);
}

const char* name_of(TaskPhase phase)
{
  return phase_names.at(static_cast<std::size_t>(phase));
}

std::string utc_text(std::chrono::system_clock::time_point when)
{
  const std::time_t seconds = std::chrono::system_clock::to_time_t(when);
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

std::string utc_now()
{
  return utc_text(std::chrono::system_clock::now());
}

std::string host_name()
{
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

TaskState started_now(std::int64_t n_done)
{
  TaskState state;
  // Several Slurm nodes may share a machine, so the node's name is preferred.
  const std::string node = environment("SLURMD_NODENAME");
  state.host = node.empty() ? host_name() : node;
  state.started = utc_now();
  state.n_done_at_start = n_done;
  state.slurm_job = slurm_job();
  state.n_restarts = std::atoi(environment("SLURM_RESTART_COUNT").c_str());
  return state;
}

bool is_same_start(const TaskState& a, const TaskState& b)
{
  return a.slurm_job == b.slurm_job && a.n_restarts == b.n_restarts;
}

std::string task_file_of(const std::string& folder, const Submission& submission, const TaskId& task)
{
  return tasks_of(folder) + "/" + file_stem_of(task, submission) + ".json";
}

void write_task_state(const std::string& folder, const Submission& submission, const TaskId& task,
                      const TaskState& state)
{
  // A reason may contain invalid UTF-8.
  write_atomically(
      task_file_of(folder, submission, task),
      {nlohmann::ordered_json(state).dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace),
       "\n"});
}

std::optional<TaskState> read_task_state(const std::string& folder, const Submission& submission,
                                         const TaskId& task)
{
  try {
    return nlohmann::ordered_json::parse(read_text_file(task_file_of(folder, submission, task)).value_or(""))
        .get<TaskState>();
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

std::map<TaskId, TaskState> read_task_states(const std::string& folder, const Submission& submission)
{
  std::set<std::string> names;
  std::error_code error;
  for (std::filesystem::directory_iterator it(tasks_of(folder), error), end; !error && it != end;
       it.increment(error)) {
    names.insert(it->path().filename().string());
  }
  std::map<TaskId, TaskState> states;
  for (const TaskId& task : tasks_of(submission)) {
    if (names.count(file_stem_of(task, submission) + ".json") == 0) continue;
    if (auto state = read_task_state(folder, submission, task)) states.emplace(task, std::move(*state));
  }
  return states;
}

}  // namespace vrda::run
