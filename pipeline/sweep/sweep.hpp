/// Solves every attitude of a flexion x varus grid along a fixed seeding graph (DESIGN.md 5.4): a spine
/// along flexion through the cells where both compartments are most nearly in balance, then rows that
/// grow outward from it. The result does not depend on the number of workers or on interruptions.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/step_record.hpp"
#include "sweep/free_spine.hpp"

namespace vrda {

/// How the spine finds its cell of a flexion.
enum class SpineRule {
  nearest_zero,     ///< the column nearest zero varus
  walk_to_balance,  ///< from the previous column to the better balanced neighbour
  free_varus,       ///< the column nearest to the varus that the joint takes when it is left free
};

struct SweepPlan {
  std::vector<double> flexion_rad;  ///< [n_flexion]
  std::vector<double> varus_rad;    ///< [n_varus]
  MovingPose initial;               ///< seed of the first step
  SpineRule spine = SpineRule::walk_to_balance;
  // The rest is for `free_varus` only.
  bool is_varus_free = false;  ///< the one column of the grid holds the spine's own poses
  bool has_band = false;       ///< each flexion is solved under extra moments too
  int n_restarts = 0;          ///< starts aside from the two chains along flexion (sweep/free_spine.hpp)
  /// The flexions whose rows are solved, each once; absent: all of them, empty: the spine alone. The spine is
  /// needed, solved or recalled, whichever rows follow.
  std::optional<std::vector<std::int32_t>> rows;
};

/// One step to solve.
struct StepTask {
  StepKey key;
  Attitude attitude;  ///< where varus is free its seed
  MovingPose seed;
  std::int32_t seed_flexion = 0;  ///< where the seed comes from: another Delta may hold there
  bool is_varus_free = false;
  int band = 0;             ///< -1 or +1: with the extra moment against theta or with it
  bool is_measured = true;  ///< false: only where it rests counts, and with which energy
  int worker = 0;           ///< who asks: below the number of threads, for scratch that outlives a step
};

/// Pure but for what it notes down under `task.key`; called from several threads at once. A spine cell that
/// was found by walking is solved as a probe, one of a free spine among its starts; its own key is for
/// `recall` and `keep` then.
using SolveStep = std::function<StepRecord(const StepTask& task)>;

/// Each may be empty. `recall` and `keep` are called from the workers.
struct SweepHooks {
  std::function<std::optional<StepRecord>(const StepKey&)> recall;  ///< a step solved in an earlier run
  std::function<void(const StepRecord&)> keep;                      ///< a step just solved, key set
  std::function<bool()> is_stopped;                                 ///< finish the steps in hand and return
};

struct SweepResult {
  std::vector<StepRecord> cells;           ///< [n_flexion * n_varus], flexion-major; `pending` where stopped
  std::vector<std::int32_t> spine_column;  ///< [n_flexion] varus index, -1 where stopped
  std::vector<FreeSpineStep> free_spine;   ///< [n_flexion] with SpineRule::free_varus, else empty
  bool is_complete = false;                ///< the spine and every row asked for
};

/// What is left between the compartments: |gap_medial - gap_lateral|; infinite when not stable or when
/// a compartment faces nothing.
double imbalance_mm(const StepRecord& record);

/// Whether `a` suits the spine better than `b`: both compartments touching beats one, the smaller imbalance
/// beats the larger; where both cells touch on both sides, the one further along Delta wins, since there a
/// varus left free would come to rest.
bool is_better_balanced(const StepRecord& a, const StepRecord& b);

/// Rethrows the first that `solve` or a hook throws; the other workers finish the step in hand before.
SweepResult sweep(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks, int n_threads);

}  // namespace vrda
