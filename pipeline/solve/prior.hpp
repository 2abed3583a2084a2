/// The motion with a prior (schemas/prior.md): springs that pull coordinates of the joint to published curves
/// over flexion. The spine is solved without them first; from it follow the joint's own rotational stiffness,
/// the factor of the springs at each flexion, and the levels of the curves.
#pragma once

#include <vector>

#include "model/step_record.hpp"
#include "solve/sweep.hpp"

namespace vrda::solve {

/// Number of estimations of the levels. The levels of real knees change by less than 0.02 degrees and 0.02 mm
/// in the last (results/believable.md).
inline constexpr int n_level_passes = 4;

/// The springs of `terms` at a flexion: factors are linear between flexions of the state.
std::vector<CoordinateSpring> springs_at(const std::vector<PriorTerm>& terms, const PriorState& state,
                                         double flexion_rad);

/// The sweep of a plan with a prior: `alone` and `prior` of the result are set, all else is of the motion
/// with the prior. Steps: alone_spine, prior_probe at each flexion of the grid, n_level_passes times
/// prior_level, then those of any sweep. Each goes through the hooks, so that interruptions, shards and
/// merges repeat none. Errors: those of sweep().
SweepResult sweep_with_prior(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks,
                             int n_threads);

}  // namespace vrda::solve
