#include "solve/prior.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

#include "core/parallel.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "solve/potential.hpp"
#include "solve/sweep.hpp"

namespace vrda::solve {
namespace {

struct EstimateStopped {};  // thrown and caught here to end the estimations

// Own stiffness, factors and levels from the spine without the prior.
class PriorEstimate {
 public:
  PriorEstimate(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks, int n_threads,
                const std::vector<FreeSpineStep>& alone)
      : plan_(plan), solve_(solve), hooks_(hooks), n_threads_(n_threads)
  {
    const std::vector<double>& path = path_of(plan);
    for (const double flexion_rad : plan.flexion_rad) {
      const auto at = std::lower_bound(path.begin(), path.end(), flexion_rad);
      path_row_.push_back(static_cast<std::int32_t>(at - path.begin()));
    }
    state_.flexion_rad = plan.flexion_rad;
    for (const FreeSpineStep& step : alone) starts_.push_back(prior_pose(step.chosen));
  }

  PriorState estimated()
  {
    measure_own_stiffness();
    set_factors();
    estimate_levels();
    return std::move(state_);
  }

 private:
  StepRecord step(const StepTask& task) const
  {
    if (hooks_.recall) {
      if (const std::optional<StepRecord> known = hooks_.recall(task.key)) return *known;
    }
    if (hooks_.is_stopped && hooks_.is_stopped()) throw EstimateStopped{};
    StepRecord record = solve_(task);
    record.key = task.key;
    if (hooks_.keep) hooks_.keep(record);
    return record;
  }

  StepTask task_at(StepKind kind, std::size_t i, std::int32_t number) const
  {
    StepTask task;
    task.key = {kind, static_cast<std::int32_t>(i), number};
    task.path_row = task.seed_path_row = path_row_[i];
    task.attitude = {plan_.flexion_rad[i], starts_[i].varus_rad};
    task.seed = starts_[i].pose;
    task.seed_attitude = task.attitude;
    task.is_varus_free = true;
    task.is_measured = false;
    return task;
  }

  // Calls `solve_at(i, worker)` for each flexion with a pose.
  template <typename SolveAt>
  void for_each_flexion(const SolveAt& solve_at)
  {
    std::atomic<int> next_worker = 0;
    for_each_index(starts_.size(), n_threads_, [&] {
      return [&, worker = next_worker++](std::size_t i) {
        if (starts_[i].is_set) solve_at(i, worker);
      };
    });
  }

  // Secant over the two moments: a tangent would be that of one facet.
  void measure_own_stiffness()
  {
    state_.own_stiffness.assign(starts_.size(), nan);
    if (std::none_of(plan_.prior.begin(), plan_.prior.end(),
                     [](const PriorTerm& term) { return term.times_own > 0.0; }))
      return;
    for_each_flexion([&](std::size_t i, int worker) {
      double theta_rad[2]{};
      for (const std::int32_t k : {0, 1}) {
        StepTask task = task_at(StepKind::prior_probe, i, k);
        task.band = k == 0 ? -1 : 1;
        task.worker = worker;
        const StepRecord end = step(task);
        // One that slides off resists no moment: no stiffness on that side.
        theta_rad[k] = end.status == StepStatus::stable ? end.pose.theta_rad : nan;
      }
      const double swing_rad = theta_rad[1] - theta_rad[0];
      if (swing_rad > 0.0) state_.own_stiffness[i] = 2.0 * plan_.band_moment_nmm / swing_rad;
    });
  }

  void set_factors()
  {
    state_.factor.assign(starts_.size(), 1.0);
    for (const PriorTerm& term : plan_.prior) {
      if (!(term.times_own > 0.0)) continue;
      for (std::size_t i = 0; i < starts_.size(); ++i) {
        const double wanted = term.times_own * state_.own_stiffness[i] / term.stiffness;
        if (wanted > 1.0) state_.factor[i] = std::min(wanted, term.at_most_times);
      }
    }
  }

  void estimate_levels()
  {
    state_.level.assign(plan_.prior.size(), 0.0);
    PriorLevels levels(plan_.prior, state_);
    levels.improve(starts_);
    for (std::int32_t pass = 0; pass < n_level_passes; ++pass) {
      std::vector<PriorPose> ends = starts_;
      for_each_flexion([&](std::size_t i, int worker) {
        StepTask task = task_at(StepKind::prior_level, i, pass);
        task.springs = springs_at(plan_.prior, state_, plan_.flexion_rad[i]);
        task.worker = worker;
        const StepRecord end = step(task);
        if (end.status == StepStatus::stable) ends[i] = prior_pose(end);
      });
      starts_ = std::move(ends);
      if (pass == 0) levels.restart();
      levels.improve(starts_);
    }
  }

  const SweepPlan& plan_;
  const SolveStep& solve_;
  const SweepHooks& hooks_;
  const int n_threads_;
  std::vector<std::int32_t> path_row_;  // [n_flexion]
  std::vector<PriorPose> starts_;       // [n_flexion] the latest
  PriorState state_;
};

// The steps of the spine under the keys of the motion without the prior.
SweepHooks hooks_alone(const SweepHooks& hooks)
{
  SweepHooks alone = hooks;
  if (hooks.recall) {
    alone.recall = [&hooks](StepKey key) {
      key.kind = StepKind::alone_spine;
      std::optional<StepRecord> known = hooks.recall(key);
      if (known) known->key.kind = StepKind::free_spine;
      return known;
    };
  }
  if (hooks.keep) {
    alone.keep = [&hooks](StepRecord record) {
      record.key.kind = StepKind::alone_spine;
      hooks.keep(record);
    };
  }
  return alone;
}

}  // namespace

PriorPose prior_pose(const StepRecord& record)
{
  return {record.pose, record.varus_rad, record.status == StepStatus::stable};
}

PriorLevels::PriorLevels(const std::vector<PriorTerm>& terms, PriorState& state)
    : terms_(terms), state_(state)
{
  for (const PriorTerm& term : terms) has_free_ = has_free_ || !term.level;
}

void PriorLevels::improve(const std::vector<PriorPose>& at)
{
  const std::vector<double> level = state_.level, offset = mean_offsets(at);
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    double next = offset[k];
    if (!level_before_.empty()) {
      constexpr double steepest = 0.95;  // an estimate nearer to 1 is noise of the facets
      const double run = level[k] - level_before_[k];
      const double slope = run != 0.0 ? (offset[k] - offset_before_[k]) / run : 0.0;
      next = level[k] + (offset[k] - level[k]) / (1.0 - std::clamp(slope, 0.0, steepest));
    }
    state_.level[k] = terms_[k].level.value_or(next);
  }
  level_before_ = level;
  offset_before_ = offset;
}

std::vector<double> PriorLevels::mean_offsets(const std::vector<PriorPose>& at) const
{
  std::vector<double> offsets;
  for (const PriorTerm& term : terms_) {
    double sum = 0.0, weight = 0.0;
    for (std::size_t i = 0; i < at.size(); ++i) {
      if (!at[i].is_set) continue;
      const double stiffness = term.has_factor ? state_.factor[i] : 1.0;
      sum += stiffness * (coordinate_value(term.coordinate, at[i].varus_rad, at[i].pose).value -
                          prior_value(term, state_.flexion_rad[i]));
      weight += stiffness;
    }
    offsets.push_back(weight > 0.0 ? sum / weight : 0.0);
  }
  return offsets;
}

std::vector<CoordinateSpring> springs_at(const std::vector<PriorTerm>& terms, const PriorState& state,
                                         double flexion_rad)
{
  PriorTerm factor;  // the factors as a curve over flexion
  factor.flexion_rad = state.flexion_rad;
  factor.value = state.factor;
  std::vector<CoordinateSpring> springs;
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const PriorTerm& term = terms[k];
    springs.push_back({term.coordinate,
                       term.stiffness * (term.has_factor ? prior_value(factor, flexion_rad) : 1.0),
                       prior_value(term, flexion_rad) + state.level[k] + term.level_change});
  }
  return springs;
}

SweepResult sweep_with_prior(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks,
                             int n_threads)
{
  SweepPlan without = plan;
  without.prior.clear();
  without.rows.emplace();
  without.follow = nullptr;
  without.is_varus_free = false;  // no cell takes its poses, so their contacts are not measured
  SweepResult alone = sweep(without, solve, hooks_alone(hooks), n_threads);
  if (!alone.is_complete) return {};
  SweepPlan with = plan;
  with.prior.clear();
  PriorState state;
  try {
    state = PriorEstimate(plan, solve, hooks, n_threads, alone.free_spine).estimated();
  } catch (const EstimateStopped&) {
    return {};
  }
  const std::vector<double>& path = path_of(plan);
  with.springs.clear();
  for (const double flexion_rad : path) with.springs.push_back(springs_at(plan.prior, state, flexion_rad));
  with.starts.assign(path.size(), std::nullopt);
  for (std::size_t i = 0; i < alone.free_spine.size(); ++i) {
    const StepRecord& chosen = alone.free_spine[i].chosen;
    const auto row = std::lower_bound(path.begin(), path.end(), plan.flexion_rad[i]) - path.begin();
    if (chosen.status == StepStatus::stable) with.starts[static_cast<std::size_t>(row)] = chosen;
  }
  SweepResult result = sweep(with, solve, hooks, n_threads);
  result.alone = std::move(alone.free_spine);
  result.prior = std::move(state);
  return result;
}

}  // namespace vrda::solve
