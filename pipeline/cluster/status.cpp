#include "cluster/status.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "cluster/case_spec.hpp"
#include "cluster/solved_count.hpp"
#include "core/error.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;

constexpr std::array<const char*, 7> standing_names{"waiting", "queued",      "running", "done",
                                                    "failed",  "interrupted", "lost"};

// What slurmstepd left at the end of a log when it ended a task: the time limit, memory, a node.
std::string last_word_of_slurm(const std::string& log)
{
  std::ifstream file(log, std::ios::binary | std::ios::ate);
  if (!file) return {};
  constexpr std::streamoff tail = 4096;
  file.seekg(std::max<std::streamoff>(0, file.tellg() - tail));
  std::string found;
  for (std::string line; std::getline(file, line);) {
    constexpr std::string_view mark = "slurmstepd: error: ";
    if (const std::size_t at = line.find(mark); at != std::string::npos)
      found = line.substr(at + mark.size());
  }
  return found;
}

std::string with_reason(const std::string& what, const std::string& reason)
{
  return reason.empty() || reason == "None" || reason == what ? what : what + " (" + reason + ")";
}

class Viewer {
 public:
  Viewer(const std::string& folder, const Submission& submission, const Sightings& seen)
      : folder_(folder), submission_(submission), seen_(seen), counter_(folder, submission)
  {
  }

  TaskView view(const TaskId& task, bool is_made)
  {
    TaskView view;
    view.task = task;
    const auto state = seen_.states.find(task);
    const auto slurm = seen_.slurm.find(task);
    const TaskState* own = state == seen_.states.end() ? nullptr : &state->second;
    const SlurmTask* queue = slurm == seen_.slurm.end() ? nullptr : &slurm->second;
    if (own != nullptr) {
      view.host = own->process.host;
      view.n_restarts = own->n_restarts;
      view.slurm_job = own->slurm_job;
    }
    if (queue != nullptr) view.slurm_job = queue->job;
    if (is_made) {
      view.standing = TaskStanding::done;
      if (own != nullptr && own->phase == TaskPhase::done) view.reason = own->reason;
    } else if (queue != nullptr && !queue->row.state.empty()) {
      stand_by_queue(view, own, *queue);
    } else {
      stand_by_state(view, own, queue);
    }
    count(view, own);
    return view;
  }

 private:
  static void set(TaskView& view, TaskStanding standing, const std::string& reason = {})
  {
    view.standing = standing;
    view.reason = reason;
  }

  void stand_by_queue(TaskView& view, const TaskState* own, const SlurmTask& queue)
  {
    const SlurmRow& row = queue.row;
    const bool is_of_this_job = own != nullptr && own->slurm_job == queue.job;
    const std::string hint = is_held_after_failed_launch(row) ? "; vrda resume releases it" : "";
    if (is_queued(row)) return set(view, TaskStanding::queued, row.reason + hint);
    view.is_job_running = queue.per_task > 1 && is_running(row);
    if (is_of_this_job && own->phase == TaskPhase::done) return stand_by_state(view, own, &queue);
    if (view.is_job_running) return stand_among_cases(view, is_of_this_job ? own : nullptr, row);
    if (is_running(row)) {
      if (!row.node.empty()) view.host = row.node;
      return set(view, TaskStanding::running, row.state == "RUNNING" ? what_it_waits_for(own) : row.state);
    }
    // It was done again elsewhere since.
    if (own != nullptr && !is_of_this_job && own->slurm_job.empty()) return stand_by_state(view, own, &queue);
    if (is_of_this_job && own->phase == TaskPhase::failed)
      return set(view, TaskStanding::failed, own->reason);
    // Its state may not be seen yet over a network.
    if (row.state == "COMPLETED") return stand_when_done(view, "");
    const bool never_can_begin = row.reason.find("Dependency") != std::string::npos;
    const std::string why = never_can_begin ? row.state + ": what it waited for did not end well"
                                            : with_reason(row.state, row.reason);
    const bool is_in_order = is_of_this_job && own->phase == TaskPhase::interrupted;
    set(view, is_in_order ? TaskStanding::interrupted : TaskStanding::failed, why);
  }

  // The row is of the whole task, which makes its cases one after the other.
  static void stand_among_cases(TaskView& view, const TaskState* own, const SlurmRow& row)
  {
    if (own != nullptr && own->phase == TaskPhase::failed)
      return set(view, TaskStanding::failed, own->reason);
    if (own == nullptr || own->phase != TaskPhase::running)
      return set(view, TaskStanding::queued, "behind other cases of its task");
    if (!row.node.empty()) view.host = row.node;
    set(view, TaskStanding::running, row.state == "RUNNING" ? own->reason : row.state);
  }

  void stand_by_state(TaskView& view, const TaskState* own, const SlurmTask* queue)
  {
    if (own == nullptr || (queue != nullptr && own->slurm_job != queue->job && !own->slurm_job.empty())) {
      if (queue == nullptr) return;
      return seen_.is_slurm_known
                 ? set(view, TaskStanding::lost, "Slurm no longer knows the job, and it never began")
                 : set(view, TaskStanding::queued, "as far as is known");
    }
    switch (own->phase) {
      case TaskPhase::done:
        return stand_when_done(view, own->reason);
      case TaskPhase::failed:
        return set(view, TaskStanding::failed, own->reason);
      case TaskPhase::interrupted:
        return set(view, TaskStanding::interrupted, own->reason);
      case TaskPhase::running:
        break;
    }
    stand_while_running(view, *own, queue);
  }

  static std::string what_it_waits_for(const TaskState* own)
  {
    return own != nullptr && own->phase == TaskPhase::running ? own->reason : std::string();
  }

  // Its result must still be there: a journal until it is merged.
  void stand_when_done(TaskView& view, const std::string& reason)
  {
    const bool has_journal = view.task.kind == TaskKind::spine || view.task.kind == TaskKind::shard;
    std::error_code ignored;
    if (has_journal && !fs::exists(journals_of(folder_, submission_, view.task).front(), ignored)) {
      return set(view, TaskStanding::lost, "its journal is gone");
    }
    set(view, TaskStanding::done, reason);
  }

  void stand_while_running(TaskView& view, const TaskState& own, const SlurmTask* queue)
  {
    if (!own.slurm_job.empty()) {
      if (!seen_.is_slurm_known) return set(view, TaskStanding::running, "as far as is known");
      const std::string said =
          queue == nullptr ? "" : last_word_of_slurm((fs::path(logs_of(folder_)) / queue->log).string());
      return set(view, TaskStanding::lost, said.empty() ? "Slurm no longer knows the job" : said);
    }
    const std::optional<bool> lives = is_alive(own.process);
    if (!lives) return stand_elsewhere(view, own.process.host);
    if (*lives) return set(view, TaskStanding::running, own.reason);
    set(view, TaskStanding::lost, "process " + std::to_string(own.process.pid) + " is gone");
  }

  void stand_elsewhere(TaskView& view, const std::string& host)
  {
    if (seen_.absent_hosts.count(host) > 0) return set(view, TaskStanding::lost, host + " is gone with it");
    view.is_elsewhere = true;
    set(view, TaskStanding::running, "on " + host + ", which cannot be asked from here");
  }

  void count(TaskView& view, const TaskState* own)
  {
    view.n_total = counter_.total_of(view.task);
    if (view.standing == TaskStanding::done) {
      view.n_done = view.n_total;
    } else if (view.standing == TaskStanding::running) {
      const SolvedCount solved = counter_.count(view.task);
      view.n_done = solved.n_done;
      view.n_total = solved.n_total;
      if (own != nullptr && own->phase == TaskPhase::running) measure(view, *own);
    } else if (own != nullptr) {
      view.n_done = counter_.count(view.task).n_done;
    }
  }

  // From the last start on. A clock set anew, or two that differ, must not tell of years.
  void measure(TaskView& view, const TaskState& own)
  {
    const std::int64_t n_new = view.n_done - own.n_done_at_begin;
    const std::optional<double> seconds = seconds_since(view.task, own);
    constexpr double shortest_s = 0.1;
    if (n_new <= 0 || !seconds || *seconds < shortest_s) return;
    view.per_second = static_cast<double>(n_new) / *seconds;
    if (view.n_total > 0) {
      view.seconds_left = static_cast<double>(view.n_total - view.n_done) / *view.per_second;
    }
  }

  // On another machine: between the last writes of the state, at its begin, and of the journal, which one
  // clock stamped.
  std::optional<double> seconds_since(const TaskId& task, const TaskState& own) const
  {
    if (const auto seconds = seconds_between(own.begun_at, now())) return seconds;
    std::error_code error;
    const auto begun = fs::last_write_time(task_file_of(folder_, submission_, task), error);
    if (error) return std::nullopt;
    const auto latest = fs::last_write_time(journals_of(folder_, submission_, task).front(), error);
    if (error || latest <= begun) return std::nullopt;
    return std::chrono::duration<double>(latest - begun).count();
  }

  const std::string& folder_;
  const Submission& submission_;
  const Sightings& seen_;
  SolvedCounter counter_;
};

bool is_merged(const std::string& output)
{
  try {
    return is_only_to_clear_up(output);
  } catch (const InputError&) {
    return false;  // the merge says what is wrong
  }
}

TaskStanding standing_of(const std::vector<TaskView>& tasks)
{
  for (const TaskStanding standing : {TaskStanding::failed, TaskStanding::lost, TaskStanding::running,
                                      TaskStanding::interrupted, TaskStanding::queued}) {
    for (const TaskView& task : tasks) {
      if (task.standing == standing) return standing;
    }
  }
  return TaskStanding::waiting;
}

// "2 running, 1 queued", of those there are.
std::string counts_text(const std::vector<TaskStanding>& standings)
{
  std::string text;
  for (const TaskStanding standing : {TaskStanding::running, TaskStanding::queued, TaskStanding::waiting,
                                      TaskStanding::failed, TaskStanding::interrupted, TaskStanding::lost}) {
    const auto n = std::count(standings.begin(), standings.end(), standing);
    if (n > 0) text += ", " + std::to_string(n) + " " + name_of(standing);
  }
  return text;
}

std::string attitudes_text(const StatusView& view)
{
  std::int64_t n_done = 0, n_total = 0;
  double per_second = 0.0;
  for (const CaseView& c : view.cases) {
    for (const TaskView& task : c.tasks) {
      if (task.task.kind != TaskKind::shard && task.task.kind != TaskKind::run) continue;
      n_done += task.n_done;
      n_total += task.n_total;
      per_second += task.per_second.value_or(0.0);
    }
  }
  std::string text = std::to_string(n_done) + " of " + std::to_string(n_total) + " attitudes";
  if (per_second <= 0.0 || n_done >= n_total) return text;
  std::array<char, 32> rate{};
  std::snprintf(rate.data(), rate.size(), per_second < 10.0 ? "%.2g" : "%.0f", per_second);
  return text + ", " + rate.data() + "/s, " +
         duration_text(static_cast<double>(n_total - n_done) / per_second) + " left";
}

}  // namespace

const char* name_of(TaskStanding standing)
{
  return standing_names.at(static_cast<std::size_t>(standing));
}

Sightings look_around(const std::string& folder, const Submission& submission, std::string& remark)
{
  Sightings seen;
  const std::vector<SubmittedJob> jobs = read_submitted(folder);
  std::vector<SlurmRow> rows;
  if (!jobs.empty()) {
    std::vector<std::string> ids;
    ids.reserve(jobs.size());
    for (const SubmittedJob& job : jobs) ids.push_back(job.id);
    try {
      rows = ask_rows(ids);
    } catch (const InputError& error) {
      remark = error.what();
      seen.is_slurm_known = false;
    }
  }
  // After the queue: a task that ends meanwhile has its state then.
  seen.states = read_task_states(folder, submission);
  seen.slurm = tasks_in_slurm(submission, jobs, rows);
  return seen;
}

StatusView status_of(const std::string& folder, const Submission& submission, const Sightings& seen)
{
  StatusView status;
  Viewer viewer(folder, submission, seen);
  for (std::int32_t k = 0; k < static_cast<std::int32_t>(submission.cases.size()); ++k) {
    CaseView view;
    view.case_number = k;
    const SubmittedCase& submitted = submission.cases[static_cast<std::size_t>(k)];
    view.is_made = is_made(folder, submitted);
    if (submission.n_shards == 1) {
      view.tasks.push_back(viewer.view({TaskKind::run, k, 0}, view.is_made));
    } else {
      view.is_merged = !view.is_made && is_merged(output_of(folder, submitted));
      const bool is_solved = view.is_made || view.is_merged;
      view.tasks.push_back(viewer.view({TaskKind::spine, k, 0}, is_solved));
      for (std::int32_t s = 1; s <= submission.n_shards; ++s) {
        view.tasks.push_back(viewer.view({TaskKind::shard, k, s}, is_solved));
      }
      view.tasks.push_back(viewer.view({TaskKind::merge, k, 0}, view.is_made));
    }
    view.standing = view.is_made ? TaskStanding::done : standing_of(view.tasks);
    status.cases.push_back(std::move(view));
  }
  if (submission.has_index()) status.index = viewer.view({TaskKind::index, -1, 0}, false);
  return status;
}

std::string summary_of(const StatusView& view, const Submission& submission)
{
  std::vector<TaskStanding> standings;
  const bool is_campaign = submission.has_index();
  for (const CaseView& c : view.cases) {
    if (is_campaign) {
      standings.push_back(c.standing);
      continue;
    }
    for (const TaskView& task : c.tasks) {
      if (task.task.kind == TaskKind::shard || task.task.kind == TaskKind::run)
        standings.push_back(task.standing);
    }
  }
  const auto n_done = std::count(standings.begin(), standings.end(), TaskStanding::done);
  const char* what = is_campaign ? " cases" : submission.n_shards > 1 ? " shards" : " runs";
  return std::to_string(n_done) + " of " + std::to_string(standings.size()) + what + " done" +
         counts_text(standings) + "; " + attitudes_text(view);
}

std::string duration_text(double seconds)
{
  constexpr double longest_s = 100.0 * 86400.0;
  if (!(seconds < longest_s)) return "over 100 days";
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  std::array<char, 64> text{};
  const auto hours = static_cast<int>(whole / 3600), minutes = static_cast<int>(whole / 60 % 60),
             rest = static_cast<int>(whole % 60);
  if (hours >= 48) return std::to_string(hours / 24) + " days";
  if (hours > 0) {
    std::snprintf(text.data(), text.size(), "%d:%02d:%02d", hours, minutes, rest);
  } else {
    std::snprintf(text.data(), text.size(), "%d:%02d", minutes, rest);
  }
  return text.data();
}

}  // namespace vrda
