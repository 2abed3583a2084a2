/// From a Case to what the solver and the sweep work on, and the steps of a case solved by whichever method
/// its job names.
#pragma once

#include <memory>
#include <vector>

#include "load/case.hpp"
#include "solve/equilibrium.hpp"
#include "solve/joint.hpp"
#include "solve/stability_search.hpp"
#include "sweep/sweep.hpp"

namespace vrda {

/// Both objects as the solver sees them with the Delta of `frame`.
Joint joint_of(const Case& job_case, const SolverFrame& frame);
SweepPlan plan_of(const Case& job_case);

/// One SHA-256 for everything that decides the steps: solver version, resolved job, inputs. Where scaling
/// keeps the steps it is the unscaled job's, so one journal serves every size.
std::string fingerprint_of(const Case& job_case);

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

/// Each record scaled() (core/step_record.hpp), and what lies between them along. Contact alone has no length
/// of its own: where the poses of one joint balance the forces on it, these balance the same forces on one
/// `factor` times as large, whose point of the push moved along. Gaps are `factor` times as wide.
SweepResult scaled(const SweepResult& result, double factor);

}  // namespace vrda
