#include "solve/case_solver.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job.hpp"
#include "model/frames.hpp"
#include "solve/followers.hpp"
#include "solve/prior.hpp"
#include "store/solved_cells.hpp"

namespace vrda::solve {
namespace {

// Must change when the same job may give other bytes: journals of an older solver are then refused.
constexpr const char* search_version = "stability-search 8";
constexpr const char* equilibrium_version = "equilibrium 7";
constexpr const char* compliant_version = "equilibrium 7, compliant contact 3";

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

}  // namespace

solve::Joint joint_of(const job::Case& job_case, const SolverFrame& frame)
{
  return solve::make_joint(solver_body(job_case.reference, frame), solver_body(job_case.moving, frame),
                           job_case.compartment_of_triangle);
}

solve::Joint joint_like(const solve::Joint& joint, const job::Case& job_case, const SolverFrame& frame)
{
  const solve::SolverBody moving = solver_body(job_case.moving, frame);
  const Mesh& known = joint.moving.tree_mesh.mesh;
  const bool is_same = known.vertices_mm == moving.mesh.vertices_mm &&
                       known.triangles == moving.mesh.triangles && known.offset_mm == moving.mesh.offset_mm;
  if (!is_same) return joint_of(job_case, frame);
  const solve::SolverBody reference = solver_body(job_case.reference, frame);
  solve::Joint like = joint;
  like.reference = contact::make_collider(reference.mesh);
  like.reference_gap = geometry::GapTree(reference.mesh);
  like.reference_protrudes =
      contact::protruding_vertices(like.reference.tree_mesh.mesh, like.reference.features);
  like.substep_mm = solve::substep_mm(reference, moving);
  return like;
}

InitialBodies initial_bodies_of(const job::Case& job_case)
{
  solve::SolverBody reference = solver_body(job_case.reference, job_case.frame);
  solve::SolverBody moving = solver_body(job_case.moving, job_case.frame);
  const double substep_mm = solve::substep_mm(reference, moving);
  return {geometry::make_tree_mesh(std::move(reference.mesh)),
          geometry::make_tree_mesh(std::move(moving.mesh)), substep_mm};
}

namespace {

double total_force_n(const job::Push& push)
{
  double sum_n = push.force_n.norm();
  for (const Eigen::Vector3d& force_n : push.load_force_n) sum_n += force_n.norm();
  for (const double tension_n : push.line_tension_n) sum_n += tension_n;
  return sum_n;
}

solve::ChangePenalty change_penalty_of(const job::Case& job_case)
{
  // Not every command that needs a plan solves steps.
  struct LazyScale {
    std::once_flag flag;
    RotationScale scale;
  };
  return [&job_case, lazy = std::make_shared<LazyScale>()](const PathPoint& from, const PathPoint& to) {
    std::call_once(lazy->flag, [&] {
      lazy->scale = rotation_scale_of(solver_mesh(job_case.moving.contact.mesh, job_case.frame));
    });
    const auto push_at = [&](const PathPoint& point) -> const job::Push& {
      return job_case.path_push.at(static_cast<std::size_t>(point.path_row));
    };
    // In world axes, since Delta may differ.
    const auto middle_mm = [&](const PathPoint& point) {
      const Configuration at = configuration_at(point.pose, point.varus_rad, lazy->scale);
      return world_translation_mm(frame_of(job_case, push_at(point)), {at.pivot_mm, 0.0});
    };
    const double turned_mm =
        lazy->scale.lever_mm *
        Eigen::Vector2d(to.pose.theta_rad - from.pose.theta_rad, to.varus_rad - from.varus_rad).norm();
    const double change_sq_mm2 = (middle_mm(to) - middle_mm(from)).squaredNorm() + turned_mm * turned_mm;
    return total_force_n(push_at(to)) *
           std::min(change_sq_mm2 / (2.0 * solve::path_compliance_mm), 0.5 * solve::most_path_work_mm);
  };
}

}  // namespace

solve::SweepPlan plan_of(const job::Case& job_case)
{
  solve::SweepPlan plan;
  const bool is_sequence = job_case.coordinates && job_case.coordinates->is_sequence();
  plan.flexion_rad =
      is_sequence ? row_numbers(job_case.grid.flexion_deg.size()) : radians(job_case.grid.flexion_deg);
  plan.varus_rad = radians(job_case.grid.varus_deg);
  plan.initial = {solver_translation_mm(job_case.frame, job_case.initial.translation_mm),
                  job_case.initial.theta_rad};
  if (!job_case.followers.empty()) {
    plan.follow = [&job_case](const SweepPlan& whole, const SolveStep& solve, const SweepHooks& hooks,
                              int n_threads, SweepResult& result) {
      return follow(job_case, whole, solve, hooks, n_threads, result);
    };
  }
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
    plan.has_facets = job_case.equilibrium.contact_stiffness_n_per_mm3 == 0.0;
    plan.prior = job_case.prior;
    plan.band_moment_nmm = job_case.spine.band_moment_nmm;
    if (job_case.spine.branch == BranchRule::continuous)
      plan.change_penalty_nmm = change_penalty_of(job_case);
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
  if (job_case.method != "equilibrium") return search_version;
  return job_case.equilibrium.contact_stiffness_n_per_mm3 > 0.0 ? compliant_version : equilibrium_version;
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
  if (!job_case.followers.empty() && job_case.spine.branch == BranchRule::continuous)
    all += "\ncontinuous path of followers";
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
  record.coordinates = CoordinateForces{};
  record.coordinates->flexion_rad = start.attitude.flexion_rad;
  return record;
}

// Delta is proximal (job/coordinates), so the search's theta is the internal rotation, its x the anterior
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
    record.coordinates = CoordinateForces{};
    record.coordinates->flexion_rad = at.attitude.flexion_rad;
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

// The cell solved again, with the fibres of its followers beside its own.
StepRecord CaseSolver::solve_with_followers(const solve::StepTask& task, const MovingPose& seed,
                                            const SolverFrame& frame, Loads loads, const Worker& worker) const
{
  const model::Ligaments further = model::solver_ligaments(task.followers->fibres, frame);
  model::Ligaments ligaments = worker.push_frame->ligaments;
  if (ligaments.fibres.empty()) ligaments.transition_strain = further.transition_strain;
  const auto first_wrap = static_cast<int>(ligaments.wraps.size());
  ligaments.wraps.insert(ligaments.wraps.end(), further.wraps.begin(), further.wraps.end());
  for (model::Fibre fibre : further.fibres) {
    if (fibre.wrap >= 0) fibre.wrap += first_wrap;
    ligaments.fibres.push_back(std::move(fibre));
  }
  loads.applied.insert(loads.applied.end(), task.followers->loads.begin(), task.followers->loads.end());
  if (case_.coordinates) {
    solve::CoordinateEquilibrium solver(*worker.push_frame->joint, ligaments, frame, case_.equilibrium);
    return solve_coordinates(task, seed, frame, loads, solver);
  }
  solve::EquilibriumSolver::Task solve;
  solve.attitude = task.attitude;
  solve.seed = seed;
  solve.loads = std::move(loads);
  solve.is_varus_free = task.is_varus_free;
  return solve::EquilibriumSolver(*worker.push_frame->joint, ligaments, case_.equilibrium).solve(solve);
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
  loads.springs = task.springs;
  if (task.followers != nullptr) return solve_with_followers(task, seed, frame, std::move(loads), worker);
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
  for (std::vector<StepRecord>& cell : out.followers) {
    for (StepRecord& r : cell) r = scaled(r, factor);
  }
  for (solve::FreeSpineStep& step : out.free_spine) {
    step.chosen = scaled(step.chosen, factor);
    step.band_low = scaled(step.band_low, factor);
    step.band_high = scaled(step.band_high, factor);
    step.energy_spread_nmm *= factor;
  }
  return out;
}

namespace {

void append_row(std::vector<double>& rows, const Eigen::Vector3d& v)
{
  rows.insert(rows.end(), v.begin(), v.end());
}

store::LoadRows load_rows(const job::Case& job_case)
{
  store::LoadRows rows;
  rows.point_mm.resize(static_cast<Eigen::Index>(job_case.loads.size()), 3);
  for (const job::LoadPoint& load : job_case.loads) {
    rows.point_mm.row(static_cast<Eigen::Index>(rows.name.size())) = load.point_mm.transpose();
    rows.name.push_back(load.name);
    // The file counts world, reference, moving from 0 (FlagSet::load_frame); BodyIndex has world at -1.
    rows.frame.push_back(static_cast<std::int8_t>(static_cast<int>(load.frame) + 1));
  }
  for (const job::Push& push : job_case.push) {
    for (const Eigen::Vector3d& force_n : push.load_force_n) append_row(rows.force_n, force_n);
    for (const Eigen::Vector3d& moment_nmm : push.load_moment_nmm) append_row(rows.moment_nmm, moment_nmm);
  }
  return rows;
}

store::LineRows line_rows(const job::Case& job_case)
{
  store::LineRows rows;
  std::vector<Eigen::Vector3d> points;
  for (const job::LinePath& line : job_case.lines) {
    for (const auto* of_body : {&line.reference_mm, &line.moving_mm}) {
      points.insert(points.end(), of_body->begin(), of_body->end());
      rows.point_line.resize(points.size(), static_cast<std::int32_t>(rows.name.size()));
      rows.point_body.resize(points.size(), of_body == &line.moving_mm ? 1 : 0);
    }
    rows.name.push_back(line.name);
  }
  rows.point_mm.resize(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t k = 0; k < points.size(); ++k)
    rows.point_mm.row(static_cast<Eigen::Index>(k)) = points[k].transpose();
  for (const job::Push& push : job_case.push)
    rows.tension_n.insert(rows.tension_n.end(), push.line_tension_n.begin(), push.line_tension_n.end());
  return rows;
}

store::PushRows push_rows(const job::Case& job_case)
{
  store::PushRows rows;
  const auto n = static_cast<Eigen::Index>(job_case.push.size());
  rows.delta.resize(n, 3);
  rows.force_n.resize(n, 3);
  for (Eigen::Index i = 0; i < n; ++i) {
    const job::Push& push = job_case.push[static_cast<std::size_t>(i)];
    rows.delta.row(i) = push.delta.transpose();
    rows.force_n.row(i) = push.force_n.transpose();
    rows.moment_nmm.push_back(push.moment_nmm);
    rows.varus_moment_nmm.push_back(push.varus_moment_nmm);
  }
  rows.point_mm = job_case.push_point_mm;
  if (!job_case.loads.empty()) rows.loads = load_rows(job_case);
  if (!job_case.lines.empty()) rows.lines = line_rows(job_case);
  return rows;
}

store::FollowerRows follower_rows(const job::Follower& follower, std::size_t row)
{
  store::FollowerRows rows;
  rows.name = follower.name;
  rows.body_index = static_cast<std::int32_t>(model::follower_index(row));
  rows.of = static_cast<std::int32_t>(follower.of);
  for (const BodyIndex body : follower.touches) rows.touches.push_back(static_cast<std::int8_t>(body));
  if (follower.touches_visual) rows.touches_drawn.assign(rows.touches.size(), 1);
  rows.centre_mm = follower.centre_mm;
  rows.delta = follower.delta;
  rows.push_n = follower.push_n;
  rows.has_reaction = follower.has_reaction;
  rows.body = follower.body;
  rows.body.name = follower.name;
  if (follower.ligaments.fibres.empty()) return rows;
  rows.ligaments = ligament_rows(follower.ligaments);
  for (const model::Fibre& fibre : follower.ligaments.fibres) {
    rows.ligaments->from_body.push_back(static_cast<std::int8_t>(fibre.from));
    rows.ligaments->to_body.push_back(static_cast<std::int8_t>(fibre.to));
    rows.ligaments->constant_tension_n.push_back(fibre.tension_n);
  }
  return rows;
}

store::MotionModel pending_model_at_size(const job::Case& job_case)
{
  store::MotionModel model;
  model.title = job_case.title;
  model.joint = job_case.joint;
  model.side = side_name(job_case.frame.side);
  model.method = job_case.method;
  model.rotation_centre_mm = job_case.frame.rotation_centre_mm;
  model.delta = job_case.frame.delta;
  model.push = push_rows(job_case);
  model.contact_resolution_mm = job_case.method == "equilibrium" ? job_case.equilibrium.contact_resolution_mm
                                                                 : job_case.search.translation_resolution_mm;
  model.has_compartments = !job_case.compartment_of_triangle.empty();
  for (const Compartment compartment : job_case.compartment_of_triangle)
    model.compartment_of_triangle.push_back(static_cast<std::int8_t>(compartment));
  model.flexion_deg = job_case.grid.flexion_deg;
  model.varus_deg = job_case.grid.varus_deg;
  if (job_case.coordinates && job_case.coordinates->is_sequence())
    model.frames = {job_case.coordinates->key_name, job_case.coordinates->key};
  model.reference = job_case.reference;
  model.moving = job_case.moving;
  model.job = {job_case.job_text, job_case.resolved_job, {}, job_case.scaling, job_case.warnings};
  for (const job::LoadedInput& input : job_case.inputs)
    model.job.inputs.push_back({input.name, input.sha256});
  if (job_case.method == "equilibrium") {
    model.equilibrium.emplace();
    model.equilibrium->band_moment_nmm = plan_of(job_case).has_band ? job_case.spine.band_moment_nmm : 0.0;
  }
  if (job_case.coordinates) {
    model.coordinates.emplace();
    for (const CoordinateRole role : job_case.coordinates->role)
      model.coordinates->role.push_back(static_cast<std::int8_t>(role));
  }
  if (!job_case.ligaments.fibres.empty()) model.ligaments = ligament_rows(job_case.ligaments);
  for (std::size_t k = 0; k < job_case.followers.size(); ++k)
    model.followers.push_back(follower_rows(job_case.followers[k], k));
  std::sort(model.followers.begin(), model.followers.end(),
            [](const auto& a, const auto& b) { return a.name < b.name; });
  if (model.has_compartments) model.contact_paths.emplace();
  return store::with_pending_cells(std::move(model));
}

// The cells of one follower.
class FollowerAssembly {
 public:
  FollowerAssembly(store::FollowerRows& rows, const job::Case& job_case)
      : rows_(rows),
        case_(job_case),
        row_(static_cast<std::size_t>(rows.body_index) - 2),
        follower_(job_case.followers.at(row_)),
        frame_(follower_frame(job_case, follower_))
  {
    rows_.forces.row_start = {0};
    rows_.forces.point_world_mm.resize(0, 3);
    rows_.forces.normal_world.resize(0, 3);
  }

  // `placed` are the bodies before it; gets its own pose.
  void add(std::size_t cell, const StepRecord& r, model::BodyPoses& placed)
  {
    rows_.status.data()[cell] = static_cast<std::int8_t>(r.status);
    rows_.iterations.data()[cell] = r.iterations;
    rows_.queries.data()[cell] = r.queries;
    if (r.status == StepStatus::stable && placed.size() == 2 + row_) add_stable(cell, r, placed);
    rows_.forces.row_start.push_back(static_cast<std::int64_t>(rows_.forces.along_delta_n.size()));
  }

  void finish()
  {
    for (auto* points : {&points_, &normals_}) {
      auto& out = points == &points_ ? rows_.forces.point_world_mm : rows_.forces.normal_world;
      out.resize(static_cast<Eigen::Index>(points->size()), 3);
      for (std::size_t k = 0; k < points->size(); ++k)
        out.row(static_cast<Eigen::Index>(k)) = (*points)[k].transpose();
    }
  }

 private:
  void add_stable(std::size_t cell, const StepRecord& r, model::BodyPoses& placed)
  {
    const Pose X = follower_pose_of(frame_, r);
    placed.push_back(placed.at(model::row_of(follower_.of)) * X);
    const auto q = in_files(follower_coordinates(X, case_.frame.side, follower_.centre_mm));
    for (std::size_t k = 0; k < q.size(); ++k) rows_.coordinates[k].data()[cell] = q[k];
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j)
        rows_.X_of_follower[16 * cell + 4 * static_cast<std::size_t>(i) + static_cast<std::size_t>(j)] =
            X.matrix()(i, j);
    }
    rows_.energy_nmm.data()[cell] = r.balance.energy_nmm;
    rows_.balance_residual_n.data()[cell] = r.balance.residual_n;
    rows_.complementarity_mm.data()[cell] = r.balance.complementarity_mm;
    rows_.worst_gap_mm.data()[cell] = r.balance.worst_gap_mm;
    const Attitude attitude{r.coordinates->flexion_rad, r.varus_rad};
    const Eigen::Matrix3d to_of = reference_rotation(attitude).transpose();
    for (const ContactForce& f : r.balance.forces) {
      points_.push_back(world_from_solver(frame_, to_of * f.point_solver_mm) + follower_.centre_mm);
      normals_.push_back(world_from_solver(frame_, to_of * f.normal_solver).normalized());
      rows_.forces.along_delta_n.push_back(f.along_delta_n);
      rows_.forces.triangle_reference.push_back(f.triangle_reference);
      rows_.forces.triangle_moving.push_back(f.triangle_moving);
      rows_.forces.compartment.push_back(0);
    }
    if (rows_.ligaments) add_fibres(cell, attitude, r.pose, placed);
  }

  void add_fibres(std::size_t cell, const Attitude& attitude, const MovingPose& pose,
                  const model::BodyPoses& placed)
  {
    const model::Ligaments between = model::solver_ligaments(
        model::ligaments_between(follower_.ligaments, follower_.of, model::follower_index(row_), placed),
        frame_);
    const std::vector<model::FibreState> states = model::fibre_states(between, attitude, pose);
    for (std::size_t k = 0; k < states.size(); ++k) {
      const std::size_t at = cell * states.size() + k;
      rows_.ligaments->length_mm[at] = states[k].length_mm;
      rows_.ligaments->strain[at] = states[k].strain;
      rows_.ligaments->tension_n[at] = states[k].force_n;
      rows_.ligaments->energy_nmm[at] = states[k].energy_nmm;
      rows_.ligaments->is_wrapped[at] = states[k].is_wrapped ? 1 : 0;
    }
  }

  store::FollowerRows& rows_;
  const job::Case& case_;
  std::size_t row_;
  const job::Follower& follower_;
  SolverFrame frame_;
  std::vector<Eigen::Vector3d> points_, normals_;
};

}  // namespace

void add_followers(store::MotionModel& model, const job::Case& job_case, const solve::SweepResult& result)
{
  if (model.followers.empty()) return;
  std::vector<FollowerAssembly> by_row;
  for (std::size_t k = 0; k < model.followers.size(); ++k) {
    const auto own = std::find_if(model.followers.begin(), model.followers.end(), [&](const auto& rows) {
      return rows.body_index == static_cast<std::int32_t>(model::follower_index(k));
    });
    by_row.emplace_back(*own, job_case);
  }
  for (std::size_t c = 0; c < result.cells.size(); ++c) {
    model::BodyPoses placed{Pose::Identity()};
    if (result.cells[c].status == StepStatus::stable)
      placed.push_back(joint_pose_of(job_case, result.cells[c]));
    for (std::size_t k = 0; k < by_row.size(); ++k) {
      const bool is_solved = c < result.followers.size() && k < result.followers[c].size();
      StepRecord record = is_solved ? result.followers[c][k] : StepRecord{};
      // The check of poses may have found the joint overlapping.
      if (result.cells[c].status != StepStatus::stable) record.status = result.cells[c].status;
      by_row[k].add(c, record, placed);
    }
  }
  for (FollowerAssembly& assembly : by_row) assembly.finish();
}

namespace {

store::MotionModel motion_model_at_size(const job::Case& job_case, const solve::SweepResult& result)
{
  store::MotionModel model = pending_model_at_size(job_case);
  for (const StepRecord& r : result.cells) {
    // The flexion of a frame belongs to its pose.
    if (r.coordinates && job_case.coordinates->is_sequence())
      model.flexion_deg[static_cast<std::size_t>(r.key.flexion)] = deg_from_rad(r.coordinates->flexion_rad);
    store::set_cell(model, r);
  }
  for (std::size_t i = 0; i < result.spine_column.size(); ++i) {
    if (result.spine_column[i] >= 0) model.is_spine(static_cast<Eigen::Index>(i), result.spine_column[i]) = 1;
  }
  model.contacts = store::contact_rows(model, result.cells);
  add_balance(model, job_case, result);
  add_followers(model, job_case, result);
  return model;
}

}  // namespace

store::MotionModel pending_model_of(const job::Case& job_case)
{
  return pending_model_at_size(job::scaled_to_subject(job_case));
}

store::MotionModel motion_model_of(const job::Case& job_case, const solve::SweepResult& result)
{
  if (job_case.steps_scale == 1.0) return motion_model_at_size(job_case, result);
  return motion_model_at_size(job::scaled_to_subject(job_case), scaled(result, job_case.steps_scale));
}

namespace {

bool is_stable(const StepRecord& r)
{
  return r.status == StepStatus::stable;
}

void set_row(std::vector<double>& rows, std::size_t row, const Eigen::Vector3d& v)
{
  for (std::size_t k = 0; k < 3; ++k) rows[3 * row + k] = v[static_cast<Eigen::Index>(k)];
}

Eigen::Vector3d force_n(const ContactForce& f)
{
  return f.along_delta_n * f.normal_solver / -f.normal_solver.y();
}

class BalanceAssembly {
 public:
  BalanceAssembly(store::MotionModel& model, const job::Case& job_case) : model_(model), case_(job_case) {}

  void add(const StepRecord& r)
  {
    if (!is_stable(r)) return;
    set_flexion(r.key.flexion);
    const auto cell = static_cast<std::size_t>(r.key.flexion) * model_.varus_deg.size() +
                      static_cast<std::size_t>(r.key.varus);
    if (model_.equilibrium) add_certificate(r, cell);
    if (r.coordinates) add_coordinates(*r.coordinates, cell);
    if (model_.ligaments) add_fibres(r, cell);
  }

 private:
  Attitude attitude_of(const StepRecord& r) const
  {
    return {rad_from_deg(model_.flexion_deg[static_cast<std::size_t>(r.key.flexion)]), r.varus_rad};
  }

  // Frame and fibres depend on the flexion only; cells are ordered by flexion.
  void set_flexion(std::int32_t flexion)
  {
    if (flexion == flexion_) return;
    flexion_ = flexion;
    frame_ = frame_of(case_, case_.push.at(static_cast<std::size_t>(flexion)));
    ligaments_ = model::solver_ligaments(case_.ligaments, frame_);
  }

  void add_certificate(const StepRecord& r, std::size_t cell)
  {
    store::EquilibriumSurfaces& surfaces = *model_.equilibrium;
    const auto at = static_cast<Eigen::Index>(cell);
    surfaces.energy_nmm.data()[at] = r.balance.energy_nmm;
    surfaces.balance_residual_n.data()[at] = r.balance.residual_n;
    surfaces.complementarity_mm.data()[at] = r.balance.complementarity_mm;
    surfaces.worst_gap_mm.data()[at] = r.balance.worst_gap_mm;
    surfaces.flexion_moment_nmm.data()[at] = r.balance.flexion_moment_nmm;
    surfaces.varus_moment_nmm.data()[at] = r.balance.varus_moment_nmm;
    if (!model_.has_compartments) return;
    for (const Compartment side : all_compartments) {
      Eigen::Vector3d sum_n = Eigen::Vector3d::Zero();
      for (const ContactForce& f : r.balance.forces)
        if (static_cast<Compartment>(f.compartment) == side) sum_n += force_n(f);
      set_row(surfaces.force_n[side], cell, world_from_solver(frame_, sum_n));
    }
  }

  void add_coordinates(const CoordinateForces& forces, std::size_t cell)
  {
    store::CoordinateSurfaces& surfaces = *model_.coordinates;
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
      surfaces.determined[n_joint_coordinates * cell + k] = forces.determined[k];
      (is_rotation(k) ? surfaces.holding_moment_nmm : surfaces.holding_force_n)[3 * cell + k % 3] =
          forces.holding[k];
    }
  }

  void add_fibres(const StepRecord& r, std::size_t cell)
  {
    store::LigamentRows& rows = *model_.ligaments;
    const std::vector<model::FibreState> states = model::fibre_states(ligaments_, attitude_of(r), r.pose);
    for (std::size_t k = 0; k < states.size(); ++k) {
      const std::size_t at = cell * states.size() + k;
      rows.length_mm[at] = states[k].length_mm;
      rows.strain[at] = states[k].strain;
      rows.tension_n[at] = states[k].force_n;
      rows.energy_nmm[at] = states[k].energy_nmm;
      rows.is_wrapped[at] = states[k].is_wrapped ? 1 : 0;
    }
  }

  store::MotionModel& model_;
  const job::Case& case_;
  std::int32_t flexion_ = -1;  // of frame_ and ligaments_
  SolverFrame frame_;
  model::Ligaments ligaments_;  // in frame_
};

store::ForceRows force_rows(const store::MotionModel& model, const std::vector<StepRecord>& cells)
{
  const auto forces_of = [](const StepRecord& r) {
    return is_stable(r) ? std::span<const ContactForce>(r.balance.forces) : std::span<const ContactForce>();
  };
  return store::compressed_rows(model, cells, forces_of, &ContactForce::along_delta_n,
                                &store::ForceRows::along_delta_n);
}

void add_branches(store::SpineBranches& branches, const SolverFrame& frame, const solve::FreeSpineStep& step)
{
  if (branches.row_start.empty()) branches.row_start.push_back(0);
  for (const solve::SpineEquilibrium& equilibrium : step.equilibria) {
    const std::size_t row = branches.energy_nmm.size();
    branches.resize(row + 1);
    branches.set(row, world_translation_mm(frame, equilibrium.pose), deg_from_rad(equilibrium.pose.theta_rad),
                 deg_from_rad(equilibrium.varus_rad));
    branches.energy_nmm.push_back(equilibrium.energy_nmm);
    branches.is_chosen.push_back(equilibrium.is_chosen ? 1 : 0);
  }
  branches.row_start.push_back(static_cast<std::int64_t>(branches.energy_nmm.size()));
}

void set_spine(store::FreeSpine& spine, const job::Case& job_case, const solve::SweepResult& result)
{
  spine.branches = {};
  for (std::size_t i = 0; i < result.free_spine.size(); ++i) {
    const solve::FreeSpineStep& step = result.free_spine[i];
    spine.status[i] = static_cast<std::int8_t>(step.chosen.status);
    spine.n_optima[i] = step.n_optima;
    add_branches(spine.branches, frame_of(job_case, job_case.push.at(i)), step);
    if (!is_stable(step.chosen)) continue;
    spine.set(i, world_translation_mm(frame_of(job_case, job_case.push.at(i)), step.chosen.pose),
              deg_from_rad(step.chosen.pose.theta_rad), deg_from_rad(step.chosen.varus_rad));
    spine.energy_nmm[i] = step.chosen.balance.energy_nmm;
    spine.optima_theta_spread_deg[i] = deg_from_rad(step.theta_spread_rad);
    spine.optima_energy_spread_nmm[i] = step.energy_spread_nmm;
    if (is_stable(step.band_low)) spine.theta_low_deg[i] = deg_from_rad(step.band_low.pose.theta_rad);
    if (is_stable(step.band_high)) spine.theta_high_deg[i] = deg_from_rad(step.band_high.pose.theta_rad);
  }
}

// The forces of springs, fibres and push at one pose of the spine.
struct SpineForces {
  std::vector<CoordinateSpring> springs;
  StepRecord pose;
  Potential fibres;
  double push_moment_nmm = 0.0;
};

// One row of each term, angles in degrees.
void add_term_rows(std::vector<store::PriorTermRows>& terms, const SpineForces& at)
{
  for (std::size_t k = 0; k < terms.size(); ++k) {
    const CoordinateSpring& spring = at.springs[k];
    const double value =
        is_stable(at.pose) ? coordinate_value(spring.coordinate, at.pose.varus_rad, at.pose.pose).value : nan;
    const double scale = is_angle(spring.coordinate) ? deg_from_rad(1.0) : 1.0, off = value - spring.target;
    terms[k].curve.push_back(scale * spring.target);
    terms[k].value.push_back(scale * value);
    terms[k].stiffness.push_back(spring.stiffness);
    terms[k].force.push_back(-spring.stiffness * off);
    terms[k].energy_nmm.push_back(0.5 * spring.stiffness * off * off);
  }
}

// After add_term_rows().
void add_shares(store::PriorRows& rows, const SpineForces& at, double own_stiffness)
{
  double moment_nmm = 0.0, stiffness = 0.0, energy_nmm = 0.0;
  for (std::size_t k = 0; k < at.springs.size(); ++k) {
    energy_nmm += rows.terms[k].energy_nmm.back();
    if (at.springs[k].coordinate != PriorCoordinate::internal) continue;
    moment_nmm = rows.terms[k].force.back();
    stiffness = at.springs[k].stiffness;
  }
  const auto share = [&](double part, double all) {
    return !is_stable(at.pose) ? nan : all > 0.0 ? part / all : 0.0;
  };
  const double of_fibres_nmm = -at.fibres.gradient(about_y);
  // Whatever balances springs, fibres and push comes from the contacts.
  const double of_contacts_nmm = -(moment_nmm + of_fibres_nmm + at.push_moment_nmm);
  rows.rotation_share.push_back(share(stiffness, stiffness + own_stiffness));
  rows.moment_share.push_back(share(std::abs(moment_nmm), std::abs(moment_nmm) + std::abs(of_fibres_nmm) +
                                                              std::abs(at.push_moment_nmm) +
                                                              std::abs(of_contacts_nmm)));
  rows.energy_share.push_back(share(energy_nmm, energy_nmm + at.fibres.energy_nmm));
}

store::BonesAlone bones_alone_rows(const SolverFrame& frame, const std::vector<solve::FreeSpineStep>& steps)
{
  store::BonesAlone alone;
  alone.resize(steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const StepRecord& r = steps[i].chosen;
    alone.status.push_back(static_cast<std::int8_t>(r.status));
    alone.energy_nmm.push_back(is_stable(r) ? r.balance.energy_nmm : nan);
    alone.n_optima.push_back(steps[i].n_optima);
    if (!is_stable(r)) continue;
    alone.set(i, world_translation_mm(frame, r.pose), deg_from_rad(r.pose.theta_rad),
              deg_from_rad(r.varus_rad));
  }
  return alone;
}

store::PriorRows prior_rows(const job::Case& job_case, const solve::SweepResult& result)
{
  store::PriorRows rows;
  rows.own_stiffness = result.prior.own_stiffness;
  for (const PriorTerm& term : job_case.prior) {
    const double level = result.prior.level.at(rows.terms.size());
    store::PriorTermRows& row = rows.terms.emplace_back();
    row.coordinate = static_cast<std::int8_t>(term.coordinate);
    row.shape = term.shape;
    row.level = is_angle(term.coordinate) ? deg_from_rad(level) : level;
    row.is_level_free = !term.level.has_value();
  }
  const model::Ligaments ligaments = model::solver_ligaments(job_case.ligaments, job_case.frame);
  for (std::size_t i = 0; i < result.free_spine.size(); ++i) {
    const double flexion_rad = rad_from_deg(job_case.grid.flexion_deg[i]);
    SpineForces at{springs_at(job_case.prior, result.prior, flexion_rad),
                   result.free_spine[i].chosen,
                   {},
                   job_case.push[i].moment_nmm};
    if (is_stable(at.pose) && !ligaments.fibres.empty())
      at.fibres = model::ligament_energy(ligaments, {flexion_rad, at.pose.varus_rad}, at.pose.pose);
    add_term_rows(rows.terms, at);
    add_shares(rows, at, rows.own_stiffness[i]);
  }
  std::sort(rows.terms.begin(), rows.terms.end(),
            [](const auto& a, const auto& b) { return a.coordinate < b.coordinate; });
  rows.bones_alone = bones_alone_rows(job_case.frame, result.alone);
  return rows;
}

}  // namespace

store::LigamentRows ligament_rows(const model::Ligaments& canonical)
{
  store::LigamentRows rows;
  const auto n_fibres = static_cast<Eigen::Index>(canonical.fibres.size());
  rows.reference_mm.resize(n_fibres, 3);
  rows.moving_mm.resize(n_fibres, 3);
  rows.transition_strain = canonical.transition_strain;
  for (Eigen::Index k = 0; k < n_fibres; ++k) {
    const model::Fibre& fibre = canonical.fibres[static_cast<std::size_t>(k)];
    rows.name.push_back(fibre.name);
    rows.bundle.push_back(fibre.bundle);
    rows.reference_mm.row(k) = fibre.reference_mm.transpose();
    rows.moving_mm.row(k) = fibre.moving_mm.transpose();
    rows.stiffness_n.push_back(fibre.stiffness_n);
    rows.slack_length_mm.push_back(fibre.slack_length_mm);
    rows.wrap.push_back(fibre.wrap);
  }
  const auto n_wraps = static_cast<Eigen::Index>(canonical.wraps.size());
  rows.wrap_radii_mm.resize(n_wraps, 3);
  for (Eigen::Index k = 0; k < n_wraps; ++k) {
    const model::Wrap& wrap = canonical.wraps[static_cast<std::size_t>(k)];
    rows.wrap_name.push_back(wrap.name);
    rows.wrap_shape.push_back(wrap.shape == model::WrapShape::cylinder ? 0 : 1);
    rows.wrap_body.push_back(static_cast<std::int8_t>(wrap.body));
    rows.wrap_radii_mm.row(k) = wrap.radii_mm.transpose();
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) rows.X_body_wrap.push_back(wrap.X_body_wrap.matrix()(i, j));
    }
  }
  return rows;
}

void add_balance(store::MotionModel& model, const job::Case& job_case, const solve::SweepResult& result)
{
  BalanceAssembly assembly(model, job_case);
  for (const StepRecord& r : result.cells) assembly.add(r);
  if (model.equilibrium) {
    model.equilibrium->forces = force_rows(model, result.cells);
    set_spine(model.equilibrium->spine, job_case, result);
  }
  if (!result.alone.empty()) model.prior = prior_rows(job_case, result);
  if (model.contact_paths) model.contact_paths = store::contact_paths_of(model);
}

namespace {

struct Entry {
  const SearchTrace* search = nullptr;
  StepKind node = StepKind::row;
};

// Sorted by flexion, varus and node, independent of the order of solving.
std::vector<Entry> ordered(const std::map<StepKey, SearchTrace>& searches,
                           const std::vector<std::int32_t>& spine_column)
{
  std::vector<Entry> entries;
  for (const auto& [key, search] : searches) {
    const bool is_spine =
        key.kind == StepKind::spine_probe && spine_column[static_cast<std::size_t>(key.flexion)] == key.varus;
    entries.push_back({&search, is_spine ? StepKind::spine : key.kind});
  }
  const auto rank = [](const Entry& e) {
    return std::make_tuple(e.search->key.flexion, e.search->key.varus, e.node);
  };
  std::sort(entries.begin(), entries.end(),
            [&](const Entry& a, const Entry& b) { return rank(a) < rank(b); });
  return entries;
}

Eigen::RowVector3f single(const Eigen::Vector3d& v)
{
  return v.cast<float>().transpose();
}

float single_deg(double angle_rad)
{
  return static_cast<float>(deg_from_rad(angle_rad));
}

class TraceAssembly {
 public:
  TraceAssembly(const job::Case& job_case, store::Trace& trace)
      : case_(job_case), scale_(job_case.steps_scale), frame_(job_case.frame), trace_(trace)
  {
  }

  void resize(const std::vector<Entry>& entries)
  {
    Eigen::Index n_moves = 0, n_contacts = 0;
    for (const Entry& entry : entries) {
      n_moves += static_cast<Eigen::Index>(entry.search->moves.size());
      for (const SearchMove& move : entry.search->moves) {
        n_contacts += static_cast<Eigen::Index>(move.contacts.size());
      }
    }
    trace_.searches.seed_translation_mm.resize(static_cast<Eigen::Index>(entries.size()), 3);
    trace_.moves.translation_mm.resize(n_moves, 3);
    trace_.contacts.point_mm.resize(n_contacts, 3);
    trace_.contacts.normal.resize(n_contacts, 3);
  }

  void add(const Entry& entry)
  {
    const SearchTrace& search = *entry.search;
    store::TraceSearches& searches = trace_.searches;
    searches.seed_translation_mm.row(static_cast<Eigen::Index>(searches.node.size())) =
        single(scale_ * world_translation_mm(frame_, search.seed));
    searches.seed_theta_deg.push_back(single_deg(search.seed.theta_rad));
    searches.flexion_deg.push_back(case_.grid.flexion_deg[static_cast<std::size_t>(search.key.flexion)]);
    searches.varus_deg.push_back(case_.grid.varus_deg[static_cast<std::size_t>(search.key.varus)]);
    searches.node.push_back(static_cast<std::int8_t>(entry.node));
    searches.status.push_back(static_cast<std::int8_t>(search.status));
    for (const SearchMove& move : search.moves) add(move);
    searches.move_start.push_back(static_cast<std::int64_t>(trace_.moves.kind.size()));
  }

 private:
  void add(const SearchMove& move)
  {
    store::TraceMoves& moves = trace_.moves;
    moves.translation_mm.row(static_cast<Eigen::Index>(moves.kind.size())) =
        single(scale_ * world_translation_mm(frame_, move.pose));
    moves.theta_deg.push_back(single_deg(move.pose.theta_rad));
    moves.iteration.push_back(move.iteration);
    moves.kind.push_back(static_cast<std::int8_t>(move.kind));
    moves.translation_step_mm.push_back(static_cast<float>(scale_ * move.translation_step_mm));
    moves.rotation_step_deg.push_back(single_deg(move.rotation_step_rad));
    moves.collides.push_back(move.collides ? 1 : 0);
    moves.is_cycle.push_back(move.is_cycle ? 1 : 0);
    moves.in_contact.push_back(move.in_contact ? 1 : 0);
    for (const ContactRecord& contact : move.contacts) add(contact);
    moves.contact_start.push_back(static_cast<std::int64_t>(trace_.contacts.compartment.size()));
  }

  void add(const ContactRecord& contact)
  {
    store::TraceContacts& contacts = trace_.contacts;
    const auto row = static_cast<Eigen::Index>(contacts.compartment.size());
    contacts.point_mm.row(row) = single(scale_ * world_from_solver(frame_, contact.point_solver_mm));
    contacts.normal.row(row) = single(world_from_solver(frame_, contact.normal_solver));
    contacts.distance_mm.push_back(static_cast<float>(scale_ * contact.distance_mm));
    contacts.triangle_reference.push_back(contact.triangle_reference);
    contacts.triangle_moving.push_back(contact.triangle_moving);
    contacts.compartment.push_back(contact.compartment);
  }

  const job::Case& case_;
  double scale_;  // subject over solved size
  const SolverFrame& frame_;
  store::Trace& trace_;
};

}  // namespace

store::Trace trace_of(const job::Case& job_case, const std::string& job_key,
                      const std::map<StepKey, SearchTrace>& searches,
                      const std::vector<std::int32_t>& spine_column)
{
  store::Trace trace;
  trace.title = job_case.title;
  trace.side = side_name(job_case.frame.side);
  trace.job_key = job_key;
  trace.approach_step_mm = job_case.steps_scale * job_case.search.approach_step_mm;
  trace.translation_resolution_mm =
      job_case.steps_scale * (job_case.method == "equilibrium" ? job_case.equilibrium.tolerance_mm
                                                               : job_case.search.translation_resolution_mm);
  trace.rotation_resolution_deg = deg_from_rad(job_case.search.rotation_resolution_rad);
  trace.job.resolved = job_case.resolved_job;
  for (const job::LoadedInput& input : job_case.inputs)
    trace.job.inputs.push_back({input.name, input.sha256});
  const std::vector<Entry> entries = ordered(searches, spine_column);
  TraceAssembly assembly(job_case, trace);
  assembly.resize(entries);
  for (const Entry& entry : entries) assembly.add(entry);
  return trace;
}

}  // namespace vrda::solve
