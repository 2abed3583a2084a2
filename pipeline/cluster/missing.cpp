#include "cluster/missing.hpp"

#include <algorithm>
#include <chrono>

#include "cluster/solved_count.hpp"

namespace vrda {
namespace {

bool is_under_way(const TaskView& view)
{
  return view.standing == TaskStanding::queued || view.standing == TaskStanding::running ||
         view.is_job_running;
}

void add_once(std::vector<std::string>& ids, const std::string& id)
{
  if (!id.empty() && std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
}

class Search {
 public:
  Search(const std::string& folder, const Submission& submission, const Sightings& seen)
      : submission_(submission), seen_(seen), counter_(folder, submission)
  {
  }

  void look_at(const CaseView& view)
  {
    const TaskView& last = view.tasks.back();
    note_end(last.task);
    if (view.is_made) return;
    CaseWork work;
    work.case_number = view.case_number;
    if (view.is_merged) return settle_merge(last, work);
    for (const TaskView& task : view.tasks) look_at(task, work);
    if (has_failed_itself(last)) doubt_spine(view.tasks.front(), work);
    if (last.task.kind == TaskKind::merge) return settle_merge(last, work);
    if (work.needs_run) missing_.work.cases.push_back(work);
  }

  void look_at_index(const TaskView& index)
  {
    const bool has_work = !missing_.work.cases.empty();
    if (!has_work && is_under_way(index)) {
      ++missing_.n_under_way;
      return;
    }
    const bool is_done = index.standing == TaskStanding::done;
    if (!has_work && is_done && !is_outdated(index)) return;
    if (index.standing == TaskStanding::running) {
      // It may have passed by what is made only now, and must not write over the next one's table.
      ++missing_.n_under_way;
      add_once(missing_.work.cases_under_way, index.slurm_job);
    }
    if (index.standing == TaskStanding::queued) add_once(missing_.to_cancel, index.slurm_job);
    missing_.work.needs_index = true;
    if (!has_work) again(index);
  }

  Missing take() { return std::move(missing_); }

 private:
  void look_at(const TaskView& view, CaseWork& work)
  {
    if (view.task.kind == TaskKind::merge) return;
    if (is_under_way(view)) {
      ++missing_.n_under_way;
      if (view.task.kind == TaskKind::spine) add_once(work.spine_under_way, view.slurm_job);
      if (view.task.kind == TaskKind::shard) add_once(work.shards_under_way, view.slurm_job);
      if (view.task.kind == TaskKind::run) add_once(missing_.work.cases_under_way, view.slurm_job);
      return;
    }
    if (is_complete(view)) return;
    again(view);
    if (view.task.kind == TaskKind::spine) work.needs_spine = true;
    if (view.task.kind == TaskKind::shard) work.shards.push_back(view.task.shard);
    if (view.task.kind == TaskKind::run) work.needs_run = true;
  }

  void settle_merge(const TaskView& merge, CaseWork& work)
  {
    const bool is_new = work.needs_spine || !work.shards.empty();
    const bool has_merge = is_under_way(merge);
    if (has_merge) ++missing_.n_under_way;
    if (has_merge && (!is_new || merge.standing == TaskStanding::running)) {
      return add_once(missing_.work.cases_under_way, merge.slurm_job);
    }
    // It would begin without the new shards, or never.
    if (has_merge) add_once(missing_.to_cancel, merge.slurm_job);
    if (!has_merge) again(merge);
    missing_.work.cases.push_back(work);
  }

  // Of this merge, not of what it waited for.
  bool has_failed_itself(const TaskView& merge) const
  {
    const auto state = seen_.states.find(merge.task);
    return merge.task.kind == TaskKind::merge && merge.standing == TaskStanding::failed &&
           state != seen_.states.end() && state->second.phase == TaskPhase::failed &&
           state->second.slurm_job == merge.slurm_job;
  }

  // UTC texts sort as times do. What ends in the future tells of a clock set anew, nothing else.
  void note_end(const TaskId& last)
  {
    const auto state = seen_.states.find(last);
    if (state == seen_.states.end() || state->second.phase != TaskPhase::done) return;
    if (state->second.ended <= now_) last_end_ = std::max(last_end_, state->second.ended);
  }

  // As one becomes whose successor was never submitted, or killed with the rest.
  bool is_outdated(const TaskView& index) const
  {
    const auto state = seen_.states.find(index.task);
    return !missing_.work.cases_under_way.empty() ||
           (state != seen_.states.end() && last_end_ > state->second.begun);
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

  void again(const TaskView& view) { again(view, what_is_wrong_with(view)); }

  void again(const TaskView& view, const char* what)
  {
    std::string name;
    if (view.task.case_number >= 0 && submission_.has_index()) {
      name = submission_.cases[static_cast<std::size_t>(view.task.case_number)].spec.name + " ";
    }
    name += text_of(view.task, submission_) + ": ";
    name += what;
    missing_.reasons.push_back(view.reason.empty() ? name : name + ": " + view.reason);
    // A job whose dependency can never be.
    const auto job = seen_.slurm.find(view.task);
    if (job != seen_.slurm.end() && job->second.row.state == "PENDING")
      add_once(missing_.to_cancel, job->second.job);
  }

  static const char* what_is_wrong_with(const TaskView& view)
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

  const Submission& submission_;
  const Sightings& seen_;
  const std::string now_ = utc_text(std::chrono::system_clock::now());
  SolvedCounter counter_;
  std::string last_end_;  // UTC, of the cases made
  Missing missing_;
};

}  // namespace

Missing missing_of(const std::string& folder, const Submission& submission, const StatusView& status,
                   const Sightings& seen)
{
  Search search(folder, submission, seen);
  for (const CaseView& view : status.cases) search.look_at(view);
  if (status.index) search.look_at_index(*status.index);
  return search.take();
}

}  // namespace vrda
