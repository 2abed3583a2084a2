#include "cluster/status.hpp"

#include <algorithm>

namespace vrda {
namespace {

void add_once(std::vector<std::string>& ids, const std::string& id)
{
  if (!id.empty() && std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
}

const char* what_is_wrong_with(const TaskView& view)
{
  if (view.standing != TaskStanding::done) return name_of(view.standing);
  switch (view.task.kind) {
    case TaskKind::spine:
    case TaskKind::shard:
      return "its journal is not whole";
    case TaskKind::merge:
    case TaskKind::run:
      return "its model is gone, or not all is cleared up";
    case TaskKind::index:
      break;
  }
  return "done, but older than its cases";
}

class Search {
 public:
  Search(const std::string& folder, const Submission& submission, const SubmissionSnapshot& seen)
      : submission_(submission), seen_(seen), counter_(folder, submission)
  {
  }

  Missing found(const StatusView& status)
  {
    for (const CaseView& view : status.cases) look_at(view);
    if (status.index) look_at_index(*status.index);
    return std::move(missing_);
  }

 private:
  void look_at(const CaseView& view)
  {
    const TaskView& last = view.tasks.back();
    note_end(last.task);
    if (view.is_made) return;
    CaseWork work;
    work.case_number = view.case_number;
    const bool has_merge = last.task.kind == TaskKind::merge;
    for (const TaskView& task : view.tasks) {
      if (!view.is_merged && task.task.kind != TaskKind::merge) look_at(task, work);
    }
    if (!view.is_merged && has_merge && has_failed_itself(last)) doubt_spine(view.tasks.front(), work);
    if (has_merge) return settle_merge(last, work);
    if (work.needs_run) missing_.work.cases.push_back(work);
  }

  void look_at(const TaskView& view, CaseWork& work)
  {
    const TaskKind kind = view.task.kind;
    if (is_under_way(view)) {
      ++missing_.n_under_way;
      if (kind == TaskKind::spine) add_once(work.spine_under_way, view.slurm_job);
      if (kind == TaskKind::shard) add_once(work.shards_under_way, view.slurm_job);
      if (kind == TaskKind::run) add_once(missing_.work.cases_under_way, view.slurm_job);
      return;
    }
    if (is_complete(view)) return;
    again(view, what_is_wrong_with(view));
    if (kind == TaskKind::spine) work.needs_spine = true;
    if (kind == TaskKind::shard) work.shards.push_back(view.task.shard);
    if (kind == TaskKind::run) work.needs_run = true;
  }

  void settle_merge(const TaskView& merge, const CaseWork& work)
  {
    const bool is_new = work.needs_spine || !work.shards.empty();
    const bool has_merge = is_under_way(merge);
    if (has_merge) ++missing_.n_under_way;
    if (has_merge && (!is_new || merge.standing == TaskStanding::running)) {
      return add_once(missing_.work.cases_under_way, merge.slurm_job);
    }
    // It would begin without the new shards, or never.
    if (has_merge) add_once(missing_.to_cancel, merge.slurm_job);
    if (!has_merge) again(merge, what_is_wrong_with(merge));
    missing_.work.cases.push_back(work);
  }

  void look_at_index(const TaskView& index)
  {
    const bool has_work = !missing_.work.cases.empty();
    const bool is_running = is_under_way(index) && index.standing == TaskStanding::running;
    if (!has_work && is_under_way(index)) {
      ++missing_.n_under_way;
      return;
    }
    if (!has_work && index.standing == TaskStanding::done && !is_outdated(index)) return;
    if (is_running) {
      // It may have passed by what is made only now, and must not write over the next one's table.
      ++missing_.n_under_way;
      add_once(missing_.work.cases_under_way, index.slurm_job);
    }
    if (index.standing == TaskStanding::queued) add_once(missing_.to_cancel, index.slurm_job);
    missing_.work.needs_index = true;
    if (!has_work) again(index, what_is_wrong_with(index));
  }

  // By Slurm. Of local processes none needs to be spared.
  bool is_under_way(const TaskView& view) const
  {
    const bool is_local = seen_.locked.count(view.task) > 0;
    return !is_local && (view.standing == TaskStanding::queued || view.standing == TaskStanding::running ||
                         view.is_job_running);
  }

  const TaskState* state_of(const TaskId& task) const
  {
    const auto state = seen_.states.find(task);
    return state == seen_.states.end() ? nullptr : &state->second;
  }

  // Of this merge, not of what it waited for.
  bool has_failed_itself(const TaskView& merge) const
  {
    const TaskState* own = state_of(merge.task);
    return merge.standing == TaskStanding::failed && own != nullptr && own->phase == TaskPhase::failed &&
           own->slurm_job == merge.slurm_job;
  }

  // UTC texts sort as times do. What ends in the future tells of a clock set anew, nothing else.
  void note_end(const TaskId& last)
  {
    const TaskState* own = state_of(last);
    if (own == nullptr || own->phase != TaskPhase::done) return;
    if (own->ended <= now_) last_end_ = std::max(last_end_, own->ended);
  }

  // As one becomes whose successor was never submitted, or killed with the rest.
  bool is_outdated(const TaskView& index) const
  {
    const TaskState* own = state_of(index.task);
    return !missing_.work.cases_under_way.empty() || (own != nullptr && last_end_ > own->begun);
  }

  // With varus left free it has no known total: whether it is whole only a merge finds out, a shard, or it
  // itself for the price of loading.
  void doubt_spine(const TaskView& spine, CaseWork& work)
  {
    const bool is_nothing_missing = !is_under_way(spine) && !work.needs_spine && work.shards.empty();
    if (!is_nothing_missing || counter_.count(spine.task).n_total > 0) return;
    work.needs_spine = true;
    again(spine, "its journal may not be whole, since the merge failed");
  }

  bool is_complete(const TaskView& view)
  {
    if (view.standing != TaskStanding::done || view.task.kind == TaskKind::run) return false;
    const SolvedCount solved = counter_.count(view.task);
    if (solved.n_total > 0) return solved.n_done == solved.n_total;
    return view.task.kind == TaskKind::shard || solved.n_done > 0;
  }

  void again(const TaskView& view, const char* what)
  {
    const std::string line = full_text_of(view.task, submission_) + ": " + what;
    missing_.reasons.push_back(view.reason.empty() ? line : line + ": " + view.reason);
    // A job whose dependency can never be.
    const auto job = seen_.slurm.find(view.task);
    if (job != seen_.slurm.end() && job->second.row.state == "PENDING")
      add_once(missing_.to_cancel, job->second.job);
  }

  const Submission& submission_;
  const SubmissionSnapshot& seen_;
  const std::string now_ = utc_now();
  SolvedCounter counter_;
  std::string last_end_;  // UTC, of the cases made
  Missing missing_;
};

}  // namespace

Missing missing_of(const std::string& folder, const Submission& submission, const StatusView& status,
                   const SubmissionSnapshot& seen)
{
  return Search(folder, submission, seen).found(status);
}

}  // namespace vrda
