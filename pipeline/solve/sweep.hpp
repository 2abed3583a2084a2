/// Solves every attitude of a flexion x varus grid along a fixed seeding graph (sweep/README.md): a spine,
/// which is the continuation path along flexion through the cells where both compartments are nearest to
/// balance, then rows outward from it. The result does not depend on the number of workers or on
/// interruptions.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "model/step_record.hpp"
#include "solve/free_spine.hpp"

namespace vrda::solve {

/// How the spine selects its column at a flexion.
enum class SpineRule {
  nearest_zero,     ///< nearest to zero varus
  walk_to_balance,  ///< from the previous column to better balanced neighbours
  free_varus,       ///< nearest to the solution with free varus
};

struct SweepPlan {
  std::vector<double> flexion_rad;  ///< [n_flexion]; of a sequence of frames, the numbers of the rows
  std::vector<double> varus_rad;    ///< [n_varus]
  /// Flexions of the spine with free varus; they contain the grid's. Empty: the grid's.
  std::vector<double> path_flexion_rad;
  MovingPose initial;  ///< seed of the first step
  SpineRule spine = SpineRule::walk_to_balance;
  /// Whether a pose at a path row is in the joint. A step that fails or ends outside it is solved again from
  /// other seeds, if `max_seed_step_rad` is above 0, and poses outside are not seeds. Empty: all poses are.
  std::function<bool(const MovingPose&, std::int32_t path_row)> is_in_joint;
  /// Largest change of flexion or varus between a seed and its step in a subdivided path; 0: no subdivision
  /// and no other seeds.
  double max_seed_step_rad = 0.0;
  /// Rotations of the start pose from which a step is solved if no other seed leads to a stable pose.
  std::vector<double> last_resort_thetas_rad;
  // The next three apply to `free_varus` only.
  bool is_varus_free = false;  ///< the grid has one column, which takes the spine's own poses
  /// With a free varus: the chosen equilibrium of each flexion is solved again and measured, so the starts
  /// need not be.
  bool measures_chosen = false;
  bool has_band = false;  ///< each flexion is also solved with extra moments
  int n_restarts = 0;     ///< starts besides the two chains along flexion (sweep/free_spine.hpp)
  /// The flexions whose rows are solved, each once; absent: all, empty: the spine only. The spine is always
  /// needed, solved or recalled.
  std::optional<std::vector<std::int32_t>> rows;
};

inline const std::vector<double>& path_of(const SweepPlan& plan)
{
  return plan.path_flexion_rad.empty() ? plan.flexion_rad : plan.path_flexion_rad;
}

/// One step to solve.
struct StepTask {
  StepKey key;
  Attitude attitude;  ///< with free varus, its varus is the seed
  MovingPose seed;
  std::optional<Attitude> seed_attitude;  ///< at which the seed was solved; empty: the start pose of the plan
  std::int32_t path_row = 0;              ///< row of the path flexions, or of the grid's if there is no path
  std::int32_t seed_path_row = 0;         ///< of the seed: its Delta may differ
  bool is_varus_free = false;
  const std::vector<StepRecord>* known = nullptr;  ///< results of other starts of the same step
  int band = 0;             ///< -1 or +1: with the extra moment against theta or with it
  bool is_measured = true;  ///< false: only pose, status and energy are needed, under no key of the result
  int worker = 0;           ///< index below the number of threads, for scratch memory kept between steps
};

/// Pure but for logging under `task.key`; called from several threads at once. A spine cell is solved as a
/// probe of the walk or as a start of a free spine; its own key is then used for `recall` and `keep` only.
using SolveStep = std::function<StepRecord(const StepTask& task)>;

/// Each may be empty. `recall` and `keep` are called from the workers.
struct SweepHooks {
  std::function<std::optional<StepRecord>(const StepKey&)> recall;  ///< a step solved in an earlier run
  std::function<void(const StepRecord&)> keep;                      ///< a new step, key set
  std::function<bool()> is_stopped;  ///< true: the sweep finishes its current steps and returns
};

struct SweepResult {
  std::vector<StepRecord> cells;           ///< [n_flexion * n_varus], flexion-major; `pending` if stopped
  std::vector<std::int32_t> spine_column;  ///< [n_flexion] varus index, -1 if stopped
  std::vector<FreeSpineStep> free_spine;   ///< [n_flexion] with SpineRule::free_varus, else empty
  bool is_complete = false;                ///< the spine and every requested row are solved
};

/// Rethrows the first exception of `solve` or a hook after the other workers have finished their steps.
SweepResult sweep(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks, int n_threads);

/// Imbalance of the compartments, for the rule of the spine by search: |gap_medial - gap_lateral|; infinite
/// if the record is not stable or a compartment has no gap.
double imbalance_mm(const StepRecord& record);

/// Whether `a` is the better spine cell: contact of both compartments first, then the smaller imbalance. If
/// both cells have contact on both sides, the one further along Delta, which is where free varus would
/// settle.
bool is_better_balanced(const StepRecord& a, const StepRecord& b);

}  // namespace vrda::solve
