#include "assemble/case_solver.hpp"

#include "assemble/prepare.hpp"
#include "core/error.hpp"

namespace vrda {
namespace {

// The seed as the frame of another Delta sees it: the place in the world stays, theta is about the other
// Delta.
MovingPose carried(const MovingPose& pose, const SolverFrame& from, const SolverFrame& to)
{
  if (from.delta == to.delta) return pose;
  return {solver_translation_mm(to, world_translation_mm(from, pose)), pose.theta_rad};
}

}  // namespace

SolverFrame frame_at(const Case& job_case, std::int32_t flexion)
{
  SolverFrame frame = job_case.frame;
  frame.delta = job_case.push.at(static_cast<std::size_t>(flexion)).delta;
  return frame;
}

Loads loads_at(const Case& job_case, std::int32_t flexion)
{
  const SolverFrame frame = frame_at(job_case, flexion);
  const Push& push = job_case.push.at(static_cast<std::size_t>(flexion));
  Loads loads;
  loads.force_n = solver_translation_mm(frame, push.force_n);
  loads.point_mm = solver_translation_mm(frame, job_case.push_point_mm);
  loads.moment_nmm = push.moment_nmm;
  loads.varus_moment_nmm = push.varus_moment_nmm;
  return loads;
}

CaseSolver::CaseSolver(const Case& job_case, int n_threads)
    : case_(job_case), workers_(static_cast<std::size_t>(n_threads))
{
  first_ = footing_of(job_case.frame);
}

std::shared_ptr<const CaseSolver::Footing> CaseSolver::footing_of(const SolverFrame& frame)
{
  if (first_ && first_->delta == frame.delta) return first_;
  auto made = std::make_shared<Footing>();
  made->delta = frame.delta;
  made->joint = joint_of(case_, frame);
  made->ligaments = solver_ligaments(case_.ligaments, frame);
  return made;
}

CaseSolver::Worker& CaseSolver::worker_at(int number, const SolverFrame& frame)
{
  Worker& worker = workers_.at(static_cast<std::size_t>(number));
  if (worker.footing && worker.footing->delta == frame.delta) return worker;
  worker.solver.reset();  // it refers to the footing
  worker.footing = footing_of(frame);
  if (case_.method == "equilibrium") {
    worker.solver = std::make_unique<EquilibriumSolver>(worker.footing->joint, worker.footing->ligaments,
                                                        case_.equilibrium);
  }
  return worker;
}

StepRecord CaseSolver::operator()(const StepTask& task, const Watch& watch)
{
  const SolverFrame frame = frame_at(case_, task.key.flexion);
  Worker& worker = worker_at(task.worker, frame);
  const MovingPose seed = carried(task.seed, frame_at(case_, task.seed_flexion), frame);
  if (!worker.solver) {
    check(!task.is_varus_free && task.band == 0, "the stability search holds varus and knows no loads");
    return find_stable_pose(worker.footing->joint, task.attitude, seed, case_.search, watch);
  }
  EquilibriumSolver::Task solve;
  solve.attitude = task.attitude;
  solve.seed = seed;
  solve.loads = loads_at(case_, task.key.flexion);
  solve.loads.moment_nmm += task.band * case_.spine.band_moment_nmm;
  solve.is_varus_free = task.is_varus_free;
  solve.is_measured = task.is_measured;
  return worker.solver->solve(solve);
}

}  // namespace vrda
