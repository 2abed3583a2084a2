#include "solve/seeds.hpp"

#include <algorithm>
#include <cmath>

namespace vrda::solve {
namespace {

// Number of parts of equal length from one attitude to another; a part may exceed the limit by rounding.
int n_parts(const Attitude& from, const Attitude& to, double max_step_rad)
{
  constexpr double rounding = 1e-9;
  const double largest_rad =
      std::max(std::abs(to.flexion_rad - from.flexion_rad), std::abs(to.varus_rad - from.varus_rad));
  return static_cast<int>(std::ceil(largest_rad / max_step_rad - rounding));
}

Attitude between(const Attitude& from, const Attitude& to, double share)
{
  return {from.flexion_rad + share * (to.flexion_rad - from.flexion_rad),
          from.varus_rad + share * (to.varus_rad - from.varus_rad)};
}

struct Attempt {
  StepTask task;
  StepRecord record;
};

bool is_stable(const Attempt& attempt)
{
  return attempt.record.status == StepStatus::stable;
}

}  // namespace

std::vector<Seed> seeds_from(const SweepPlan& plan, const Seed& seed)
{
  std::vector<Seed> seeds{seed};
  if (seed.attitude) seeds.push_back({plan.initial, {}, 0});
  for (const double theta_rad : plan.last_resort_thetas_rad) {
    MovingPose rotated = plan.initial;
    rotated.theta_rad += theta_rad;
    seeds.push_back({rotated, {}, 0, true});
  }
  return seeds;
}

StepRecord solve_from_seeds(StepTask task, const std::vector<Seed>& seeds, double max_seed_step_rad,
                            const SolveStep& solve, const std::function<bool(const StepRecord&)>& is_usable)
{
  std::vector<Attempt> attempts;
  const auto is_solved = [&] {
    attempts.push_back({task, solve(task)});
    return is_usable(attempts.back().record);
  };
  for (const Seed& seed : seeds) {
    if (seed.is_last_resort && std::any_of(attempts.begin(), attempts.end(), is_stable)) continue;
    task.seed = seed.pose;
    task.seed_attitude = seed.attitude;
    task.seed_path_row = seed.path_row;
    if (is_solved() || max_seed_step_rad <= 0.0) return attempts.back().record;
    if (!seed.attitude) continue;
    const int n = n_parts(*seed.attitude, task.attitude, max_seed_step_rad);
    StepTask part = task;
    part.is_measured = false;
    bool is_nearer = false;
    for (int k = 1; k < n; ++k) {
      part.attitude = between(*seed.attitude, task.attitude, static_cast<double>(k) / n);
      const StepRecord record = solve(part);
      if (!is_usable(record)) break;
      part.seed = record.pose;
      part.seed_attitude = part.attitude;
      part.seed_path_row = part.path_row;
      is_nearer = true;
    }
    if (!is_nearer) continue;
    task.seed = part.seed;
    task.seed_attitude = part.seed_attitude;
    task.seed_path_row = part.seed_path_row;
    if (is_solved()) return attempts.back().record;
  }
  const auto stable = std::find_if(attempts.rbegin(), attempts.rend(), is_stable);
  if (stable == attempts.rend() || stable == attempts.rbegin()) return attempts.back().record;
  return solve(stable->task);
}

}  // namespace vrda::solve
