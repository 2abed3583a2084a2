#include "python/joint_solver.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "core/units.hpp"
#include "job/job_parts.hpp"
#include "model/coordinates.hpp"
#include "model/ligaments.hpp"
#include "solve/followers.hpp"

namespace vrda::python {
namespace {

job::FlexionTable constant(Eigen::MatrixXd row)
{
  return {{0.0}, std::move(row)};
}

void replace(job::FlexionTable& table, const std::vector<double>& rows, std::size_t row, Eigen::Index width)
{
  if (rows.empty()) return;
  const auto first = static_cast<Eigen::Index>(row) * width;
  table = constant(Eigen::Map<const Eigen::RowVectorXd>(rows.data() + first, width));
}

double along_delta_n(const Balance& balance, Compartment compartment)
{
  double sum_n = 0.0;
  for (const ContactForce& force : balance.forces)
    if (force.compartment == static_cast<std::int8_t>(compartment)) sum_n += force.along_delta_n;
  return sum_n;
}

void require_finite(const std::string& argument, const std::vector<double>& values)
{
  for (const double value : values) {
    if (std::isfinite(value)) continue;
    throw InputError({"Joint.solve", argument, shortest_decimal(value), "finite numbers"});
  }
}

void require_rows(const std::string& argument, std::size_t n_found, std::size_t n_wanted)
{
  if (n_found == 0 || n_found == n_wanted) return;
  throw InputError({"Joint.solve", argument, std::to_string(n_found) + " values",
                    std::to_string(n_wanted) + ", as many as the rows need"});
}

}  // namespace

JointSolver::JointSolver(const std::string& job_file, const job::LoadOptions& options)
    : job_(job::read_job(job_file, options.overrides)), case_(job::load_case(job_, options.data_directory))
{
  if (case_.coordinates)
    throw InputError({job_file, "coordinates", "roles of coordinates", "a job with [grid] for vrda.Joint"});
  if (case_.scaling)
    throw InputError({job_file, "scaling", "a scaled joint", "a job without [scaling] for vrda.Joint"});
  solver_ = std::make_unique<solve::CaseSolver>(case_, 1);
}

namespace {

std::vector<std::string> names_of(const model::Ligaments& ligaments)
{
  std::vector<std::string> names;
  for (const model::Fibre& fibre : ligaments.fibres) names.push_back(fibre.name);
  return names;
}

}  // namespace

std::vector<std::string> JointSolver::fibre_names() const
{
  return names_of(case_.ligaments);
}

std::vector<std::string> JointSolver::follower_names() const
{
  std::vector<std::string> names;
  for (const job::Follower& follower : case_.followers) names.push_back(follower.name);
  return names;
}

const job::Follower& JointSolver::follower(const std::string& name) const
{
  const auto found = std::ranges::find(case_.followers, name, &job::Follower::name);
  if (found != case_.followers.end()) return *found;
  const std::vector<std::string> names = follower_names();
  throw InputError({"Joint", "follower", '"' + name + '"',
                    names.empty() ? "a job with [[follower]]" : "one of " + joined(names)});
}

std::vector<std::string> JointSolver::follower_fibre_names(const std::string& name) const
{
  return names_of(follower(name).ligaments);
}

job::Push JointSolver::push_at(const RowPlan& plan, std::size_t row) const
{
  job::PushJob push = job_.push;
  replace(push.force_n, plan.loads.force_n, row, 1);
  replace(push.lateral_force_n, plan.loads.lateral_force_n, row, 2);
  replace(push.moment_nmm, plan.loads.moment_nmm, row, 1);
  replace(push.varus_moment_nmm, plan.loads.varus_moment_nmm, row, 1);
  const double flexion_rad = rad_from_deg(plan.flexion_deg[row]);
  return job::push_at(push, job::value_at_flexion(push.delta, flexion_rad).normalized(), flexion_rad);
}

solve::SolverPosition JointSolver::seed_position(const std::array<double, 16>& seed,
                                                 const SolverFrame& frame) const
{
  Pose X;
  X.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(seed.data());
  const Eigen::Matrix3d R = X.linear();
  const double error = (R.transpose() * R - Eigen::Matrix3d::Identity()).norm();
  constexpr double rounding = 1e-6;
  if (!(error < rounding) || R.determinant() < 0.0 || !X.translation().allFinite())
    throw InputError({"Joint.solve", "seed", "a matrix that is not a rigid transform",
                      "a rotation and a finite translation"});
  return solve::solver_position(frame, X);
}

void JointSolver::require_solvable(const RowPlan& plan) const
{
  const std::size_t n = plan.flexion_deg.size();
  if (n == 0) throw InputError({"Joint.solve", "flexion", "no value", "at least one"});
  require_finite("flexion", plan.flexion_deg);
  require_finite("varus", plan.varus_deg);
  for (const double flexion_deg : plan.flexion_deg)
    if (std::abs(flexion_deg) > 180.0)
      throw InputError({"Joint.solve", "flexion", shortest_decimal(flexion_deg), "-180 to 180 degrees"});
  for (const double varus_deg : plan.varus_deg)
    if (!(std::abs(varus_deg) < 90.0))
      throw InputError({"Joint.solve", "varus", shortest_decimal(varus_deg), "degrees between -90 and 90"});
  require_rows("varus", plan.varus_deg.size(), n);
  const bool is_search = case_.method != "equilibrium";
  if (is_search && plan.varus_deg.empty())
    throw InputError(
        {"Joint.solve", "varus", "a free varus with \"stability-search\"", "a value in degrees"});
  struct Column {
    const char* name;
    const std::vector<double>& values;
    std::size_t width;
  };
  for (const Column& column :
       {Column{"force_n", plan.loads.force_n, 1}, Column{"lateral_force_n", plan.loads.lateral_force_n, 2},
        Column{"moment_nmm", plan.loads.moment_nmm, 1},
        Column{"varus_moment_nmm", plan.loads.varus_moment_nmm, 1}}) {
    const std::string argument = std::string("loads.") + column.name;
    if (is_search && !column.values.empty())
      throw InputError(
          {"Joint.solve", argument, "loads with \"stability-search\"", "solver.method = \"equilibrium\""});
    require_finite(argument, column.values);
    require_rows(argument, column.values.size(), n * column.width);
  }
  for (const double force_n : plan.loads.force_n)
    if (!(force_n > 0.0))
      throw InputError({"Joint.solve", "loads.force_n", shortest_decimal(force_n), "a push above 0"});
}

void JointSolver::add_row(RowResults& results, const StepRecord& record, double flexion_rad,
                          const SolverFrame& frame) const
{
  const bool is_stable = record.status == StepStatus::stable;
  const Attitude attitude{flexion_rad, record.varus_rad};
  const Pose X = X_reference_moving(frame, attitude, record.pose);
  const ClinicalCoordinates c = clinical_coordinates(X, frame.side, frame.rotation_centre_mm);
  const auto add = [is_stable](std::vector<double>& column, double value) {
    column.push_back(is_stable ? value : nan);
  };
  results.status.push_back(static_cast<std::int8_t>(record.status));
  results.iterations.push_back(record.iterations);
  add(results.flexion_deg, deg_from_rad(c.flexion_rad));
  add(results.varus_deg, deg_from_rad(c.varus_rad));
  add(results.internal_deg, deg_from_rad(c.internal_rotation_rad));
  add(results.anterior_mm, c.anterior_mm);
  add(results.proximal_mm, c.proximal_mm);
  add(results.lateral_mm, c.lateral_mm);
  add(results.theta_deg, deg_from_rad(record.pose.theta_rad));
  for (Eigen::Index i = 0; i < 4; ++i)
    for (Eigen::Index j = 0; j < 4; ++j) add(results.X_reference_moving, X.matrix()(i, j));
  add(results.gap_medial_mm, record.gap_mm[0]);
  add(results.gap_lateral_mm, record.gap_mm[1]);
  const bool has_forces = case_.method == "equilibrium" && !case_.compartment_of_triangle.empty();
  add(results.force_medial_n, has_forces ? along_delta_n(record.balance, Compartment::medial) : nan);
  add(results.force_lateral_n, has_forces ? along_delta_n(record.balance, Compartment::lateral) : nan);
  add(results.energy_nmm, record.balance.energy_nmm);
  add(results.flexion_moment_nmm, record.balance.flexion_moment_nmm);
  add(results.varus_moment_nmm, record.balance.varus_moment_nmm);
  for (const model::FibreState& fibre :
       model::fibre_states(model::solver_ligaments(case_.ligaments, frame), attitude, record.pose)) {
    add(results.strain, fibre.strain);
    add(results.tension_n, fibre.force_n);
  }
}

void JointSolver::follow(StepRecord& record, RowResults& results, std::vector<Pose>& starts)
{
  const double flexion_rad =
      record.coordinates ? record.coordinates->flexion_rad : rad_from_deg(case_.grid.flexion_deg[0]);
  solve::SweepPlan plan;
  plan.flexion_rad = {flexion_rad};
  plan.varus_rad = {record.varus_rad};
  plan.spine = is_varus_free_ ? solve::SpineRule::free_varus : solve::SpineRule::nearest_zero;
  plan.is_varus_free = is_varus_free_;
  solve::SweepResult row;
  record.key = {StepKind::row, 0, 0};
  row.cells = {record};
  row.spine_column = {0};
  row.free_spine.emplace_back().chosen = record;
  const solve::SolveStep step = [this](const solve::StepTask& task) { return (*solver_)(task); };
  solve::follow(case_, plan, step, {}, 1, row, starts);
  record = row.cells.front();
  const bool is_posed = std::ranges::all_of(
      row.followers.front(), [](const StepRecord& r) { return r.status == StepStatus::stable; });
  if (is_posed) starts.clear();
  model::BodyPoses placed{Pose::Identity(), solve::joint_pose_of(case_, record)};
  for (std::size_t k = 0; k < case_.followers.size(); ++k) {
    const StepRecord& own = row.followers.front()[k];
    add_follower(k, own, placed, results.followers[k]);
    if (is_posed)
      starts.push_back(solve::follower_pose_of(solve::follower_frame(case_, case_.followers[k]), own));
  }
}

void JointSolver::add_follower(std::size_t k, const StepRecord& record, model::BodyPoses& placed,
                               FollowerResults& results) const
{
  const job::Follower& follower = case_.followers[k];
  const SolverFrame frame = solve::follower_frame(case_, follower);
  const bool is_stable = record.status == StepStatus::stable;
  results.status.push_back(static_cast<std::int8_t>(record.status));
  JointCoordinates q = JointCoordinates::Constant(nan);
  Eigen::Matrix4d X = Eigen::Matrix4d::Constant(nan);
  std::vector<double> tension_n(follower.ligaments.fibres.size(), nan);
  if (is_stable) {
    const Pose X_of = solve::follower_pose_of(frame, record);
    const Attitude attitude{record.coordinates->flexion_rad, record.varus_rad};
    const auto fibres = model::solver_ligaments(
        model::ligaments_between(follower.ligaments, follower.of, model::follower_index(k), placed), frame);
    const std::vector<model::FibreState> states = model::fibre_states(fibres, attitude, record.pose);
    for (std::size_t f = 0; f < states.size(); ++f) tension_n[f] = states[f].force_n;
    placed.push_back(placed.at(model::row_of(follower.of)) * X_of);
    q = follower_coordinates(X_of, frame.side, follower.centre_mm);
    X = X_of.matrix();
  }
  std::vector<double>* columns[] = {&results.flexion_deg, &results.rotation_deg, &results.tilt_deg,
                                    &results.anterior_mm, &results.proximal_mm,  &results.lateral_mm};
  const auto numbers = in_files(q);
  for (std::size_t c = 0; c < n_joint_coordinates; ++c) columns[c]->push_back(numbers[c]);
  for (Eigen::Index i = 0; i < 4; ++i)
    for (Eigen::Index j = 0; j < 4; ++j) results.X_of_follower.push_back(X(i, j));
  results.energy_nmm.push_back(is_stable ? record.balance.energy_nmm : nan);
  results.tension_n.insert(results.tension_n.end(), tension_n.begin(), tension_n.end());
}

RowResults JointSolver::solve(const RowPlan& plan, const std::function<void()>& before_row)
{
  require_solvable(plan);
  const std::lock_guard one_at_a_time(mutex_);
  RowResults results;
  for (const job::Follower& follower : case_.followers) results.followers.emplace_back().name = follower.name;
  std::vector<Pose> starts;  // of the followers; empty: of the scan
  is_varus_free_ = plan.varus_deg.empty();
  // Row 0 of the pushes is that of the seed, row 1 that of the step.
  case_.path_push.assign(2, push_at(plan, 0));
  const SolverFrame first = solve::frame_of(case_, case_.path_push[1]);
  solve::StepTask task;
  task.path_row = 1;
  task.seed = {solver_translation_mm(first, case_.initial.translation_mm), case_.initial.theta_rad};
  double last_varus_rad = 0.0;
  if (plan.seed) {
    const solve::SolverPosition seed = seed_position(*plan.seed, first);
    task.seed = seed.pose;
    last_varus_rad = seed.attitude.varus_rad;
  }
  for (std::size_t row = 0; row < plan.flexion_deg.size(); ++row) {
    before_row();
    case_.path_push[1] = push_at(plan, row);
    const SolverFrame frame = solve::frame_of(case_, case_.path_push[1]);
    task.attitude.flexion_rad = rad_from_deg(plan.flexion_deg[row]);
    task.is_varus_free = plan.varus_deg.empty();
    task.attitude.varus_rad = task.is_varus_free ? last_varus_rad : rad_from_deg(plan.varus_deg[row]);
    StepRecord record = (*solver_)(task);
    if (!case_.followers.empty()) {
      // The one cell of the plan, whose Delta is that of the row.
      case_.grid.flexion_deg = {plan.flexion_deg[row]};
      case_.push = {case_.path_push[1]};
      if (record.status == StepStatus::stable) case_.path_push[0] = case_.path_push[1];
      follow(record, results, starts);
    }
    add_row(results, record, task.attitude.flexion_rad, frame);
    if (record.status != StepStatus::stable) continue;
    task.seed = record.pose;
    last_varus_rad = record.varus_rad;
    case_.path_push[0] = case_.path_push[1];
  }
  return results;
}

}  // namespace vrda::python
