#include "cluster/task_state.hpp"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "core/whole_file.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::array<const char*, 4> phase_names{"running", "done", "failed", "interrupted"};

// When a process started, by the 22nd word of its stat; the second one may hold spaces and ends with ')'.
// Nothing of one that has ended, though nobody took notice yet.
std::optional<std::uint64_t> start_of(std::int64_t pid)
{
  const std::string stat = text_of_file("/proc/" + std::to_string(pid) + "/stat").value_or("");
  const std::size_t end = stat.rfind(')');
  if (end == std::string::npos) return std::nullopt;
  std::istringstream words(stat.substr(end + 1));
  std::string word;
  if (!(words >> word) || word == "Z" || word == "X") return std::nullopt;
  constexpr int words_between = 18;  // the fourth to the 21st
  for (int k = 0; k < words_between; ++k) words >> word;
  std::uint64_t started = 0;
  if (!(words >> started)) return std::nullopt;
  return started;
}

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

Json json_of(const TaskState& s)
{
  return {{"state", name_of(s.phase)},
          {"host", s.process.host},
          {"pid", s.process.pid},
          {"pid_started", s.process.started},
          {"begun", s.begun},
          {"ended", s.ended},
          {"boot", s.begun_at.boot},
          {"boot_seconds", s.begun_at.seconds},
          {"attitudes_at_begin", s.n_done_at_begin},
          {"attitudes_at_end", s.n_done_at_end},
          {"slurm_job", s.slurm_job},
          {"restarts", s.n_restarts},
          {"exit_code", s.phase == TaskPhase::running ? Json() : Json(s.exit_code)},
          {"reason", s.reason}};
}

std::optional<TaskState> state_of(const std::string& text)
{
  try {
    const Json json = Json::parse(text);
    TaskState s;
    const std::string phase = json.at("state");
    std::size_t k = 0;
    while (k < phase_names.size() && phase != phase_names[k]) ++k;
    if (k == phase_names.size()) return std::nullopt;
    s.phase = static_cast<TaskPhase>(k);
    s.process = {json.at("host"), json.at("pid"), json.at("pid_started")};
    s.begun = json.at("begun");
    s.ended = json.at("ended");
    s.begun_at = {json.at("boot"), json.at("boot_seconds")};
    s.n_done_at_begin = json.at("attitudes_at_begin");
    s.n_done_at_end = json.at("attitudes_at_end");
    s.slurm_job = json.at("slurm_job");
    s.n_restarts = json.at("restarts");
    s.exit_code = json.at("exit_code").is_null() ? 0 : json.at("exit_code").get<std::int32_t>();
    s.reason = json.at("reason");
    return s;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

std::vector<TaskId> tasks_of_case(std::int32_t number, std::int32_t n_shards)
{
  std::vector<TaskId> tasks{
      {TaskKind::spine, number, 0}, {TaskKind::merge, number, 0}, {TaskKind::run, number, 0}};
  for (std::int32_t k = 1; k <= n_shards; ++k) tasks.push_back({TaskKind::shard, number, k});
  return tasks;
}

}  // namespace

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

std::string host_name()
{
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "";
}

Moment now()
{
  Moment moment;
  std::istringstream(text_of_file("/proc/sys/kernel/random/boot_id").value_or("")) >> moment.boot;
  timespec t{};
  clock_gettime(CLOCK_BOOTTIME, &t);
  moment.seconds = static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  return moment;
}

std::optional<double> seconds_between(const Moment& begin, const Moment& end)
{
  if (begin.boot.empty() || begin.boot != end.boot || end.seconds < begin.seconds) return std::nullopt;
  return end.seconds - begin.seconds;
}

ProcessId own_process()
{
  return {host_name(), getpid(), start_of(getpid()).value_or(0)};
}

std::optional<bool> is_alive(const ProcessId& process)
{
  if (process.host != host_name()) return std::nullopt;
  return process.pid > 0 && start_of(process.pid) == process.started;
}

TaskState begun_now(std::int64_t n_done)
{
  TaskState state;
  state.process = own_process();
  // Of several nodes on one machine the name of the node says more.
  if (const std::string node = environment("SLURMD_NODENAME"); !node.empty()) state.process.host = node;
  state.begun = utc_text(std::chrono::system_clock::now());
  state.begun_at = now();
  state.n_done_at_begin = n_done;
  state.slurm_job = slurm_job();
  state.n_restarts = std::atoi(environment("SLURM_RESTART_COUNT").c_str());
  return state;
}

std::string task_file_of(const std::string& folder, const Submission& submission, const TaskId& task)
{
  return (fs::path(tasks_of(folder)) / (file_stem_of(task, submission) + ".json")).string();
}

void write_task_state(const std::string& folder, const Submission& submission, const TaskId& task,
                      const TaskState& state)
{
  // A reason may quote any bytes.
  write_whole(task_file_of(folder, submission, task),
              {json_of(state).dump(1, ' ', false, Json::error_handler_t::replace), "\n"});
}

std::optional<TaskState> read_task_state(const std::string& folder, const Submission& submission,
                                         const TaskId& task)
{
  const std::string text = text_of_file(task_file_of(folder, submission, task)).value_or("");
  return text.empty() ? std::nullopt : state_of(text);
}

std::map<TaskId, TaskState> read_task_states(const std::string& folder, const Submission& submission)
{
  std::set<std::string> names;
  std::error_code error;
  for (fs::directory_iterator it(tasks_of(folder), error), end; !error && it != end; it.increment(error)) {
    names.insert(it->path().filename().string());
  }
  std::map<TaskId, TaskState> states;
  const auto look = [&](const TaskId& task) {
    if (names.count(file_stem_of(task, submission) + ".json") == 0) return;
    if (auto state = read_task_state(folder, submission, task)) states.emplace(task, std::move(*state));
  };
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(submission.cases.size()); ++k) {
    for (const TaskId& task : tasks_of_case(k, submission.n_shards)) look(task);
  }
  look({TaskKind::index, -1, 0});
  return states;
}

}  // namespace vrda
