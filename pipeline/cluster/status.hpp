/// How far a submission is: each task from its journals, Slurm's queue, and what it said of itself last; and
/// what it still needs.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "cluster/jobs.hpp"
#include "cluster/slurm.hpp"
#include "cluster/submission.hpp"
#include "cluster/task_state.hpp"

namespace vrda {

struct SolvedCount {
  std::int64_t n_done = 0;
  std::int64_t n_total = 0;  ///< 0: not known beforehand
};

/// Reads journals, that of a case's spine once for all of its shards.
class SolvedCounter {
 public:
  SolvedCounter(const std::string& folder, const Submission& submission)
      : folder_(folder), submission_(submission)
  {
  }

  /// Attitudes of the task's own rows that are solved; of a spine with varus left free its steps, which have
  /// no known total. Merge and index have none. A journal that is not there or damaged counts nothing.
  SolvedCount count(const TaskId& task);

  /// Attitudes that the task has to solve; 0 for spine, merge and index.
  std::int64_t total_of(const TaskId& task) const;

 private:
  using Cell = std::pair<std::int32_t, std::int32_t>;  // flexion, varus
  struct Content {
    std::set<Cell> cells;
    std::int64_t n_free_steps = 0;
  };

  static Content content_of(const std::string& journal);
  const Content& spine_of(const TaskId& task);

  const std::string& folder_;
  const Submission& submission_;
  std::int32_t spine_case_ = -1;  // whose spine stands in spine_
  Content spine_;
};

/// The journals that a task appends to.
std::vector<std::string> journals_of(const std::string& folder, const Submission& submission,
                                     const TaskId& task);

enum class TaskStanding {
  waiting,      ///< for other tasks, or for somebody to submit it
  queued,       ///< by Slurm
  running,      ///< begun and under way
  done,         ///< its result stands
  failed,       ///< ended without one
  interrupted,  ///< ended in good order before its end
  lost,         ///< began and is no longer there
};

const char* name_of(TaskStanding standing);

struct TaskView {
  TaskId task;
  TaskStanding standing = TaskStanding::waiting;
  std::string reason;     ///< why it waits or failed; one line, may be empty
  std::string host;       ///< where it runs or ran
  std::string slurm_job;  ///< "13_3", or empty
  std::int32_t n_restarts = 0;
  std::int64_t n_done = 0;           ///< attitudes of its own that are solved
  std::int64_t n_total = 0;          ///< 0: not known
  std::optional<double> per_second;  ///< since this start
  std::optional<double> seconds_left;
  bool is_job_running = false;  ///< Slurm still runs the job that made it and makes other cases after it
};

struct CaseView {
  std::int32_t case_number = 0;
  TaskStanding standing = TaskStanding::waiting;
  bool is_made = false;         ///< the motion model stands
  bool is_merged = false;       ///< so it does, but what it was made of is not all cleared up
  std::vector<TaskView> tasks;  ///< spine, shards, merge; or run
};

struct StatusView {
  std::vector<CaseView> cases;
  std::optional<TaskView> index;
  std::string remark;  ///< why Slurm could not be asked; empty when it was, or need not be
};

/// What there is to know besides the journals.
struct SubmissionSnapshot {
  std::map<TaskId, TaskState> states;
  std::set<TaskId> locked;  ///< local tasks that run: their lock is held
  std::map<TaskId, SlurmTask> slurm;
  std::string remark;  ///< why Slurm could not be asked
};

/// Everything read but the journals; asks Slurm when anything was submitted to it. Does not throw when Slurm
/// does not answer: `remark` says why then.
SubmissionSnapshot take_snapshot(const std::string& folder, const Submission& submission);

/// Reads journals only of tasks that began and have not ended well, of cases that are not made.
StatusView status_of(const std::string& folder, const Submission& submission, const SubmissionSnapshot& seen);

/// "5 of 8 shards done, 2 running, 1 queued; 1490 of 1911 attitudes, 38/s, 0:11 left"; of a campaign its
/// cases.
std::string summary_of(const StatusView& view, const Submission& submission);

/// "38/s, 0:11 left".
std::string rate_text(double per_second, std::optional<double> seconds_left);
/// "0:11", "2:05:30" or "3 days".
std::string duration_text(double seconds);

/// What a submission still needs.
struct Missing {
  Work work;
  std::vector<std::string> reasons;    ///< one line a task that is to be done again: which and why
  std::vector<std::string> to_cancel;  ///< Slurm's jobs that can no longer begin, or begin too early
  std::int32_t n_under_way = 0;        ///< tasks that Slurm has queued or runs, which are left alone
};

/// Reads the journals of the tasks that ended well in cases that are not made: what they hold counts, not
/// what was said of them. A local task that still runs is missing, too: whoever repeats it waits for its
/// lock, and finds what it did.
Missing missing_of(const std::string& folder, const Submission& submission, const StatusView& status,
                   const SubmissionSnapshot& seen);

}  // namespace vrda
