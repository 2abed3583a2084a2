#include "run/status.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>

#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/files.hpp"
#include "core/text.hpp"
#include "run/campaign.hpp"
#include "store/journal.hpp"

namespace vrda::run {
namespace {

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
  write_atomically(task_file_of(folder, submission, task), {core::json_text(state, 1), "\n"});
}

std::optional<TaskState> read_task_state(const std::string& folder, const Submission& submission,
                                         const TaskId& task)
{
  try {
    return core::json_in(read_text_file(task_file_of(folder, submission, task)).value_or(""))
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

namespace {

namespace fs = std::filesystem;

std::vector<std::int32_t> rows_of(const Submission& submission, const TaskId& task)
{
  return run::rows_of(store::Shard{task.shard, submission.n_shards}, case_of(submission, task).n_flexion);
}

// slurmstepd's last message in a log after it ended a task: time limit, memory, node failure.
std::string slurm_error_in(const std::string& log)
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

struct Standing {
  TaskStatus status;
  std::string reason = {};
};

/// Status of one task: from Slurm while it has the job, otherwise from the task's state file, verified with
/// its journal, its lock and Slurm.
class TaskAssessment {
 public:
  TaskAssessment(const std::string& folder, const Submission& submission, const SubmissionSnapshot& snapshot,
                 const TaskId& task)
      : folder_(folder), submission_(submission), snapshot_(snapshot), task_(task)
  {
    if (const auto state = snapshot.states.find(task); state != snapshot.states.end()) own_ = &state->second;
    if (const auto slurm = snapshot.slurm.find(task); slurm != snapshot.slurm.end()) queue_ = &slurm->second;
    is_of_job_ = own_ != nullptr && queue_ != nullptr && own_->slurm_job == queue_->job;
  }

  TaskView view() const
  {
    TaskView view;
    view.task = task_;
    if (own_ != nullptr) {
      view.host = own_->host;
      view.n_restarts = own_->n_restarts;
      view.slurm_job = own_->slurm_job;
    }
    if (queue_ == nullptr) return view;
    view.slurm_job = queue_->job;
    view.is_job_running = queue_->per_task > 1 && is_running(queue_->row);
    if (is_running(queue_->row) && !queue_->row.node.empty()) view.host = queue_->row.node;
    return view;
  }

  Standing standing() const
  {
    return queue_ != nullptr && !queue_->row.state.empty() ? by_queue(queue_->row) : by_state();
  }

  const TaskState* state() const { return own_; }

 private:
  bool has_own(TaskStatus phase) const { return is_of_job_ && own_->status == phase; }

  Standing by_queue(const SlurmRow& row) const
  {
    if (is_queued(row)) {
      const bool is_held = is_held_after_failed_launch(row);
      return {TaskStatus::queued, row.reason + (is_held ? "; vrda resume releases it" : "")};
    }
    if (has_own(TaskStatus::done)) return by_state();
    if (is_running(row)) return while_job_runs(row);
    // It was repeated locally since.
    if (own_ != nullptr && !is_of_job_ && own_->slurm_job.empty()) return by_state();
    if (has_own(TaskStatus::failed)) return {TaskStatus::failed, own_->reason};
    // Its state file may not be visible yet on a network file system.
    if (row.state == "COMPLETED") return when_done("");
    const bool has_failed_dependency = row.reason.find("Dependency") != std::string::npos;
    return {has_own(TaskStatus::interrupted) ? TaskStatus::interrupted : TaskStatus::failed,
            has_failed_dependency ? row.state + ": a job it depends on failed"
                                  : with_reason(row.state, row.reason)};
  }

  // An array task runs its cases sequentially and has one row for all of them.
  Standing while_job_runs(const SlurmRow& row) const
  {
    if (queue_->per_task > 1) {
      if (has_own(TaskStatus::failed)) return {TaskStatus::failed, own_->reason};
      if (!has_own(TaskStatus::running)) return {TaskStatus::queued, "waiting for other cases of its task"};
    }
    const bool has_started = own_ != nullptr && own_->status == TaskStatus::running;
    return {TaskStatus::running, row.state != "RUNNING" ? row.state : has_started ? own_->reason : ""};
  }

  Standing by_state() const
  {
    const bool is_of_earlier_job =
        own_ != nullptr && queue_ != nullptr && !is_of_job_ && !own_->slurm_job.empty();
    if (own_ == nullptr || is_of_earlier_job) {
      if (queue_ == nullptr) return {TaskStatus::waiting};
      if (!snapshot_.remark.empty()) return {TaskStatus::queued, "last known state"};
      return {TaskStatus::lost, "Slurm has no record of the job, and it never started"};
    }
    if (own_->status == TaskStatus::done) return when_done(own_->reason);
    if (own_->status != TaskStatus::running) return {own_->status, own_->reason};
    if (own_->slurm_job.empty()) {
      if (snapshot_.locked.count(task_) > 0) return {TaskStatus::running, own_->reason};
      return {TaskStatus::lost, "its process no longer exists"};
    }
    if (!snapshot_.remark.empty()) return {TaskStatus::running, "last known state"};
    const std::string message = queue_ == nullptr ? "" : slurm_error_in(logs_of(folder_) + "/" + queue_->log);
    return {TaskStatus::lost, message.empty() ? "Slurm has no record of the job" : message};
  }

  // Its result must still exist: a journal until it is merged.
  Standing when_done(const std::string& reason) const
  {
    const bool has_journal = task_.kind == TaskKind::spine || task_.kind == TaskKind::shard;
    std::error_code ignored;
    if (has_journal && !fs::exists(journals_of(folder_, submission_, task_).front(), ignored))
      return {TaskStatus::lost, "its journal is missing"};
    return {TaskStatus::done, reason};
  }

  const std::string& folder_;
  const Submission& submission_;
  const SubmissionSnapshot& snapshot_;
  const TaskId task_;
  const TaskState* own_ = nullptr;
  const SlurmTask* queue_ = nullptr;
  bool is_of_job_ = false;  // own_ belongs to the job in the queue
};

class Viewer {
 public:
  Viewer(const std::string& folder, const Submission& submission, const SubmissionSnapshot& snapshot)
      : folder_(folder), submission_(submission), snapshot_(snapshot), counter_(folder, submission)
  {
  }

  TaskView view(const TaskId& task, bool is_made)
  {
    const TaskAssessment assessment(folder_, submission_, snapshot_, task);
    const TaskState* own = assessment.state();
    TaskView view = assessment.view();
    const bool is_done = own != nullptr && own->status == TaskStatus::done;
    const Standing standing =
        is_made ? Standing{TaskStatus::done, is_done ? own->reason : ""} : assessment.standing();
    view.status = standing.status;
    view.reason = standing.reason;
    count(view, own);
    return view;
  }

 private:
  void count(TaskView& view, const TaskState* own)
  {
    view.n_total = counter_.total_of(view.task);
    if (view.status == TaskStatus::done) {
      view.n_done = view.n_total;
    } else if (view.status == TaskStatus::running) {
      const SolvedCount solved = counter_.count(view.task);
      view.n_done = solved.n_done;
      view.n_total = solved.n_total;
      if (own != nullptr && own->status == TaskStatus::running) measure(view, *own);
    } else if (own != nullptr) {
      view.n_done = counter_.count(view.task).n_done;
    }
  }

  // Rate since the last start, from the modification times of the state (written when solving starts) and of
  // the journal. Both are times of the same file server, so differences between clocks do not matter.
  void measure(TaskView& view, const TaskState& own) const
  {
    const std::int64_t n_new = view.n_done - own.n_done_at_start;
    const std::vector<std::string> journals = journals_of(folder_, submission_, view.task);
    if (n_new <= 0 || journals.empty()) return;
    std::error_code no_state, no_journal;
    const auto begun = fs::last_write_time(task_file_of(folder_, submission_, view.task), no_state);
    const auto latest = fs::last_write_time(journals.front(), no_journal);
    if (no_state || no_journal) return;
    const double seconds = std::chrono::duration<double>(latest - begun).count();
    constexpr double shortest_s = 0.1;
    if (seconds < shortest_s) return;
    view.per_second = static_cast<double>(n_new) / seconds;
    if (view.n_total > 0)
      view.seconds_left = static_cast<double>(view.n_total - view.n_done) / *view.per_second;
  }

  const std::string& folder_;
  const Submission& submission_;
  const SubmissionSnapshot& snapshot_;
  SolvedCounter counter_;
};

TaskStatus standing_of(const std::vector<TaskView>& tasks)
{
  for (const TaskStatus standing : {TaskStatus::failed, TaskStatus::lost, TaskStatus::running,
                                    TaskStatus::interrupted, TaskStatus::queued}) {
    for (const TaskView& task : tasks) {
      if (task.status == standing) return standing;
    }
  }
  return TaskStatus::waiting;
}

// "2 running, 1 queued", non-zero counts only.
std::string counts_text(const std::vector<TaskStatus>& standings)
{
  std::string text;
  for (const TaskStatus standing : {TaskStatus::running, TaskStatus::queued, TaskStatus::waiting,
                                    TaskStatus::failed, TaskStatus::interrupted, TaskStatus::lost}) {
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
  return text + ", " + rate_text(per_second, static_cast<double>(n_total - n_done) / per_second);
}

}  // namespace

SubmissionSnapshot take_snapshot(const std::string& folder, const Submission& submission)
{
  SubmissionSnapshot snapshot;
  const std::vector<SubmittedJob> jobs = read_submitted(folder);
  std::vector<std::string> ids;
  for (const SubmittedJob& job : jobs) ids.push_back(job.id);
  const QueueResult queue = query_queue(ids);
  if (queue.error) snapshot.remark = InputError(*queue.error).what();
  // Read after the queue, so that a task that ends meanwhile has its final state.
  snapshot.states = read_task_states(folder, submission);
  snapshot.slurm = tasks_in_slurm(submission, jobs, queue.rows);
  for (auto& [task, state] : snapshot.states) {
    if (state.status != TaskStatus::running || !state.slurm_job.empty()) continue;
    if (OutputLock::is_held(task_file_of(folder, submission, task))) {
      snapshot.locked.insert(task);
    } else {
      state = read_task_state(folder, submission, task).value_or(state);  // it may have ended meanwhile
    }
  }
  return snapshot;
}

StatusView status_of(const std::string& folder, const Submission& submission,
                     const SubmissionSnapshot& snapshot)
{
  StatusView status;
  status.remark = snapshot.remark;
  Viewer viewer(folder, submission, snapshot);
  for (std::int32_t k = 0; k < std::ssize(submission.cases); ++k) {
    CaseView view;
    view.case_number = k;
    const SubmittedCase& submitted = submission.cases[static_cast<std::size_t>(k)];
    view.is_complete = is_case_complete(folder, submitted);
    view.is_merged =
        !view.is_complete && submission.n_shards > 1 && is_cleanup_pending(output_of(folder, submitted));
    for (const TaskId& task : tasks_of_case(submission, k)) {
      const bool is_done = view.is_complete || (view.is_merged && task.kind != TaskKind::merge);
      view.tasks.push_back(viewer.view(task, is_done));
    }
    view.status = view.is_complete ? TaskStatus::done : standing_of(view.tasks);
    status.cases.push_back(std::move(view));
  }
  if (submission.has_index()) status.index = viewer.view({TaskKind::index, -1, 0}, false);
  return status;
}

std::string summary_of(const StatusView& view, const Submission& submission)
{
  std::vector<TaskStatus> standings;
  const bool is_campaign = submission.has_index();
  for (const CaseView& c : view.cases) {
    if (is_campaign) {
      standings.push_back(c.status);
      continue;
    }
    for (const TaskView& task : c.tasks) {
      if (task.task.kind == TaskKind::shard || task.task.kind == TaskKind::run)
        standings.push_back(task.status);
    }
  }
  const auto n_done = std::count(standings.begin(), standings.end(), TaskStatus::done);
  const char* what = is_campaign ? " cases" : submission.n_shards > 1 ? " shards" : " runs";
  return std::to_string(n_done) + " of " + std::to_string(standings.size()) + what + " done" +
         counts_text(standings) + "; " + attitudes_text(view);
}

std::string rate_text(double per_second, std::optional<double> seconds_left)
{
  return printed(per_second < 10.0 ? "%.2g/s" : "%.0f/s", per_second) +
         (seconds_left ? ", " + duration_text(*seconds_left) + " left" : "");
}

std::string duration_text(double seconds)
{
  constexpr double longest_s = 100.0 * 86400.0;
  if (!(seconds < longest_s)) return "over 100 days";
  const auto whole = static_cast<std::int64_t>(std::llround(seconds));
  const auto hours = static_cast<int>(whole / 3600), minutes = static_cast<int>(whole / 60 % 60),
             rest = static_cast<int>(whole % 60);
  if (hours >= 48) return std::to_string(hours / 24) + " days";
  return hours > 0 ? printed("%d:%02d:%02d", hours, minutes, rest) : printed("%d:%02d", minutes, rest);
}

std::vector<std::string> journals_of(const std::string& folder, const Submission& submission,
                                     const TaskId& task)
{
  if (task.case_number < 0) return {};
  const std::string output = output_of(folder, case_of(submission, task));
  if (task.kind == TaskKind::spine) return {store::spine_journal_of(output)};
  if (task.kind == TaskKind::run) return {store::journal_of(output)};
  if (task.kind != TaskKind::shard) return {};
  return {store::shard_journal_of(output, {task.shard, submission.n_shards}),
          store::spine_journal_of(output)};
}

SolvedCounter::Content SolvedCounter::content_of(const std::string& journal)
{
  // Valid records before damage count; the task that resumes the journal reports the damage.
  Content content;
  core::FrameTail tail = store::journal_tail(journal);
  for (bool has_more = true; has_more;) {
    const core::TailUpdate news = tail.poll();
    has_more = news.has_more;
    for (const std::string& frame : news.frames) {
      const std::optional<StepRecord> record = core::value_of_bytes<StepRecord>(frame);
      if (!record) return content;
      const StepKey& key = record->key;
      if (key.kind == StepKind::spine || key.kind == StepKind::row)
        content.cells.insert({key.flexion, key.varus});
      if (key.kind == StepKind::sample) content.samples.insert({key.flexion, key.varus});
      if (key.kind == StepKind::free_spine) ++content.n_free_steps;
    }
  }
  return content;
}

const SolvedCounter::Content& SolvedCounter::spine_of(const TaskId& task)
{
  if (spine_case_ != task.case_number) {
    spine_ = content_of(store::spine_journal_of(output_of(folder_, case_of(submission_, task))));
    spine_case_ = task.case_number;
  }
  return spine_;
}

std::int64_t SolvedCounter::total_of(const TaskId& task) const
{
  if (task.kind != TaskKind::run && task.kind != TaskKind::shard) return 0;
  const SubmittedCase& c = case_of(submission_, task);
  if (task.kind == TaskKind::run) return std::int64_t{c.n_flexion} * (c.n_varus + c.n_samples);
  const std::size_t n_samples =
      run::rows_of(store::Shard{task.shard, submission_.n_shards}, c.n_samples).size();
  return static_cast<std::int64_t>(rows_of(submission_, task).size()) * c.n_varus +
         static_cast<std::int64_t>(n_samples) * c.n_flexion;
}

SolvedCount SolvedCounter::count(const TaskId& task)
{
  if (task.kind == TaskKind::merge || task.kind == TaskKind::index) return {};
  const Content content = content_of(journals_of(folder_, submission_, task).front());
  const auto n_cells = static_cast<std::int64_t>(content.cells.size());
  const auto n_sampled = static_cast<std::int64_t>(content.samples.size());
  if (task.kind == TaskKind::run) return {n_cells + n_sampled, total_of(task)};
  if (task.kind == TaskKind::spine) {
    if (content.n_free_steps > 0) return {content.n_free_steps, 0};
    return {n_cells, case_of(submission_, task).n_flexion};
  }
  std::set<Cell> cells = content.cells;
  const std::set<Cell>& spine = spine_of(task).cells;
  cells.insert(spine.begin(), spine.end());
  const std::vector<std::int32_t> rows = rows_of(submission_, task);
  const auto n_done = std::count_if(cells.begin(), cells.end(), [&](const Cell& cell) {
    return std::binary_search(rows.begin(), rows.end(), cell.first);
  });
  return {n_done + n_sampled, total_of(task)};
}

}  // namespace vrda::run
