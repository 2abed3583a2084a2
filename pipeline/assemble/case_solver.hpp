/// Solves the motion steps of a case, by whichever method its job names.
#pragma once

#include <memory>
#include <vector>

#include "load/case.hpp"
#include "solve/equilibrium.hpp"
#include "solve/stability_search.hpp"
#include "sweep/sweep.hpp"

namespace vrda {

/// The frame of the solver at a flexion of the grid: Delta may differ from one to the next.
SolverFrame frame_at(const Case& job_case, std::int32_t flexion);

/// What pushes at a flexion, in the solver's frame there.
Loads loads_at(const Case& job_case, std::int32_t flexion);

/// Shared by the workers of a sweep. Meshes are brought into the solver's frame once for each Delta.
class CaseSolver {
 public:
  /// `job_case` is kept by reference.
  CaseSolver(const Case& job_case, int n_threads);

  /// Called from several threads at once, each with a worker's number of its own. `watch` is for the
  /// stability search only.
  StepRecord operator()(const StepTask& task, const Watch& watch = {});

 private:
  /// Both objects and the ligaments in the frame of one Delta.
  struct Footing {
    Eigen::Vector3d delta;
    Joint joint;
    Ligaments ligaments;
  };
  struct Worker {
    std::shared_ptr<const Footing> footing;
    std::unique_ptr<EquilibriumSolver> solver;
  };

  std::shared_ptr<const Footing> footing_of(const SolverFrame& frame);
  Worker& worker_at(int number, const SolverFrame& frame);

  const Case& case_;
  std::shared_ptr<const Footing> first_;  // of the first flexion, mostly the only one
  std::vector<Worker> workers_;
};

}  // namespace vrda
