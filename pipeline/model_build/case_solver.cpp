#include "model_build/case_solver.hpp"

#include "core/error.hpp"
#include "load/file_bytes.hpp"

namespace vrda::model_build {
namespace {

// Must change when the same job may give other bytes: journals of an older solver are then refused.
constexpr const char* search_version = "stability-search 3";
constexpr const char* equilibrium_version = "equilibrium 3";

solve::SolverBody solver_body(const Body& body, const SolverFrame& frame)
{
  return {solver_mesh(body.contact.mesh, frame), body.contact.component};
}

std::vector<double> radians(const std::vector<double>& degrees)
{
  std::vector<double> result;
  result.reserve(degrees.size());
  for (const double value : degrees) result.push_back(rad_from_deg(value));
  return result;
}

}  // namespace

solve::Joint joint_of(const load::Case& job_case, const SolverFrame& frame)
{
  return solve::make_joint(solver_body(job_case.reference, frame), solver_body(job_case.moving, frame),
                           job_case.compartment_of_triangle);
}

sweep::SweepPlan plan_of(const load::Case& job_case)
{
  sweep::SweepPlan plan;
  plan.flexion_rad = radians(job_case.grid.flexion_deg);
  plan.varus_rad = radians(job_case.grid.varus_deg);
  plan.initial = {solver_translation_mm(job_case.frame, job_case.initial.translation_mm),
                  job_case.initial.theta_rad};
  if (job_case.method == "equilibrium") {
    plan.spine = sweep::SpineRule::free_varus;
    plan.path_flexion_rad = radians(job_case.path_flexion_deg);
    plan.is_varus_free = job_case.is_varus_free;
    // Contact alone hardly resists a moment about Delta: without ligaments a band is meaningless.
    plan.has_band = job_case.spine.band_moment_nmm > 0.0 && !job_case.ligaments.fibres.empty();
    plan.n_restarts = job_case.spine.n_restarts;
  } else if (job_case.compartment_of_triangle.empty()) {
    plan.spine = sweep::SpineRule::nearest_zero;
  }
  return plan;
}

std::string fingerprint_of(const load::Case& job_case)
{
  const char* version = job_case.method == "equilibrium" ? equilibrium_version : search_version;
  std::string all = std::string(version) + '\n' + job_case.steps_job_text;
  for (const load::LoadedInput& input : job_case.inputs) {
    if (input.affects_steps) all += '\n' + input.name + ' ' + input.sha256;
  }
  return load::sha256_of(all);
}

namespace {

// The seed in the frame of another Delta: keeps the world position; theta is then about the other Delta.
MovingPose in_frame_of(const MovingPose& pose, const SolverFrame& from, const SolverFrame& to)
{
  if (from.delta == to.delta) return pose;
  return {solver_translation_mm(to, world_translation_mm(from, pose)), pose.theta_rad};
}

}  // namespace

SolverFrame frame_of(const load::Case& job_case, const load::Push& push)
{
  SolverFrame frame = job_case.frame;
  frame.delta = push.delta;
  return frame;
}

Loads loads_of(const load::Case& job_case, const load::Push& push)
{
  const SolverFrame frame = frame_of(job_case, push);
  Loads loads;
  loads.force_n = solver_translation_mm(frame, push.force_n);
  loads.point_mm = solver_translation_mm(frame, job_case.push_point_mm);
  loads.moment_nmm = push.moment_nmm;
  loads.varus_moment_nmm = push.varus_moment_nmm;
  return loads;
}

CaseSolver::CaseSolver(const load::Case& job_case, int n_threads)
    : case_(job_case), workers_(static_cast<std::size_t>(n_threads))
{
  first_ = push_frame_of(job_case.frame);
}

std::shared_ptr<const CaseSolver::PushFrame> CaseSolver::push_frame_of(const SolverFrame& frame)
{
  if (first_ && first_->delta == frame.delta) return first_;
  auto made = std::make_shared<PushFrame>();
  made->delta = frame.delta;
  made->joint = joint_of(case_, frame);
  made->ligaments = ligament::solver_ligaments(case_.ligaments, frame);
  return made;
}

CaseSolver::Worker& CaseSolver::worker_at(int number, const SolverFrame& frame)
{
  Worker& worker = workers_.at(static_cast<std::size_t>(number));
  if (worker.push_frame && worker.push_frame->delta == frame.delta) return worker;
  worker.solver.reset();  // it refers to the push frame
  worker.push_frame = push_frame_of(frame);
  if (case_.method == "equilibrium") {
    worker.solver = std::make_unique<solve::EquilibriumSolver>(
        worker.push_frame->joint, worker.push_frame->ligaments, case_.equilibrium);
  }
  return worker;
}

StepRecord CaseSolver::operator()(const sweep::StepTask& task, const solve::SearchObserver& observer)
{
  const load::Push& push = case_.path_push.at(static_cast<std::size_t>(task.path_row));
  const SolverFrame frame = frame_of(case_, push);
  Worker& worker = worker_at(task.worker, frame);
  const MovingPose seed = in_frame_of(
      task.seed, frame_of(case_, case_.path_push.at(static_cast<std::size_t>(task.seed_path_row))), frame);
  if (!worker.solver) {
    check(!task.is_varus_free && task.band == 0, "the stability search has fixed varus and no loads");
    return solve::find_stable_pose(worker.push_frame->joint, task.attitude, seed, case_.search, observer);
  }
  solve::EquilibriumSolver::Task solve;
  solve.attitude = task.attitude;
  solve.seed = seed;
  solve.loads = loads_of(case_, push);
  solve.loads.moment_nmm += task.band * case_.spine.band_moment_nmm;
  solve.is_varus_free = task.is_varus_free;
  solve.is_measured = task.is_measured;
  return worker.solver->solve(solve);
}

sweep::SweepResult scaled(const sweep::SweepResult& result, double factor)
{
  sweep::SweepResult out = result;
  for (StepRecord& r : out.cells) r = scaled(r, factor);
  for (sweep::FreeSpineStep& step : out.free_spine) {
    step.chosen = scaled(step.chosen, factor);
    step.band_low = scaled(step.band_low, factor);
    step.band_high = scaled(step.band_high, factor);
    step.energy_spread_nmm *= factor;
  }
  return out;
}

}  // namespace vrda::model_build
