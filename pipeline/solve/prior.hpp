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

/// Of the levels of a sample, from those of the job.
inline constexpr int n_sample_level_passes = 2;

/// A pose from which levels are estimated.
struct PriorPose {
  MovingPose pose;
  double varus_rad = 0.0;
  bool is_set = false;
};
PriorPose prior_pose(const StepRecord& record);

/// Estimates the free levels of a state: at the level of a term its springs pull as much to either side, over
/// all flexions, which is the minimum of the summed energy over the level. A fixed point of mean(q - curve);
/// the secant through two estimates takes its slope, which is near 1 for springs stiffer than the joint.
class PriorLevels {
 public:
  /// Both must outlive it.
  PriorLevels(const std::vector<PriorTerm>& terms, PriorState& state);

  bool has_free() const { return has_free_; }
  /// Sets the levels from the poses [n_flexion] solved with those of the state.
  void improve(const std::vector<PriorPose>& at);
  /// Forgets the estimates so far.
  void restart() { level_before_.clear(); }

 private:
  // [n_terms] mean of coordinate minus curve, weighted by stiffness.
  std::vector<double> mean_offsets(const std::vector<PriorPose>& at) const;

  const std::vector<PriorTerm>& terms_;
  PriorState& state_;
  bool has_free_ = false;
  std::vector<double> level_before_, offset_before_;
};

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
