/// Start poses of the steps of a grid, and the choice among their results.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "solve/sweep.hpp"

namespace vrda::solve {

/// Start of a step.
struct Seed {
  MovingPose pose;
  std::optional<Attitude> attitude;  ///< at which the pose was solved; empty for the start pose of the job
  std::int32_t path_row = 0;         ///< its Delta
  bool is_last_resort = false;       ///< tried only while no result is stable
};

/// The seed, the start pose of the plan, and its rotations as last resorts.
std::vector<Seed> seeds_from(const SweepPlan& plan, const Seed& seed);

/// Solves `task` (its seed is ignored) from each seed in turn until a result is usable. From each seed first
/// directly; then, if it has an attitude, along attitudes at most `max_seed_step_rad` apart in flexion and in
/// varus, solved with is_measured = false, as far as these are usable. Without a usable result: the last
/// stable one, else the last. The task of the result is the last that was solved with is_measured = true.
/// With `max_seed_step_rad` 0 only the first seed is tried, directly.
StepRecord solve_from_seeds(StepTask task, const std::vector<Seed>& seeds, double max_seed_step_rad,
                            const SolveStep& solve, const std::function<bool(const StepRecord&)>& is_usable);

}  // namespace vrda::solve
