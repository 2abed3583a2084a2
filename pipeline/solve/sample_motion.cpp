#include "solve/sample_motion.hpp"

#include <algorithm>

#include "core/error.hpp"
#include "solve/seeds.hpp"

namespace vrda::solve {
namespace {

struct SampleStopped {};

class SampleMotion {
 public:
  SampleMotion(const SweepPlan& plan, const SweepResult& job, const SolveStep& solve,
               const SampleOptions& options)
      : plan_(plan), job_(job), solve_(solve), options_(options), ends_(plan.flexion_rad.size())
  {
    check(job.free_spine.size() == plan.flexion_rad.size(), "sample_motion: a spine with free varus");
    const std::vector<double>& path = path_of(plan);
    for (const double flexion_rad : plan.flexion_rad) {
      const auto at = std::lower_bound(path.begin(), path.end(), flexion_rad);
      path_row_.push_back(static_cast<std::int32_t>(at - path.begin()));
    }
  }

  std::vector<StepRecord> run()
  {
    const auto n = static_cast<std::int32_t>(ends_.size());
    for (std::int32_t i = 0; i < n; ++i) {
      start_from_job(i);
      if (i > 0) start_from_neighbour(i, i - 1);
    }
    for (std::int32_t i = n - 1; i-- > 0;) start_from_neighbour(i, i + 1);
    std::vector<StepRecord> records;
    for (std::int32_t i = 0; i < n; ++i) records.push_back(measured(i));
    return records;
  }

 private:
  std::vector<StepRecord>& ends(std::int32_t i) { return ends_[static_cast<std::size_t>(i)]; }
  std::int32_t path_row(std::int32_t i) const { return path_row_[static_cast<std::size_t>(i)]; }

  StepTask task_at(std::int32_t i, const Seed& seed) const
  {
    StepTask task;
    task.key = {StepKind::sample, i, options_.sample};
    task.path_row = path_row(i);
    task.attitude = {plan_.flexion_rad[static_cast<std::size_t>(i)],
                     seed.attitude ? seed.attitude->varus_rad : 0.0};
    task.seed = seed.pose;
    task.seed_attitude = seed.attitude;
    task.seed_path_row = seed.path_row;
    task.is_varus_free = true;
    return task;
  }

  StepRecord solved(const StepTask& task) const
  {
    if (options_.is_stopped && options_.is_stopped()) throw SampleStopped{};
    StepRecord record = solve_(task);
    record.key = task.key;
    return record;
  }

  void start(std::int32_t i, const Seed& seed)
  {
    StepTask task = task_at(i, seed);
    task.known = &ends(i);
    task.is_measured = false;
    ends(i).push_back(solved(task));
  }

  Seed seed_of(std::int32_t i, const StepRecord& record) const
  {
    const double flexion_rad =
        record.coordinates ? record.flexion_rad : plan_.flexion_rad[static_cast<std::size_t>(i)];
    return {record.pose, Attitude{flexion_rad, record.varus_rad}, path_row(i)};
  }

  void start_from_job(std::int32_t i)
  {
    const FreeSpineStep& found = job_.free_spine[static_cast<std::size_t>(i)];
    const bool is_stable = found.chosen.status == StepStatus::stable;
    if (is_stable) start(i, seed_of(i, found.chosen));
    for (const SpineEquilibrium& other : found.equilibria) {
      if (other.is_chosen) continue;
      StepRecord at = found.chosen;
      at.pose = other.pose;
      at.varus_rad = other.varus_rad;
      start(i, seed_of(i, at));
    }
    if (!is_stable && i == 0) start(i, {plan_.initial, {}, 0});
  }

  void start_from_neighbour(std::int32_t to, std::int32_t from)
  {
    if (ends(from).empty()) return;
    const StepRecord lowest = select_lowest(ends(from)).chosen;
    if (lowest.status == StepStatus::stable) start(to, seed_of(from, lowest));
  }

  StepRecord measured(std::int32_t i)
  {
    StepRecord record;
    record.status = StepStatus::no_contact;  // no start at all: the job and both neighbours have no pose
    if (!ends(i).empty()) {
      const StepRecord lowest = select_lowest(ends(i)).chosen;
      record = lowest.status == StepStatus::stable ? solved(task_at(i, seed_of(i, lowest))) : lowest;
    }
    record.key = {StepKind::sample, i, options_.sample};
    return record;
  }

  const SweepPlan& plan_;
  const SweepResult& job_;
  const SolveStep& solve_;
  const SampleOptions& options_;
  std::vector<std::int32_t> path_row_;          // [n_flexion]
  std::vector<std::vector<StepRecord>> ends_;  // [n_flexion] results of all starts
};

}  // namespace

std::vector<StepRecord> sample_motion(const SweepPlan& plan, const SweepResult& job, const SolveStep& solve,
                                      const SampleOptions& options)
{
  try {
    return SampleMotion(plan, job, solve, options).run();
  } catch (const SampleStopped&) {
    return {};
  }
}

}  // namespace vrda::solve
