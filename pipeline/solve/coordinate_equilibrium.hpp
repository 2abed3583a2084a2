/// Equilibrium with any of the joint's six coordinates held: the others minimise ligament energy minus work
/// of the loads under exact contact. EquilibriumSolver is faster where flexion, or flexion and varus, are
/// held.
#pragma once

#include <array>
#include <memory>

#include "model/solver_options.hpp"
#include "model/step_record.hpp"
#include "model/ligaments.hpp"
#include "solve/joint.hpp"
#include "solve/joint_map.hpp"

namespace vrda::solve {

/// Solver of one thread for one joint. Scratch memory and hints kept between steps do not affect results.
class CoordinateEquilibrium {
 public:
  /// `ligaments` are in the frames of S, which `frame` defines. The references must outlive the solver.
  CoordinateEquilibrium(const Joint& joint, const model::Ligaments& ligaments, const SolverFrame& frame,
                        const EquilibriumOptions& options);
  ~CoordinateEquilibrium();
  CoordinateEquilibrium(CoordinateEquilibrium&&) noexcept;

  struct Task {
    JointCoordinates seed;  ///< held coordinates keep its values
    std::array<bool, n_joint_coordinates> is_free{};
    Loads loads;
    bool is_measured = true;  ///< false: contacts, gaps and what is determined are not filled
  };

  /// Pure: the same task gives the same bits. Statuses: `stable` is certified: the contact forces balance the
  /// free coordinates, and the record's `coordinates` hold the rest. `no_contact` if no triangles face each
  /// other along Delta at the seed; `no_clearance` if the held coordinates make the objects overlap;
  /// `unbounded` if the loads move the object off the reference; else `iteration_limit`.
  /// Each iteration minimises with NLopt (SLSQP) subject to the features of one gap query, extended to planes
  /// and lines; features of rejected trials are added. Every accepted position is free of overlap.
  StepRecord solve(const Task& task);

 private:
  struct State;
  class Run;
  std::unique_ptr<State> state_;
};

}  // namespace vrda::solve
