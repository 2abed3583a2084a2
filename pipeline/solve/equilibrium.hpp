/// Where the moving object comes to rest under exact contact, loads and ligaments (DESIGN.md 5.3).
#pragma once

#include <memory>

#include "core/solver_options.hpp"
#include "core/step_record.hpp"
#include "ligament/ligaments.hpp"
#include "solve/joint.hpp"

namespace vrda {

/// One thread's tools for one joint: scratch and hints that outlive a motion step. They change the time,
/// never the answer.
class EquilibriumSolver {
 public:
  /// `ligaments` are in the solver's frames and may hold no fibre. References are kept.
  EquilibriumSolver(const Joint& joint, const Ligaments& ligaments, const EquilibriumOptions& options);
  ~EquilibriumSolver();
  EquilibriumSolver(EquilibriumSolver&&) noexcept;

  struct Task {
    Attitude attitude;  ///< where varus is free: its seed
    MovingPose seed;
    Loads loads;
    bool is_varus_free = false;
    bool is_measured = true;  ///< false: contacts, gaps and theta_determined are not asked for
  };

  /// A pure function of the task: same task, same bits, whatever was solved before. The seed's height does
  /// not matter. Statuses: `stable` is certified, with `balance`, contacts and gaps filled; `no_contact` when
  /// nothing faces at the seed; `unbounded` when the loads carry it off the reference; else
  /// `iteration_limit`. Cost on thesis-sized knees: about ten gap queries a step with a seed a degree away.
  StepRecord solve(const Task& task);

 private:
  struct State;
  class Run;
  std::unique_ptr<State> state_;
};

}  // namespace vrda
