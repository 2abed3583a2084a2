/// Static equilibrium of the moving object under exact contact, loads and ligaments (solve/README.md).
#pragma once

#include <memory>
#include <vector>

#include "model/solver_options.hpp"
#include "model/step_record.hpp"
#include "model/ligaments.hpp"
#include "solve/joint.hpp"

namespace vrda::solve {

/// Solver of one thread for one joint. Scratch memory and hints kept between steps do not affect results.
class EquilibriumSolver {
 public:
  /// `ligaments` are in the solver's frames and may have no fibre. The references must outlive the solver.
  EquilibriumSolver(const Joint& joint, const model::Ligaments& ligaments,
                    const EquilibriumOptions& options);
  ~EquilibriumSolver();
  EquilibriumSolver(EquilibriumSolver&&) noexcept;

  struct Task {
    Attitude attitude;  ///< with free varus, its varus is the seed
    MovingPose seed;
    Loads loads;
    bool is_varus_free = false;
    bool is_measured = true;  ///< false: contacts, gaps and theta_determined are not filled
    /// Results of the same step from other seeds. A step that enters one of these equilibria returns its
    /// record with counts of its own.
    const std::vector<StepRecord>* known = nullptr;
  };

  /// Pure: the same task gives the same bits, independent of earlier steps and, without applied loads, of the
  /// seed's height.
  /// Statuses: `stable` is certified, with `balance`, contacts and gaps filled; `no_contact` if no triangles
  /// face each other at the seed; `unbounded` if the loads move it off the reference; else `iteration_limit`.
  /// Cost on thesis-sized knees: about ten gap queries per step from a seed one degree away.
  /// Applied loads that turn with an object are turned to the pose found and the step is solved again from
  /// there, until generalised forces change by less than 1e-6 of the push: the certificate holds for the
  /// final directions. `iteration_limit` after 50 times. `observer` gets every iterate and rejected trial:
  /// the last iterate is the result.
  StepRecord solve(const Task& task, const SearchObserver& observer = {});

 private:
  struct State;
  class Run;
  StepRecord solve_with_turned_loads(const Task& task, const SearchObserver& observer);
  std::unique_ptr<State> state_;
};

}  // namespace vrda::solve
