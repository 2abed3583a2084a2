/// Solves every attitude of a flexion x varus grid along a fixed seeding graph (DESIGN.md 5.4): a spine
/// along flexion through the cells where both compartments are most nearly in balance, then rows that
/// grow outward from it. The result does not depend on the number of workers or on interruptions.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/step_record.hpp"

namespace vrda {

struct SweepPlan {
  std::vector<double> flexion_rad;  ///< [n_flexion]
  std::vector<double> varus_rad;    ///< [n_varus]
  MovingPose initial;               ///< seed of the first step
  bool has_compartments = true;     ///< without, the spine stays in the column nearest zero varus
};

/// Pure but for what it notes down under `key`; called from several threads at once. A spine cell is solved
/// as a probe; its own key is for `recall` and `keep` only.
using SolveStep =
    std::function<StepRecord(const StepKey& key, const Attitude& attitude, const MovingPose& seed)>;

/// Each may be empty. `recall` and `keep` are called from the workers.
struct SweepHooks {
  std::function<std::optional<StepRecord>(const StepKey&)> recall;  ///< a step solved in an earlier run
  std::function<void(const StepRecord&)> keep;                      ///< a step just solved, key set
  std::function<bool()> is_stopped;                                 ///< finish the steps in hand and return
};

struct SweepResult {
  std::vector<StepRecord> cells;           ///< [n_flexion * n_varus], flexion-major; `pending` where stopped
  std::vector<std::int32_t> spine_column;  ///< [n_flexion] varus index, -1 where stopped
  bool is_complete = false;
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
