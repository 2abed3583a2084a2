#include "solve/coordinate_equilibrium.hpp"

#include <nlopt.h>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/text.hpp"
#include "core/units.hpp"
#include "solve/quadratic_program.hpp"

namespace vrda::solve {

using namespace coordinate_rules;

namespace {

// Of tolerances: the push, and what pulls with a constant tension.
double scale_n(const Loads& loads, const model::Ligaments& ligaments)
{
  double sum_n = loads.force_n.norm();
  for (const model::Fibre& fibre : ligaments.fibres) sum_n += fibre.tension_n;
  return sum_n > 0.0 ? sum_n : 1.0;
}

}  // namespace

CoordinateEquilibrium::Run::Run(State& state, const Task& task)
    : state_(state),
      task_(task),
      is_free_(task.is_free),
      push_n_(scale_n(task.loads, state.ligaments)),
      tolerance_mm_(state.options.tolerance_mm),
      standoff_mm_(standoff_share_of_tolerance * tolerance_mm_)
{
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    unit_(static_cast<Eigen::Index>(k)) = is_rotation(k) ? 1.0 / state.scale.lever_mm : 1.0;
}

StepRecord CoordinateEquilibrium::Run::run()
{
  n_queries_before_ = state_.gap.n_queries();
  StepRecord record;
  record.status = find_with_turned_loads();
  const SolverPosition at = position(current_);
  record.pose = at.pose;
  record.varus_rad = at.attitude.varus_rad;
  record.iterations = iteration_;
  record.residual_mm = residual_mm_;
  if (record.status == StepStatus::stable) {
    fill_balance(record);
    record.coordinates->flexion_rad = at.attitude.flexion_rad;
    if (task_.is_measured) measure(record);
  }
  record.queries += state_.gap.n_queries() - n_queries_before_;
  return record;
}

void CoordinateEquilibrium::Run::sample(const JointCoordinates& q, Sampled& out, double band_mm)
{
  const SolverPosition at = position(q);
  state_.gap.set_attitude(at.attitude);
  const geometry::GapResult& found = state_.gap.features(at.pose, band_mm);
  out.travel_mm = found.travel_mm;
  out.features.clear();
  const Configuration configuration = configuration_at(at.pose, at.attitude.varus_rad, state_.scale);
  const Rotations rotations(configuration, at.attitude.flexion_rad);
  const ConstraintMeshes meshes{state_.joint.reference.tree_mesh.mesh, state_.joint.moving.tree_mesh.mesh,
                                state_.scale};
  for (const geometry::GapFeature& feature : found.features) {
    if (out.features.size() == most_features) break;
    const ContactConstraint constraint = contact_constraint_of(feature, meshes, configuration, rotations);
    if (can_carry_load(constraint, state_.joint)) out.features.push_back(constraint);
  }
}

std::optional<Vector6d> CoordinateEquilibrium::Run::lift_at(const JointCoordinates& q) const
{
  const Matrix6d twists = state_.map.twists(q, position(q));
  Vector6d lift = Vector6d::Zero();
  Eigen::Matrix3d JJ = Eigen::Matrix3d::Zero();
  for (std::size_t k = 3; k < n_joint_coordinates; ++k) {
    const Eigen::Vector3d v = twists.col(static_cast<Eigen::Index>(k)).tail<3>();
    if (is_free_[k]) JJ += v * v.transpose();
  }
  // Least squares with a small ridge: a held coordinate leaves a direction without an answer.
  const Eigen::Vector3d y = (JJ + 1e-9 * Eigen::Matrix3d::Identity()).inverse() * Eigen::Vector3d::UnitY();
  Eigen::Vector3d motion = Eigen::Vector3d::Zero();
  for (std::size_t k = 3; k < n_joint_coordinates; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    if (!is_free_[k]) continue;
    lift(row) = twists.col(row).tail<3>().dot(y);
    motion += lift(row) * twists.col(row).tail<3>();
  }
  if (motion.y() < 0.5) return std::nullopt;
  return Vector6d(lift / motion.y());
}

bool CoordinateEquilibrium::Run::bring_to_contact(JointCoordinates& q, Sampled& sampled, bool only_down)
{
  for (int k = 0; k < most_lifts; ++k) {
    sample(q, sampled, state_.band_mm);
    if (!std::isfinite(sampled.travel_mm)) return false;
    const double way_mm = sampled.travel_mm - standoff_mm_;
    const bool is_there =
        only_down ? sampled.travel_mm >= -overlap_rounding_mm : std::abs(way_mm) <= standoff_mm_;
    if (is_there) return true;
    const std::optional<Vector6d> lift = lift_at(q);
    if (!lift) return only_down ? false : sampled.travel_mm >= -overlap_rounding_mm;
    q += way_mm * *lift;
  }
  return sampled.travel_mm >= -overlap_rounding_mm;
}

bool CoordinateEquilibrium::Run::leave_overlap()
{
  for (int k = 0; k < most_lifts; ++k) {
    const Plan plan = minimise(current_, sampled_.features, first_step_mm, true);
    if (plan.length_mm <= 1e-9) return false;
    current_ = plan.end;
    sample(current_, sampled_, state_.band_mm);
    if (!std::isfinite(sampled_.travel_mm)) return false;
    if (sampled_.travel_mm >= -overlap_rounding_mm) return true;
  }
  return false;
}

StepStatus CoordinateEquilibrium::Run::find_with_turned_loads()
{
  current_ = task_.seed;
  has_applied_ = !task_.loads.applied.empty() || !task_.loads.lines.empty();
  if (!has_applied_) return find_equilibrium();
  const auto at_position = [&] {
    const SolverPosition at = position(current_);
    return potential_near(task_.loads, at.attitude, at.pose);
  };
  applied_ = at_position();
  for (int k = 0; k < most_turns; ++k) {
    const StepStatus status = find_equilibrium();
    if (status != StepStatus::stable) return status;
    const SolverPosition at = position(current_);
    const LoadPotential before = applied_;
    const Vector6d wrench = work_of(task_.loads, &before, at).wrench;
    applied_ = at_position();
    const Vector6d change = unit_.cwiseProduct(state_.map.twists(current_, at).transpose() *
                                               Vector6d(work_of(task_.loads, &applied_, at).wrench - wrench));
    update_balance();  // of the forces at this position
    if (change.norm() <= turned_load_share * push_n_) return status;
  }
  return StepStatus::iteration_limit;
}

StepStatus CoordinateEquilibrium::Run::find_equilibrium()
{
  if (!bring_to_contact(current_, sampled_, false)) {
    if (!std::isfinite(sampled_.travel_mm)) return StepStatus::no_contact;
    if (n_free() == 0 || !leave_overlap()) return StepStatus::no_clearance;
  }
  double radius_mm = first_step_mm;
  int n_rejections = 0;
  std::vector<ContactConstraint> cuts;
  Sampled trial;
  for (iteration_ = 1; iteration_ <= state_.options.max_iterations; ++iteration_) {
    std::vector<ContactConstraint> features = sampled_.features;
    features.insert(features.end(), cuts.begin(), cuts.end());
    const double merit = merit_mm(current_);
    Plan plan = minimise(current_, features, radius_mm);
    const double predicted_mm = merit - plan.energy_mm;
    residual_mm_ = plan.length_mm;
    const bool is_small = plan.length_mm <= tolerance_mm_ || predicted_mm <= 1e-6 * tolerance_mm_;
    if (is_small || plan.violation_mm > infeasible_mm) {
      if (is_small && is_certified()) {
        if (!crosses_ridge()) return StepStatus::stable;
        radius_mm = first_step_mm;
      } else {
        radius_mm *= 0.25;
        if (radius_mm < 0.1 * tolerance_mm_) break;
      }
      cuts.clear();
      n_rejections = 0;
      continue;
    }
    JointCoordinates end = plan.end;
    const bool is_clear = bring_to_contact(end, trial, true);
    if (!std::isfinite(trial.travel_mm)) {
      radius_mm = 0.25 * std::min(radius_mm, plan.length_mm);
      if (radius_mm < tolerance_mm_) return StepStatus::unbounded;
      continue;
    }
    const double gain_mm = is_clear ? merit - merit_mm(end) : 0.0;
    if (gain_mm < enough_of_predicted * predicted_mm) {
      if (!is_clear || gain_mm < 0.0) sample(plan.end, trial, state_.band_mm);
      if (!add_cuts(trial.features, cuts) || ++n_rejections >= most_rejections) {
        radius_mm = 0.25 * plan.length_mm;
        n_rejections = 0;
      }
      continue;
    }
    current_ = end;
    std::swap(sampled_, trial);
    cuts.clear();
    n_rejections = 0;
    if (gain_mm > good_of_predicted * predicted_mm && plan.length_mm > 0.8 * radius_mm)
      radius_mm = std::min(2.0 * radius_mm, longest_step_mm);
  }
  iteration_ = std::min(iteration_, state_.options.max_iterations);
  return StepStatus::iteration_limit;
}

bool CoordinateEquilibrium::Run::add_cuts(const std::vector<ContactConstraint>& found,
                                          std::vector<ContactConstraint>& cuts) const
{
  const FeatureMeter distance_of = meter(position(current_));
  const std::size_t before = cuts.size();
  for (const ContactConstraint& feature : found) {
    if (distance_of(feature).distance_mm >= 0.5 * standoff_mm_) cuts.push_back(feature);
  }
  return cuts.size() > before;
}

bool CoordinateEquilibrium::Run::crosses_ridge()
{
  const std::vector<ContactConstraint> touching = touching_;
  const std::vector<FeatureDistance> distances = distances_;
  const double near_mm = touching_within_tolerances * tolerance_mm_;
  const FeatureMeter distance_of = meter(position(current_));
  for (std::size_t a = 0; a < touching.size(); ++a) {
    if (force_n_[a] <= 0.0) continue;
    const auto is_at_point = [&](const ContactConstraint& c) {
      return (distance_of(c).point_mm - distances[a].point_mm).cwiseAbs().maxCoeff() <= near_mm;
    };
    if (std::count_if(touching.begin(), touching.end(), is_at_point) < 2) continue;
    std::vector<ContactConstraint> features;
    std::remove_copy_if(sampled_.features.begin(), sampled_.features.end(), std::back_inserter(features),
                        is_at_point);
    for (const ContactConstraint& single : touching) {
      if (!is_at_point(single)) continue;
      features.push_back(single);
      if (accept_if_lower(features)) return true;
      features.pop_back();
    }
  }
  return false;
}

bool CoordinateEquilibrium::Run::accept_if_lower(const std::vector<ContactConstraint>& features)
{
  const double merit = merit_mm(current_);
  const Plan plan = minimise(current_, features, crossing_step_mm);
  const double predicted_mm = merit - plan.energy_mm;
  if (plan.violation_mm > infeasible_mm || predicted_mm <= tolerance_mm_) return false;
  JointCoordinates end = plan.end;
  Sampled trial;
  if (!bring_to_contact(end, trial, true)) return false;
  if (merit - merit_mm(end) < 0.5 * predicted_mm) return false;
  current_ = end;
  sampled_ = std::move(trial);
  return true;
}

CoordinateEquilibrium::CoordinateEquilibrium(const Joint& joint, const model::Ligaments& ligaments,
                                             const SolverFrame& frame, const EquilibriumOptions& options)
    : state_(std::make_unique<State>(joint, ligaments, frame, options))
{
}

CoordinateEquilibrium::~CoordinateEquilibrium() = default;
CoordinateEquilibrium::CoordinateEquilibrium(CoordinateEquilibrium&&) noexcept = default;

StepRecord CoordinateEquilibrium::solve(const Task& task)
{
  return Run(*state_, task).run();
}

// The trial step of one iteration: energies of the free coordinates and their minimisation by NLopt.

using namespace coordinate_rules;

std::size_t CoordinateEquilibrium::Run::n_free() const
{
  return static_cast<std::size_t>(std::count(is_free_.begin(), is_free_.end(), true));
}

JointCoordinates CoordinateEquilibrium::Run::moved_from(const JointCoordinates& from,
                                                        const double* step_mm) const
{
  JointCoordinates q = from;
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    if (is_free_[k]) q(row) += unit_(row) * *step_mm++;
  }
  return q;
}

void CoordinateEquilibrium::Run::pick_free(const Vector6d& gradient, double* out) const
{
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    if (is_free_[k]) *out++ = gradient(row) * unit_(row);
  }
}

double CoordinateEquilibrium::Run::fibre_energy_nmm(const SolverPosition& at, Vector6d& wrench) const
{
  double energy = 0.0;
  wrench.setZero();
  if (state_.ligaments.fibres.empty() && task_.loads.directions.empty()) return energy;
  const model::JointPlacement placement = model::joint_placement(at.attitude, at.pose);
  for (const model::Fibre& fibre : state_.ligaments.fibres) {
    const model::FibrePath path = model::taut_path(fibre, state_.ligaments.wraps, placement);
    if (fibre.tension_n > 0.0) {
      energy += fibre.tension_n * path.length_mm;
      wrench += wrench_of(fibre.tension_n * path.direction, path.end_mm, at);
      continue;
    }
    const double strain = path.length_mm / fibre.slack_length_mm - 1.0;
    const model::Tension tension =
        model::tension_of(strain, fibre.stiffness_n, state_.ligaments.transition_strain);
    energy += tension.energy_n * fibre.slack_length_mm;
    wrench += wrench_of(tension.force_n * path.direction, path.end_mm, at);
  }
  for (const DirectionSpring& spring : task_.loads.directions) energy += energy_of(spring, at, wrench);
  return energy;
}

double CoordinateEquilibrium::Run::energy_nmm(const SolverPosition& at, Vector6d& wrench) const
{
  const Work work = work_of(task_.loads, applied(), at);
  const double energy = fibre_energy_nmm(at, wrench) - work.work_nmm;
  wrench -= work.wrench;
  return energy;
}

const CoordinateEquilibrium::Run::Trial& CoordinateEquilibrium::Run::trial_at(Minimisation& m,
                                                                              const double* step_mm)
{
  Trial& trial = m.trial;
  if (!trial.step_mm.empty() && std::equal(trial.step_mm.begin(), trial.step_mm.end(), step_mm)) return trial;
  trial.step_mm.assign(step_mm, step_mm + m.run->n_free());
  trial.q = m.run->moved_from(*m.from, step_mm);
  trial.at = m.run->position(trial.q);
  trial.twists = m.run->state_.map.twists(trial.q, trial.at);
  return trial;
}

double CoordinateEquilibrium::Run::load_merit_mm(const Trial& trial, double* gradient) const
{
  const Work work = work_of(task_.loads, applied(), trial.at);
  Vector6d away_mm = (trial.q - task_.seed).cwiseQuotient(unit_);
  away_mm(row_of(JointCoordinate::proximal)) = 0.0;
  if (gradient != nullptr) {
    Vector6d slope = trial.twists.transpose() * work.wrench / -push_n_;
    slope += proximal_share_per_mm * away_mm.cwiseQuotient(unit_);
    pick_free(slope, gradient);
  }
  return 0.5 * proximal_share_per_mm * away_mm.squaredNorm() - work.work_nmm / push_n_;
}

double CoordinateEquilibrium::Run::merit_mm(const JointCoordinates& q) const
{
  const Trial here{{}, q, position(q), {}};
  Vector6d wrench;
  return load_merit_mm(here, nullptr) + fibre_energy_nmm(here.at, wrench) / push_n_;
}

CoordinateEquilibrium::Run::FibreExpansion CoordinateEquilibrium::Run::fibre_expansion(
    const JointCoordinates& q) const
{
  FibreExpansion out;
  if (state_.ligaments.fibres.empty() && task_.loads.directions.empty()) return out;
  const auto over_free = [&](const JointCoordinates& c, Vector6d& gradient) {
    const SolverPosition at = position(c);
    Vector6d wrench;
    const double energy_mm = fibre_energy_nmm(at, wrench) / push_n_;
    gradient.setZero();
    pick_free(state_.map.twists(c, at).transpose() * wrench / push_n_, gradient.data());
    return energy_mm;
  };
  out.is_used = true;
  out.energy_mm = over_free(q, out.gradient);
  std::array<double, 6> step{};
  const auto n = static_cast<Eigen::Index>(n_free());
  for (Eigen::Index k = 0; k < n; ++k) {
    step[static_cast<std::size_t>(k)] = difference_mm;
    Vector6d ahead;
    over_free(moved_from(q, step.data()), ahead);
    out.hessian.col(k) = (ahead - out.gradient) / difference_mm;
    step[static_cast<std::size_t>(k)] = 0.0;
  }
  out.hessian = 0.5 * (out.hessian + Matrix6d(out.hessian.transpose()));
  return out;
}

double CoordinateEquilibrium::Run::objective(unsigned n, const double* z, double* gradient, void* data)
{
  auto& m = *static_cast<Minimisation*>(data);
  if (!m.has_slack) {
    const double loads_mm = m.run->load_merit_mm(trial_at(m, z), gradient);
    if (!m.fibres.is_used) return loads_mm;
    Vector6d step = Vector6d::Zero();
    std::copy(z, z + n, step.data());
    const Vector6d change = m.fibres.hessian * step;
    for (unsigned k = 0; gradient != nullptr && k < n; ++k) gradient[k] += m.fibres.gradient(k) + change(k);
    return loads_mm + m.fibres.energy_mm + m.fibres.gradient.dot(step) + 0.5 * step.dot(change);
  }
  if (gradient != nullptr) {
    std::fill(gradient, gradient + n, 0.0);
    gradient[n - 1] = 1.0;
  }
  return z[n - 1];
}

void CoordinateEquilibrium::Run::constraints(unsigned m_rows, double* result, unsigned n, const double* z,
                                             double* gradient, void* data)
{
  auto& m = *static_cast<Minimisation*>(data);
  const Trial& trial = trial_at(m, z);
  const FeatureMeter distance_of = m.run->meter(trial.at);
  for (unsigned i = 0; i < m_rows; ++i) {
    const FeatureDistance d = distance_of((*m.features)[i]);
    result[i] = m.run->standoff_mm_ - std::min(d.distance_mm, 1e3);
    if (m.has_slack) result[i] -= z[n - 1];
    if (gradient == nullptr) continue;
    double* row = gradient + static_cast<std::size_t>(i) * n;
    m.run->pick_free(-(trial.twists.transpose() * d.wrench), row);
    if (m.has_slack) row[n - 1] = -1.0;
  }
}

CoordinateEquilibrium::Run::Plan CoordinateEquilibrium::Run::minimise(
    const JointCoordinates& from, const std::vector<ContactConstraint>& features, double radius_mm,
    bool has_slack)
{
  Minimisation m{this, &from, &features, has_slack, {}};
  if (!has_slack) m.fibres = fibre_expansion(from);
  const std::size_t n = n_free() + (has_slack ? 1 : 0);
  std::vector<double> z(n, 0.0), low(n, -radius_mm), high(n, radius_mm);
  std::vector<double> tolerance(features.size(), 1e-12);
  Plan plan;
  plan.end = from;
  if (has_slack) {
    low.back() = -1e-3;
    high.back() = 1e3;
    z.back() = worst_violation_mm(from, features);
  }
  if (n > 0) {
    const nlopt_opt opt = nlopt_create(NLOPT_LD_SLSQP, static_cast<unsigned>(n));
    check(opt != nullptr, "nlopt_create failed");
    nlopt_set_min_objective(opt, objective, &m);
    if (!features.empty()) {
      nlopt_add_inequality_mconstraint(opt, static_cast<unsigned>(features.size()), constraints, &m,
                                       tolerance.data());
    }
    nlopt_set_lower_bounds(opt, low.data());
    nlopt_set_upper_bounds(opt, high.data());
    nlopt_set_xtol_abs1(opt, 1e-10);
    nlopt_set_maxeval(opt, 200);
    // Its result stays in z where it stops by rounding.
    nlopt_optimize(opt, z.data(), &plan.energy_mm);
    nlopt_destroy(opt);
  }
  plan.end = moved_from(from, z.data());
  for (std::size_t k = 0; k < n_free(); ++k) plan.length_mm = std::max(plan.length_mm, std::abs(z[k]));
  if (!has_slack) plan.energy_mm = objective(static_cast<unsigned>(n), z.data(), nullptr, &m);
  plan.violation_mm = worst_violation_mm(plan.end, features);
  return plan;
}

double CoordinateEquilibrium::Run::worst_violation_mm(const JointCoordinates& q,
                                                      const std::vector<ContactConstraint>& features) const
{
  const FeatureMeter distance_of = meter(position(q));
  double worst = 0.0;
  for (const ContactConstraint& feature : features)
    worst = std::max(worst, standoff_mm_ - distance_of(feature).distance_mm);
  return worst;
}

// The certificate of a step with roles for the coordinates, and its record.

using namespace coordinate_rules;

void CoordinateEquilibrium::Run::add_touching(const std::vector<ContactConstraint>& features)
{
  const FeatureMeter distance_of = meter(position(current_));
  for (const ContactConstraint& feature : features) {
    const FeatureDistance d = distance_of(feature);
    if (d.distance_mm < -overlap_rounding_mm || d.distance_mm > touching_within_tolerances * tolerance_mm_)
      continue;
    touching_.push_back(feature);
    distances_.push_back(d);
  }
}

void CoordinateEquilibrium::Run::update_balance()
{
  const SolverPosition at = position(current_);
  const Matrix6d twists = state_.map.twists(current_, at);
  Vector6d wrench;
  energy_nmm_ = energy_nmm(at, wrench);
  gradient_ = twists.transpose() * wrench;
  Vector6d mask = unit_;
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
    if (!is_free_[k]) mask(static_cast<Eigen::Index>(k)) = 0.0;
  }
  std::vector<HalfSpaceOf<6>> rows;
  std::vector<double> length;
  over_coordinates_.clear();
  for (const FeatureDistance& d : distances_) {
    over_coordinates_.push_back(twists.transpose() * d.wrench);
    const Vector6d normal = mask.cwiseProduct(over_coordinates_.back());
    length.push_back(std::max(normal.norm(), std::numeric_limits<double>::min()));
    rows.push_back({normal / length.back(), 0.0});
  }
  const QpSolutionOf<6> qp =
      solve_quadratic_program<6>(Matrix6d::Identity(), mask.cwiseProduct(gradient_), rows);
  unbalanced_n_ = qp.d;
  force_n_.assign(distances_.size(), 0.0);
  for (std::size_t k = 0; k < qp.n_active; ++k)
    force_n_[qp.active[k].row] = std::max(qp.active[k].multiplier, 0.0) / length[qp.active[k].row];
}

bool CoordinateEquilibrium::Run::is_certified()
{
  touching_.clear();
  distances_.clear();
  add_touching(sampled_.features);
  update_balance();
  // A constraint that is missing is a small step away, along the residual force.
  double probe_mm = tolerance_mm_;
  for (int k = 0; k < 4 && unbalanced_n_.norm() > 1e-4 * push_n_; ++k) {
    Sampled probe;
    const Vector6d step = unit_.cwiseProduct(unbalanced_n_) * (probe_mm / unbalanced_n_.norm());
    sample(current_ + step, probe, touching_within_tolerances * tolerance_mm_);
    const double before_n = unbalanced_n_.norm();
    add_touching(probe.features);
    update_balance();
    if (unbalanced_n_.norm() > 0.99 * before_n) probe_mm *= 3.0;
  }
  return unbalanced_n_.norm() <= residual_share * push_n_;
}

bool CoordinateEquilibrium::Run::resists(std::size_t coordinate, double shift)
{
  const auto row = static_cast<Eigen::Index>(coordinate);
  const double limit_mm = merit_mm(current_) + determined_tolerances * tolerance_mm_;
  JointCoordinates from = current_;
  from(row) += shift;
  is_free_[coordinate] = false;
  std::vector<ContactConstraint> features = sampled_.features;
  Sampled trial;
  bool result = true;
  for (int k = 0; k < most_trials; ++k) {
    const Plan plan = minimise(from, features, 4.0 * state_.scale.lever_mm * trial_rotation_rad);
    if (plan.violation_mm > infeasible_mm || merit_mm(plan.end) > limit_mm) break;
    sample(plan.end, trial, state_.band_mm);
    if (!std::isfinite(trial.travel_mm) || trial.travel_mm >= -tolerance_mm_) {
      result = false;
      break;
    }
    const std::size_t before = features.size();
    features.insert(features.end(), trial.features.begin(), trial.features.end());
    if (features.size() == before) break;
  }
  is_free_[coordinate] = true;
  return result;
}

// The loads that count as constant along the coordinates do no work on flexion, about the axis of which they
// have a moment all the same: over the coordinates, for what is held.
Vector6d CoordinateEquilibrium::Run::flexing_force() const
{
  const SolverPosition at = position(current_);
  const Loads& loads = task_.loads;
  const Eigen::Vector3d t = at.pose.translation_mm;
  Eigen::Vector3d moment_nmm =
      loads.point_mm.cross(loads.force_n) + loads.moment_nmm * Eigen::Vector3d::UnitY();
  if (has_applied_) {
    Loads none;
    none.force_n.setZero();
    LoadPotential exact = applied_;
    exact.constant.setZero();
    const Vector6d counted = work_of(none, &exact, at).wrench;
    moment_nmm +=
        wrench_of(loads, at.attitude, at.pose).moment_nmm - (counted.head<3>() + t.cross(counted.tail<3>()));
  }
  const SinCos varus = sin_cos(at.attitude.varus_rad);
  const double about_axis = varus.sin * moment_nmm.y() + varus.cos * moment_nmm.z();
  Vector6d wrench = Vector6d::Zero();
  wrench(2) = about_axis / varus.cos;
  return state_.map.twists(current_, at).transpose() * wrench;
}

void CoordinateEquilibrium::Run::fill_balance(StepRecord& record)
{
  Balance& out = record.balance;
  out.energy_nmm = energy_nmm_;
  out.residual_n = unbalanced_n_.norm();
  out.worst_gap_mm = sampled_.travel_mm;
  CoordinateForces held;
  Vector6d force = gradient_;
  double sum_n = 0.0, weighted = 0.0;
  for (std::size_t i = 0; i < touching_.size(); ++i) {
    if (force_n_[i] <= 0.0) continue;
    const FeatureDistance& d = distances_[i];
    ContactForce f;
    f.point_solver_mm = d.point_mm;
    f.normal_solver = d.normal;
    f.along_delta_n = force_n_[i] * -d.normal.y();
    f.triangle_reference = touching_[i].triangles.reference;
    f.triangle_moving = touching_[i].triangles.moving;
    if (!state_.joint.compartment_of_triangle.empty()) {
      f.compartment = static_cast<std::int8_t>(
          state_.joint.compartment_of_triangle[static_cast<std::size_t>(f.triangle_moving)]);
    }
    out.forces.push_back(f);
    sum_n += force_n_[i];
    weighted += force_n_[i] * std::max(d.distance_mm, 0.0);
    force -= force_n_[i] * over_coordinates_[i];
  }
  out.complementarity_mm = sum_n > 0.0 ? weighted / sum_n : 0.0;
  force -= flexing_force();
  for (std::size_t k = 0; k < n_joint_coordinates; ++k)
    held.holding[k] = is_free_[k] ? nan : force(static_cast<Eigen::Index>(k));
  out.flexion_moment_nmm = is_free_[0] ? 0.0 : held.holding[0];
  out.varus_moment_nmm = is_free_[1] ? 0.0 : held.holding[1];
  record.coordinates = held;
}

void CoordinateEquilibrium::Run::measure(StepRecord& record)
{
  const SolverPosition at = position(current_);
  state_.gap.set_attitude(at.attitude);
  measure_contacts(state_.joint, at.attitude, state_.gap, state_.narrow_phase,
                   state_.options.contact_resolution_mm, record);
  measure_gaps(state_.joint, at.attitude, at.pose, record);
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
    const double shift = is_rotation(k) ? trial_rotation_rad : trial_translation_mm;
    if (is_free_[k] && task_.tests_freedom)
      record.coordinates->determined[k] = resists(k, -shift) && resists(k, shift) ? 1 : 0;
  }
  record.theta_determined = record.coordinates->determined[2] != 0;
}

}  // namespace vrda::solve
