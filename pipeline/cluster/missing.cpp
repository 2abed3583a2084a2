#include "cluster/missing.hpp"

#include <algorithm>

#include "cluster/solved_count.hpp"

namespace vrda {
namespace {

bool is_under_way(const TaskView& view)
{
  return view.standing == TaskStanding::queued || view.standing == TaskStanding::running;
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
    if (view.is_made) return;
    CaseWork work;
    work.case_number = view.case_number;
    for (const TaskView& task : view.tasks) look_at(task, work);
    const TaskView& last = view.tasks.back();
    if (last.task.kind == TaskKind::merge) return settle_merge(last, work);
    if (work.needs_run) missing_.work.cases.push_back(work);
  }

  void look_at_index(const TaskView& index)
  {
    const bool has_work = !missing_.work.cases.empty();
    if (!has_work && (is_under_way(index) || index.standing == TaskStanding::done)) {
      if (is_under_way(index)) ++missing_.n_under_way;
      return;
    }
    if (index.standing == TaskStanding::running) return;
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

  bool is_complete(const TaskView& view)
  {
    if (view.standing != TaskStanding::done || view.task.kind == TaskKind::run) return false;
    const SolvedCount solved = counter_.count(view.task);
    if (solved.n_total > 0) return solved.n_done == solved.n_total;
    return view.task.kind == TaskKind::shard || solved.n_done > 0;
  }

  void again(const TaskView& view)
  {
    std::string name;
    if (view.task.case_number >= 0 && submission_.has_index()) {
      name = submission_.cases[static_cast<std::size_t>(view.task.case_number)].spec.name + " ";
    }
    name += text_of(view.task, submission_) + ": ";
    const bool is_short = view.standing == TaskStanding::done && view.task.kind != TaskKind::index;
    name += is_short ? "its journal is not whole" : name_of(view.standing);
    missing_.reasons.push_back(view.reason.empty() ? name : name + ": " + view.reason);
    // A job whose dependency can never be.
    const auto job = seen_.slurm.find(view.task);
    if (job != seen_.slurm.end() && job->second.row.state == "PENDING")
      add_once(missing_.to_cancel, job->second.job);
  }

  const Submission& submission_;
  const Sightings& seen_;
  SolvedCounter counter_;
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
