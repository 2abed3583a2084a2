#include "solve/case_solver.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "core/error.hpp"
#include "job/input_file.hpp"

namespace vrda::solve {
namespace {

// Must change when the same job may give other bytes: journals of an older solver are then refused.
constexpr const char* search_version = "stability-search 8";
constexpr const char* equilibrium_version = "equilibrium 7";

// Flexion held, varus held or free, the rest free, Delta proximal: what the faster solver solves.
bool is_plain(const job::CoordinateRows& coordinates, const SolverFrame& frame)
{
  const auto& role = coordinates.role;
  return frame.delta == Eigen::Vector3d::UnitY() && role[0] != CoordinateRole::free &&
         std::all_of(role.begin() + 2, role.end(),
                     [](CoordinateRole r) { return r == CoordinateRole::free; });
}

constexpr double lateral_share = 0.01;  // of the search's resolution: error of a given lateral translation

std::vector<double> row_numbers(std::size_t n)
{
  std::vector<double> rows(n);
  std::iota(rows.begin(), rows.end(), 0.0);
  return rows;
}

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

solve::Joint joint_of(const job::Case& job_case, const SolverFrame& frame)
{
  return solve::make_joint(solver_body(job_case.reference, frame), solver_body(job_case.moving, frame),
                           job_case.compartment_of_triangle);
}

InitialBodies initial_bodies_of(const job::Case& job_case)
{
  solve::SolverBody reference = solver_body(job_case.reference, job_case.frame);
  solve::SolverBody moving = solver_body(job_case.moving, job_case.frame);
  const double substep_mm = solve::substep_mm(reference, moving);
  return {geometry::make_tree_mesh(std::move(reference.mesh)),
          geometry::make_tree_mesh(std::move(moving.mesh)), substep_mm};
}

solve::SweepPlan plan_of(const job::Case& job_case)
{
  solve::SweepPlan plan;
  const bool is_sequence = job_case.coordinates && job_case.coordinates->is_sequence();
  plan.flexion_rad =
      is_sequence ? row_numbers(job_case.grid.flexion_deg.size()) : radians(job_case.grid.flexion_deg);
  plan.varus_rad = radians(job_case.grid.varus_deg);
  plan.initial = {solver_translation_mm(job_case.frame, job_case.initial.translation_mm),
                  job_case.initial.theta_rad};
  if (job_case.method == "equilibrium") {
    plan.spine = solve::SpineRule::free_varus;
    if (!is_sequence) plan.path_flexion_rad = radians(job_case.path_flexion_deg);
    plan.is_varus_free = job_case.is_varus_free;
    plan.measures_chosen = job_case.coordinates.has_value();
    // Contact alone hardly resists a moment about Delta: without ligaments a band is meaningless.
    const bool is_internal_free =
        !job_case.coordinates || job_case.coordinates->role[2] == CoordinateRole::free;
    plan.has_band =
        job_case.spine.band_moment_nmm > 0.0 && !job_case.ligaments.fibres.empty() && is_internal_free;
    plan.n_restarts = job_case.spine.n_restarts;
    return plan;
  }
  if (job_case.compartment_of_triangle.empty()) plan.spine = solve::SpineRule::nearest_zero;
  if (!is_sequence) plan.max_seed_step_rad = rad_from_deg(2.0);
  plan.last_resort_thetas_rad = {rad_from_deg(-30.0), rad_from_deg(30.0), rad_from_deg(-60.0),
                                 rad_from_deg(60.0)};
  // Not every command that needs a plan solves steps.
  struct LazyBounds {
    std::once_flag flag;
    JointBounds bounds;
  };
  plan.is_in_joint = [&job_case, lazy = std::make_shared<LazyBounds>()](const MovingPose& pose,
                                                                        std::int32_t path_row) {
    std::call_once(lazy->flag, [&] { lazy->bounds = joint_bounds_of(job_case); });
    return is_within(lazy->bounds, frame_of(job_case, job_case.push.at(static_cast<std::size_t>(path_row))),
                     pose);
  };
  return plan;
}

namespace {

double nearest_to_zero(const std::vector<double>& values)
{
  return *std::min_element(values.begin(), values.end(),
                           [](double a, double b) { return std::abs(a) < std::abs(b); });
}

double smallest_horizontal_extent_mm(const Mesh& mesh)
{
  const Box box = bounding_box(mesh);
  const Eigen::Vector3d extent_mm = box.max_mm - box.min_mm;
  return std::min(extent_mm.x(), extent_mm.z());
}

}  // namespace

JointBounds joint_bounds_of(const job::Case& job_case)
{
  SolverFrame frame = job_case.frame;
  frame.delta = job_case.push_at_meshes.delta;
  const solve::Joint joint = joint_of(job_case, frame);
  JointBounds bounds;
  MovingPose neutral{solver_translation_mm(frame, job_case.initial.translation_mm),
                     job_case.initial.theta_rad};
  geometry::GapQuery gap(joint.reference_gap, joint.moving_gap);
  gap.set_attitude({rad_from_deg(nearest_to_zero(job_case.grid.flexion_deg)),
                    rad_from_deg(nearest_to_zero(job_case.grid.varus_deg))});
  const double travel_mm = gap.next_contact(neutral).travel_mm;
  if (!std::isfinite(travel_mm)) return bounds;
  neutral.translation_mm.y() += travel_mm;
  bounds.neutral_mm = world_translation_mm(frame, neutral);
  bounds.neutral_theta_rad = neutral.theta_rad;
  const double reference_mm = smallest_horizontal_extent_mm(joint.reference.tree_mesh.mesh);
  const double moving_mm = smallest_horizontal_extent_mm(joint.moving.tree_mesh.mesh);
  const bool is_knee = job_case.joint == "knee";
  // A small bone (a patella) may travel by more than its size.
  bounds.max_travel_mm =
      0.5 * (is_knee ? std::min(reference_mm, moving_mm) : std::max(reference_mm, moving_mm));
  bounds.max_theta_rad = rad_from_deg(is_knee ? 45.0 : 90.0);
  return bounds;
}

std::string solver_version_of(const job::Case& job_case)
{
  return job_case.method == "equilibrium" ? equilibrium_version : search_version;
}

namespace {

// Until lateral forces acted across Delta, such jobs gave other steps.
bool has_lateral_force_across(const job::Case& job_case)
{
  if (job_case.method != "equilibrium") return false;
  return std::any_of(job_case.path_push.begin(), job_case.path_push.end(), [](const job::Push& push) {
    constexpr double rounding = 1e-12;
    return push.delta != Eigen::Vector3d::UnitY() &&
           push.force_n.cross(push.delta).norm() > rounding * push.force_n.norm();
  });
}

}  // namespace

std::string fingerprint_of(const job::Case& job_case)
{
  std::string all = solver_version_of(job_case) + '\n' + job_case.steps_job_text;
  if (has_lateral_force_across(job_case)) all += "\nlateral force across Delta";
  for (const job::LoadedInput& input : job_case.inputs) {
    if (input.affects_steps) all += '\n' + input.name + ' ' + input.sha256;
  }
  return job::sha256_of(all);
}

namespace {

// The seed in the frame of another Delta: keeps the world position; theta is then about the other Delta.
MovingPose in_frame_of(const MovingPose& pose, const SolverFrame& from, const SolverFrame& to)
{
  if (from.delta == to.delta) return pose;
  return {solver_translation_mm(to, world_translation_mm(from, pose)), pose.theta_rad};
}

}  // namespace

SolverFrame frame_of(const job::Case& job_case, const job::Push& push)
{
  SolverFrame frame = job_case.frame;
  frame.delta = push.delta;
  return frame;
}

Loads loads_of(const job::Case& job_case, const job::Push& push)
{
  const SolverFrame frame = frame_of(job_case, push);
  Loads loads;
  loads.force_n = solver_translation_mm(frame, push.force_n);
  loads.point_mm = solver_translation_mm(frame, job_case.push_point_mm);
  loads.moment_nmm = push.moment_nmm;
  loads.varus_moment_nmm = push.varus_moment_nmm;
  for (std::size_t k = 0; k < job_case.loads.size(); ++k) {
    const job::LoadPoint& load = job_case.loads[k];
    loads.applied.push_back({load.frame, solver_translation_mm(frame, push.load_force_n.at(k)),
                             solver_moment_nmm(frame, push.load_moment_nmm.at(k)),
                             solver_translation_mm(frame, load.point_mm)});
  }
  for (std::size_t k = 0; k < job_case.lines.size(); ++k) {
    const job::LinePath& line = job_case.lines[k];
    loads.lines.push_back({push.line_tension_n.at(k), solver_translation_mm(frame, line.reference_mm.back()),
                           solver_translation_mm(frame, line.moving_mm.front())});
  }
  return loads;
}

CaseSolver::CaseSolver(const job::Case& job_case, int n_threads, std::shared_ptr<const solve::Joint> joint)
    : case_(job_case), workers_(static_cast<std::size_t>(n_threads))
{
  first_ = push_frame_of(job_case.frame, std::move(joint));
}

std::shared_ptr<const CaseSolver::PushFrame> CaseSolver::push_frame_of(
    const SolverFrame& frame, std::shared_ptr<const solve::Joint> joint)
{
  if (first_ && first_->delta == frame.delta) return first_;
  auto made = std::make_shared<PushFrame>();
  made->delta = frame.delta;
  made->joint = joint ? std::move(joint) : std::make_shared<const solve::Joint>(joint_of(case_, frame));
  made->ligaments = model::solver_ligaments(case_.ligaments, frame);
  return made;
}

CaseSolver::Worker& CaseSolver::worker_at(int number, const SolverFrame& frame)
{
  Worker& worker = workers_.at(static_cast<std::size_t>(number));
  if (worker.push_frame && worker.push_frame->delta == frame.delta) return worker;
  worker.solver.reset();  // it refers to the push frame
  worker.push_frame = push_frame_of(frame);
  worker.coordinates.reset();
  if (case_.method != "equilibrium") return worker;
  if (case_.coordinates) {
    worker.coordinates = std::make_unique<solve::CoordinateEquilibrium>(
        *worker.push_frame->joint, worker.push_frame->ligaments, frame, case_.equilibrium);
  }
  worker.solver = std::make_unique<solve::EquilibriumSolver>(*worker.push_frame->joint,
                                                             worker.push_frame->ligaments, case_.equilibrium);
  return worker;
}

JointCoordinates CaseSolver::seed_coordinates(const solve::StepTask& task, const MovingPose& seed,
                                              const solve::JointMap& map) const
{
  const JointCoordinates& row = case_.coordinates->rows.at(static_cast<std::size_t>(task.path_row));
  // The start pose of the job is in the world frame at the attitude of the row.
  const Attitude start{std::isnan(row(0)) ? 0.0 : row(0), std::isnan(row(1)) ? 0.0 : row(1)};
  JointCoordinates coordinates = map.coordinates_at({task.seed_attitude.value_or(start), seed});
  if (case_.coordinates->role[1] == CoordinateRole::driven) coordinates(1) = task.attitude.varus_rad;
  for (Eigen::Index k = 0; k < coordinates.size(); ++k) {
    if (!std::isnan(row(k))) coordinates(k) = row(k);
  }
  return coordinates;
}

StepRecord CaseSolver::solve_coordinates(const solve::StepTask& task, const MovingPose& seed,
                                         const SolverFrame& frame, const Loads& loads,
                                         solve::CoordinateEquilibrium& solver) const
{
  solve::CoordinateEquilibrium::Task solve;
  solve.seed = seed_coordinates(task, seed, solve::JointMap(frame));
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    solve.is_free[k] = case_.coordinates->role[k] == CoordinateRole::free;
  solve.loads = loads;
  solve.is_measured = task.is_measured;
  return solver.solve(solve);
}

StepRecord CaseSolver::solve_plain(const solve::StepTask& task, const MovingPose& seed,
                                   const SolverFrame& frame, const Loads& loads,
                                   solve::EquilibriumSolver& solver) const
{
  const solve::JointMap map(frame);
  const SolverPosition start = map.position_at(seed_coordinates(task, seed, map));
  solve::EquilibriumSolver::Task solve;
  solve.attitude = start.attitude;
  solve.seed = start.pose;
  solve.loads = loads;
  solve.is_varus_free = case_.coordinates->role[1] == CoordinateRole::free;
  solve.is_measured = false;
  solve.known = task.known;
  StepRecord record = solver.solve(solve);
  record.flexion_rad = start.attitude.flexion_rad;
  record.coordinates = CoordinateForces{};
  return record;
}

// Delta is proximal (load/coordinates), so the search's theta is the internal rotation, its x the anterior
// translation. The lateral translation is along the flexion axis, so with varus it follows the height.
StepRecord CaseSolver::search_coordinates(const solve::StepTask& task, const MovingPose& seed,
                                          const SolverFrame& frame, const solve::Joint& joint,
                                          const SearchObserver& observer) const
{
  constexpr int most_corrections = 8;
  const std::array<CoordinateRole, n_joint_coordinates>& role = case_.coordinates->role;
  const auto is_given = [&](JointCoordinate k) {
    return role[static_cast<std::size_t>(k)] != CoordinateRole::free;
  };
  const solve::JointMap map(frame);
  SearchOptions options = case_.search;
  options.held = {is_given(JointCoordinate::anterior), is_given(JointCoordinate::lateral),
                  is_given(JointCoordinate::internal)};
  JointCoordinates start = seed_coordinates(task, seed, map);
  const double lateral_mm = start(row_of(JointCoordinate::lateral));
  StepRecord record;
  for (int k = 0; k < most_corrections; ++k) {
    const SolverPosition at = map.position_at(start);
    record = solve::find_stable_pose(joint, at.attitude, at.pose, options, observer);
    record.flexion_rad = at.attitude.flexion_rad;
    record.coordinates = CoordinateForces{};
    record.coordinates->holding.fill(nan);
    if (!options.held.theta) record.coordinates->determined[2] = record.theta_determined ? 1 : 0;
    start = map.coordinates_at({at.attitude, record.pose});
    const double error_mm = start(row_of(JointCoordinate::lateral)) - lateral_mm;
    if (!options.held.z || record.status != StepStatus::stable ||
        std::abs(error_mm) <= lateral_share * options.translation_resolution_mm)
      break;
    start(row_of(JointCoordinate::lateral)) = lateral_mm;
  }
  return record;
}

StepRecord CaseSolver::operator()(const solve::StepTask& task, const SearchObserver& observer)
{
  const job::Push& push = case_.path_push.at(static_cast<std::size_t>(task.path_row));
  const SolverFrame frame = frame_of(case_, push);
  Worker& worker = worker_at(task.worker, frame);
  const MovingPose seed = in_frame_of(
      task.seed, frame_of(case_, case_.path_push.at(static_cast<std::size_t>(task.seed_path_row))), frame);
  Loads loads = loads_of(case_, push);
  loads.moment_nmm += task.band * case_.spine.band_moment_nmm;
  if (worker.coordinates) {
    return task.is_measured || !is_plain(*case_.coordinates, frame)
               ? solve_coordinates(task, seed, frame, loads, *worker.coordinates)
               : solve_plain(task, seed, frame, loads, *worker.solver);
  }
  if (case_.coordinates) return search_coordinates(task, seed, frame, *worker.push_frame->joint, observer);
  if (!worker.solver) {
    check(!task.is_varus_free && task.band == 0, "the stability search has fixed varus and no loads");
    return solve::find_stable_pose(*worker.push_frame->joint, task.attitude, seed, case_.search, observer);
  }
  solve::EquilibriumSolver::Task solve;
  solve.attitude = task.attitude;
  solve.seed = seed;
  solve.loads = loads;
  solve.is_varus_free = task.is_varus_free;
  solve.is_measured = task.is_measured;
  solve.known = task.known;
  return worker.solver->solve(solve, observer);
}

solve::SweepResult scaled(const solve::SweepResult& result, double factor)
{
  solve::SweepResult out = result;
  for (StepRecord& r : out.cells) r = scaled(r, factor);
  for (solve::FreeSpineStep& step : out.free_spine) {
    step.chosen = scaled(step.chosen, factor);
    step.band_low = scaled(step.band_low, factor);
    step.band_high = scaled(step.band_high, factor);
    step.energy_spread_nmm *= factor;
  }
  return out;
}

}  // namespace vrda::solve
