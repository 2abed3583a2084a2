/// State file of each task of a submission, tasks/<case>.<kind>.json: phase, host, UTC times, reason of a
/// failure. It is replaced atomically, so that `vrda status` reads it at any time.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "run/slurm.hpp"
#include "run/submission.hpp"

namespace vrda::run {

/// Of a task, local or of Slurm. Its state file has `running`, `done`, `failed` or `interrupted`.
enum class TaskStatus { waiting, queued, running, done, failed, interrupted, lost };
inline constexpr Named<TaskStatus> task_status_names[] = {
    {TaskStatus::waiting, "waiting", "for other tasks, or not yet submitted"},
    {TaskStatus::queued, "queued", "in Slurm's queue"},
    {TaskStatus::running, "running"},
    {TaskStatus::done, "done", "its result exists"},
    {TaskStatus::failed, "failed", "ended without a result"},
    {TaskStatus::interrupted, "interrupted", "stopped cleanly before completion"},
    {TaskStatus::lost, "lost", "started, but no longer exists"}};
constexpr const auto& names_of(TaskStatus)
{
  return task_status_names;
}

struct TaskState {
  TaskStatus status = TaskStatus::running;
  std::string host;                  ///< node name for Slurm tasks
  std::string started;               ///< UTC, of the last start
  std::string ended;                 ///< UTC; empty while running
  std::int64_t n_done_at_start = 0;  ///< attitudes (spine: steps) in the journals when solving started
  std::string slurm_job;             ///< "13_3", or empty
  std::int32_t n_restarts = 0;       ///< by Slurm
  std::int32_t exit_code = 0;        ///< of the command; meaningful once ended
  std::string reason;                ///< one line: reason of failure or waiting
};
constexpr auto fields_of(const TaskState*)
{
  using S = TaskState;
  return std::tuple{Field{"state", &S::status},
                    Field{"host", &S::host},
                    Field{"begun", &S::started},
                    Field{"ended", &S::ended},
                    Field{"attitudes_at_begin", &S::n_done_at_start},
                    Field{"slurm_job", &S::slurm_job},
                    Field{"restarts", &S::n_restarts},
                    Field{"exit_code", &S::exit_code},
                    Field{"reason", &S::reason}};
}

/// "2026-03-01T10:00:00Z".
std::string utc_text(std::chrono::system_clock::time_point when);
std::string utc_now();
std::string host_name();

/// The state of a task that starts now in this process; Slurm's numbers are from the environment.
TaskState started_now(std::int64_t n_done);

/// Whether both belong to the same start; restarts of a Slurm job differ in n_restarts. Local tasks are
/// excluded by the lock of their state file (core/files.hpp), which each holds while it runs.
bool is_same_start(const TaskState& a, const TaskState& b);

std::string task_file_of(const std::string& folder, const Submission& submission, const TaskId& task);

/// Writes atomically (temporary name, rename). Throws InputError naming the file.
void write_task_state(const std::string& folder, const Submission& submission, const TaskId& task,
                      const TaskState& state);
/// Empty if the task never started, or if the file is damaged; the next start writes it again.
std::optional<TaskState> read_task_state(const std::string& folder, const Submission& submission,
                                         const TaskId& task);

/// The states of all tasks that have started; lists the folder once.
std::map<TaskId, TaskState> read_task_states(const std::string& folder, const Submission& submission);

// Status of a submission: counts solved attitudes in journals, and joins Slurm's queue with the state files
// of tasks. In: the submission's folder. Out: a status and a reason per task, and the tasks that remain. A
// missing journal counts as no solved attitude.

struct SolvedCount {
  std::int64_t n_done = 0;
  std::int64_t n_total = 0;  ///< 0: unknown
};

/// Counts journal records; the spine journal of a case is read once for all its shards.
class SolvedCounter {
 public:
  SolvedCounter(const std::string& folder, const Submission& submission)
      : folder_(folder), submission_(submission)
  {
  }

  /// Solved attitudes of the task's rows; for a spine with free varus its steps, with unknown total. Zero for
  /// merge and index, and for a missing journal.
  SolvedCount count(const TaskId& task);

  /// Attitudes that the task has to solve; 0 for spine, merge and index.
  std::int64_t total_of(const TaskId& task) const;

 private:
  using Cell = std::pair<std::int32_t, std::int32_t>;  // flexion, varus
  struct Content {
    std::set<Cell> cells;
    std::set<Cell> samples;  ///< flexion and number of a sample
    std::int64_t n_free_steps = 0;
  };

  static Content content_of(const std::string& journal);
  const Content& spine_of(const TaskId& task);

  const std::string& folder_;
  const Submission& submission_;
  std::int32_t spine_case_ = -1;  // case of spine_
  Content spine_;
};

/// The journals that a task appends to.
std::vector<std::string> journals_of(const std::string& folder, const Submission& submission,
                                     const TaskId& task);

struct TaskView {
  TaskId task;
  TaskStatus status = TaskStatus::waiting;
  std::string reason;     ///< of waiting or failure; one line, may be empty
  std::string host;       ///< host of the last start
  std::string slurm_job;  ///< "13_3", or empty
  std::int32_t n_restarts = 0;
  std::int64_t n_done = 0;           ///< solved attitudes of the task
  std::int64_t n_total = 0;          ///< 0: unknown
  std::optional<double> per_second;  ///< since the last start
  std::optional<double> seconds_left;
  bool is_job_running = false;  ///< Slurm still runs its job for other cases
};

struct CaseView {
  std::int32_t case_number = 0;
  TaskStatus status = TaskStatus::waiting;
  bool is_complete = false;     ///< the motion model exists and is cleaned up
  bool is_merged = false;       ///< the motion model exists, but clean-up is incomplete
  std::vector<TaskView> tasks;  ///< spine, shards, merge; or run
};

struct StatusView {
  std::vector<CaseView> cases;
  std::optional<TaskView> index;
  std::string remark;  ///< reason of a failed Slurm query; empty if none failed
};

/// State of a submission except journals.
struct SubmissionSnapshot {
  std::map<TaskId, TaskState> states;
  std::set<TaskId> locked;  ///< running local tasks, whose lock is held
  std::map<TaskId, SlurmTask> slurm;
  std::string remark;  ///< reason of a failed Slurm query
};

/// Reads the state of all tasks except journals; queries Slurm if jobs were submitted to it. Does not throw
/// when the query fails: `remark` then has the reason.
SubmissionSnapshot take_snapshot(const std::string& folder, const Submission& submission);

/// Reads journals only of started, unfinished tasks of incomplete cases.
StatusView status_of(const std::string& folder, const Submission& submission,
                     const SubmissionSnapshot& snapshot);

/// "5 of 8 shards done, 2 running, 1 queued; 1490 of 1911 attitudes, 38/s, 0:11 left"; cases for a campaign.
std::string summary_of(const StatusView& view, const Submission& submission);

/// "38/s, 0:11 left".
std::string rate_text(double per_second, std::optional<double> seconds_left);
/// "0:11", "2:05:30" or "3 days".
std::string duration_text(double seconds);

/// Remaining work of a submission.
struct MissingWork {
  Work work;
  std::vector<std::string> reasons;    ///< one line per task to repeat: name and reason
  std::vector<std::string> to_cancel;  ///< Slurm jobs that can never start, or would start too early
  std::int32_t n_active = 0;           ///< tasks queued or running in Slurm, which are not repeated
};

/// Reads the journals of finished tasks in incomplete cases: their content decides, not the task states. A
/// running local task counts as missing: its repetition waits for its lock and uses its results.
MissingWork find_missing_work(const std::string& folder, const Submission& submission,
                              const StatusView& status, const SubmissionSnapshot& snapshot);

}  // namespace vrda::run
