// Which tasks of a submission have no result yet, from journals and outputs (status.hpp).
#include "run/status.hpp"

#include <algorithm>

namespace vrda::run {
namespace {

void add_once(std::vector<std::string>& ids, const std::string& id)
{
  if (!id.empty() && std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
}

const char* problem_of(const TaskView& view)
{
  if (view.status != TaskStatus::done) return name_of(view.status);
  switch (view.task.kind) {
    case TaskKind::spine:
    case TaskKind::shard:
      return "its journal is incomplete";
    case TaskKind::merge:
    case TaskKind::run:
      return "its model is missing, or its clean-up is incomplete";
    case TaskKind::index:
      break;
  }
  return "done, but older than its cases";
}

class Search {
 public:
  Search(const std::string& folder, const Submission& submission, const SubmissionSnapshot& snapshot)
      : submission_(submission), snapshot_(snapshot), counter_(folder, submission)
  {
  }

  MissingWork found(const StatusView& status)
  {
    for (const CaseView& view : status.cases) check_case(view);
    if (status.index) check_index(*status.index);
    return std::move(missing_);
  }

 private:
  void check_case(const CaseView& view)
  {
    const TaskView& last = view.tasks.back();
    note_end(last.task);
    if (view.is_complete) return;
    CaseWork work;
    work.case_number = view.case_number;
    const bool has_merge = last.task.kind == TaskKind::merge;
    for (const TaskView& task : view.tasks) {
      if (!view.is_merged && task.task.kind != TaskKind::merge) check_task(task, work);
    }
    if (!view.is_merged && has_merge && has_own_failure(last)) recheck_spine(view.tasks.front(), work);
    if (has_merge) return check_merge(last, work);
    if (work.needs_run) missing_.work.cases.push_back(work);
  }

  void check_task(const TaskView& view, CaseWork& work)
  {
    const TaskKind kind = view.task.kind;
    if (is_under_way(view)) {
      ++missing_.n_active;
      if (kind == TaskKind::spine) add_once(work.active_spine_jobs, view.slurm_job);
      if (kind == TaskKind::shard) add_once(work.active_shard_jobs, view.slurm_job);
      if (kind == TaskKind::run) add_once(missing_.work.active_case_jobs, view.slurm_job);
      return;
    }
    if (is_complete(view)) return;
    repeat(view, problem_of(view));
    if (kind == TaskKind::spine) work.needs_spine = true;
    if (kind == TaskKind::shard) work.shards.push_back(view.task.shard);
    if (kind == TaskKind::run) work.needs_run = true;
  }

  void check_merge(const TaskView& merge, const CaseWork& work)
  {
    const bool is_new = work.needs_spine || !work.shards.empty();
    const bool has_merge = is_under_way(merge);
    if (has_merge) ++missing_.n_active;
    if (has_merge && (!is_new || merge.status == TaskStatus::running)) {
      return add_once(missing_.work.active_case_jobs, merge.slurm_job);
    }
    // The queued merge would start without the new shards, or never.
    if (has_merge) add_once(missing_.to_cancel, merge.slurm_job);
    if (!has_merge) repeat(merge, problem_of(merge));
    missing_.work.cases.push_back(work);
  }

  void check_index(const TaskView& index)
  {
    const bool has_work = !missing_.work.cases.empty();
    const bool is_running = is_under_way(index) && index.status == TaskStatus::running;
    if (!has_work && is_under_way(index)) {
      ++missing_.n_active;
      return;
    }
    if (!has_work && index.status == TaskStatus::done && !is_outdated(index)) return;
    if (is_running) {
      // The running index may miss the new models, and must not overwrite the table of the next index task.
      ++missing_.n_active;
      add_once(missing_.work.active_case_jobs, index.slurm_job);
    }
    if (index.status == TaskStatus::queued) add_once(missing_.to_cancel, index.slurm_job);
    missing_.work.needs_index = true;
    if (!has_work) repeat(index, problem_of(index));
  }

  // In Slurm only: repeating a local task is safe because of its lock.
  bool is_under_way(const TaskView& view) const
  {
    const bool is_local = snapshot_.locked.count(view.task) > 0;
    return !is_local &&
           (view.status == TaskStatus::queued || view.status == TaskStatus::running || view.is_job_running);
  }

  const TaskState* state_of(const TaskId& task) const
  {
    const auto state = snapshot_.states.find(task);
    return state == snapshot_.states.end() ? nullptr : &state->second;
  }

  // The merge itself failed, not one of its dependencies.
  bool has_own_failure(const TaskView& merge) const
  {
    const TaskState* own = state_of(merge.task);
    return merge.status == TaskStatus::failed && own != nullptr && own->phase == TaskPhase::failed &&
           own->slurm_job == merge.slurm_job;
  }

  // UTC texts sort like times. An end in the future is due to a changed clock and is ignored.
  void note_end(const TaskId& last)
  {
    const TaskState* own = state_of(last);
    if (own == nullptr || own->phase != TaskPhase::done) return;
    if (own->ended <= now_) last_end_ = std::max(last_end_, own->ended);
  }

  // E.g. when the next index task was never submitted, or killed.
  bool is_outdated(const TaskView& index) const
  {
    const TaskState* own = state_of(index.task);
    return !missing_.work.active_case_jobs.empty() || (own != nullptr && last_end_ > own->started);
  }

  // With free varus the total is unknown: whether the spine is complete is determined only by a merge, a
  // shard or the spine task, which must load the meshes.
  void recheck_spine(const TaskView& spine, CaseWork& work)
  {
    const bool is_all_done = !is_under_way(spine) && !work.needs_spine && work.shards.empty();
    if (!is_all_done || counter_.count(spine.task).n_total > 0) return;
    work.needs_spine = true;
    repeat(spine, "its journal may be incomplete, since the merge failed");
  }

  bool is_complete(const TaskView& view)
  {
    if (view.status != TaskStatus::done || view.task.kind == TaskKind::run) return false;
    const SolvedCount solved = counter_.count(view.task);
    if (solved.n_total > 0) return solved.n_done == solved.n_total;
    return view.task.kind == TaskKind::shard || solved.n_done > 0;
  }

  void repeat(const TaskView& view, const char* what)
  {
    const std::string line = full_text_of(view.task, submission_) + ": " + what;
    missing_.reasons.push_back(view.reason.empty() ? line : line + ": " + view.reason);
    // A job with a dependency that can never be satisfied.
    const auto job = snapshot_.slurm.find(view.task);
    if (job != snapshot_.slurm.end() && job->second.row.state == "PENDING")
      add_once(missing_.to_cancel, job->second.job);
  }

  const Submission& submission_;
  const SubmissionSnapshot& snapshot_;
  const std::string now_ = utc_now();
  SolvedCounter counter_;
  std::string last_end_;  // UTC, of the completed cases
  MissingWork missing_;
};

}  // namespace

MissingWork find_missing_work(const std::string& folder, const Submission& submission,
                              const StatusView& status, const SubmissionSnapshot& snapshot)
{
  return Search(folder, submission, snapshot).found(status);
}

}  // namespace vrda::run
