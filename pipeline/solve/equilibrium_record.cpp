// The certificate of a motion step and its record.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/units.hpp"
#include "solve/equilibrium_run.hpp"
#include "solve/joint.hpp"

namespace vrda::solve {

using namespace equilibrium_rules;

namespace {

// Largest unbalanced force of a certified pose, as a share of the push. Tighter when the
// plan's active set uses cutting planes, which may not be valid at the current configuration.
constexpr double unbalanced_share = 1e-2;
constexpr double unbalanced_share_with_cuts = 1e-4;
// Constraints within this many tolerances of contact may carry load: one tolerance on a slope of 10.
constexpr double touching_tolerances = 10.0;
// Gap samples a small step aside, to find a constraint that balances the residual force (a second flank).
constexpr int max_probes = 4;
constexpr double probe_growth = 3.0;  // when a probe found no new constraint
// Trust radius of a step across a ridge.
constexpr double ridge_radius_mm = 0.02;
// Required share of the gain predicted across a ridge; an estimate rejects if it misses it beyond rounding.
constexpr double ridge_gain_share = 0.5;
constexpr double rounding_share = 0.01;
// Theta is determined when a rotation by one degree either way costs this many tolerances of height.
constexpr double turn_rad = pi / 180.0;
constexpr double turn_cost_tolerances = 10.0;
// Iterations of the minimisation at the rotated angle: two or three suffice.
constexpr int max_turn_iterations = 8;
// Central differences of an energy of 1e3 N mm: rounding of 1e-9 N mm against 1e-8 of its third derivative.
constexpr double difference_rad = 1e-4;

}  // namespace

bool EquilibriumSolver::Run::is_certified(const StepPlan& plan)
{
  const double allowed = active_set_uses_cuts(plan) ? unbalanced_share_with_cuts : unbalanced_share;
  touching_.clear();
  add_touching(sample_.constraints);
  update_balance();
  double probe_mm = tolerance_mm_;
  for (int k = 0; k < max_probes && balance_.residual_n > unbalanced_share_with_cuts * push_n_; ++k) {
    // The missing constraint is a small step away, along the residual force.
    Vector5d probe = balance_.unbalanced_n * (probe_mm / balance_.residual_n);
    probe(along_y) = 0.0;
    sample_gap(moved(current_.configuration, probe, state_.scale), touching_tolerances * tolerance_mm_,
               trial_sample_);
    const double before_n = balance_.residual_n;
    add_touching(trial_sample_.constraints);
    update_balance();
    if (balance_.residual_n > 0.99 * before_n) probe_mm *= probe_growth;
  }
  return balance_.residual_n <= allowed * push_n_;
}

bool EquilibriumSolver::Run::is_at_border()
{
  if (!unbounded_trial_) return false;
  Vector5d step = step_between(current_.configuration, *unbounded_trial_, state_.scale);
  step(along_y) = 0.0;
  if (step.norm() > ridge_radius_mm) step *= ridge_radius_mm / step.norm();
  sample_gap(moved(current_.configuration, step, state_.scale), 0.0, trial_sample_);
  return !std::isfinite(trial_sample_.travel_mm);
}

bool EquilibriumSolver::Run::crosses_ridge()
{
  const Rotations rotations(current_.configuration, task_.attitude.flexion_rad);
  const auto point = [&](const ContactConstraint& constraint) {
    return Eigen::Vector3d(rotations.of_reference * constraint.reference_mm);
  };
  for (const ContactForceBalance::ActiveConstraint& active : balance_.active) {
    const Eigen::Vector3d at = point(touching_[active.row]);
    const auto is_at_point = [&](const ContactConstraint& constraint) {
      return (point(constraint) - at).cwiseAbs().maxCoeff() <= touching_tolerances * tolerance_mm_;
    };
    constraints_.clear();
    std::remove_copy_if(sample_.constraints.begin(), sample_.constraints.end(),
                        std::back_inserter(constraints_), is_at_point);
    if (std::count_if(touching_.begin(), touching_.end(), is_at_point) < 2) continue;
    for (const ContactConstraint& single : touching_) {
      if (!is_at_point(single)) continue;
      constraints_.push_back(single);
      if (accept_if_improving()) return true;
      constraints_.pop_back();
    }
  }
  return false;
}

bool EquilibriumSolver::Run::has_gain(double share, const StepPlan& plan,
                                      const EquilibriumCandidate& candidate) const
{
  return candidate.is_bounded &&
         planner_.merit_nmm(current_) - planner_.merit_nmm(candidate) >= share * plan.gain_nmm;
}

bool EquilibriumSolver::Run::accept_if_improving()
{
  plan_options_.radius_mm = ridge_radius_mm;
  const StepPlan plan = planner_.plan(current_, constraints_, plan_options_);
  if (plan.gain_nmm <= tolerance_mm_ * push_n_) return false;
  // An upper bound of the travel, from the last pair in contact, rejects most trials. Counts as a query.
  state_.set_attitude(attitude_at(plan.end.configuration));
  const double bound_mm = state_.gap.travel_upper_bound_mm(pose_at(plan.end.configuration, state_.scale));
  if (std::isfinite(bound_mm) &&
      !has_gain(ridge_gain_share - rounding_share, plan, candidate_at(plan.end.configuration, bound_mm))) {
    ++n_queries_saved_;
    return false;
  }
  sample_gap(plan.end.configuration, band_mm_, trial_sample_);
  if (!std::isfinite(trial_sample_.travel_mm)) return false;
  const EquilibriumCandidate candidate = candidate_at(plan.end.configuration, trial_sample_.travel_mm);
  if (!has_gain(ridge_gain_share, plan, candidate)) return false;
  accept(candidate);
  radius_mm_ = first_radius_mm;
  return true;
}

void EquilibriumSolver::Run::add_touching(const std::vector<ContactConstraint>& constraints)
{
  const Rotations rotations(current_.configuration, task_.attitude.flexion_rad);
  for (const ContactConstraint& constraint : constraints) {
    const double travel_mm = clearance(constraint, current_.configuration, rotations).travel_mm;
    if (travel_mm >= 0.0 && travel_mm <= touching_tolerances * tolerance_mm_) touching_.push_back(constraint);
  }
}

void EquilibriumSolver::Run::update_balance()
{
  const Rotations rotations(current_.configuration, task_.attitude.flexion_rad);
  clearances_.clear();
  for (const ContactConstraint& constraint : touching_)
    clearances_.push_back(clearance(constraint, current_.configuration, rotations));
  balance_ = balance_contact_forces(current_.potential, clearances_, state_.scale, plan_options_.is_free);
}

void EquilibriumSolver::Run::measure(StepRecord& record)
{
  const Attitude attitude = attitude_at(current_.configuration);
  contact::ContactOptions exact;
  exact.band_mm = state_.options.contact_resolution_mm;
  state_.set_attitude(attitude);
  measure_contacts(
      state_.joint,
      contact::find_contacts(state_.joint.reference, state_.joint.moving, {attitude, record.pose},
                             state_.gap.close_pairs(record.pose, exact.band_mm), state_.narrow_phase, exact),
      state_.options.contact_resolution_mm, record);
  if (!state_.joint.compartment_of_triangle.empty()) {
    record.gap_medial_mm = gap_left_mm(Compartment::medial, state_.medial, attitude, record.pose);
    record.gap_lateral_mm = gap_left_mm(Compartment::lateral, state_.lateral, attitude, record.pose);
  }
  record.theta_determined = resists_turn(-turn_rad) && resists_turn(turn_rad);
}

SearchMove EquilibriumSolver::Run::move_of(MoveKind kind, const Configuration& configuration) const
{
  SearchMove move;
  move.iteration = iteration_;
  move.kind = kind;
  move.pose = pose_at(configuration, state_.scale);
  move.translation_step_mm = radius_mm_;
  move.rotation_step_rad = radius_mm_ / state_.scale.lever_mm;
  return move;
}

void EquilibriumSolver::Run::report_trial(const Configuration& configuration)
{
  if (!observer_) return;
  has_rejected_last_ = true;
  observer_(move_of(MoveKind::trial, configuration));
}

void EquilibriumSolver::Run::report_iterate()
{
  if (!observer_) return;
  has_rejected_last_ = false;
  SearchMove move = move_of(MoveKind::iterate, current_.configuration);
  move.in_contact = true;
  const Rotations rotations(current_.configuration, task_.attitude.flexion_rad);
  for (const ContactConstraint& constraint : sample_.constraints) {
    const Clearance c = clearance(constraint, current_.configuration, rotations);
    if (!(c.travel_mm <= touching_tolerances * tolerance_mm_)) continue;
    const ContactForce force = contact_force(constraint, c, 0.0);
    move.contacts.push_back({force.point_solver_mm, force.normal_solver,
                             c.travel_mm * -force.normal_solver.y(), force.triangle_reference,
                             force.triangle_moving, force.compartment});
  }
  observer_(move);
}

double EquilibriumSolver::Run::gap_left_mm(Compartment compartment, geometry::GapQuery& query,
                                           const Attitude& attitude, const MovingPose& pose)
{
  std::vector<geometry::TrianglePair> touching;
  for (const ContactConstraint& constraint : sample_.constraints) {
    const auto row = static_cast<std::size_t>(constraint.triangles.moving);
    if (state_.joint.compartment_of_triangle[row] == compartment) touching.push_back(constraint.triangles);
  }
  // No compartment is nearer than the whole object, so one in contact needs no query.
  const double bound_mm = state_.gap.travel_upper_bound_mm(pose, touching);
  if (bound_mm <= sample_.ceiling_mm - current_.configuration.pivot_mm.y() + rounding_mm) return bound_mm;
  query.set_attitude(attitude);
  const double travel_mm = query.travel_mm(pose);
  return std::isfinite(travel_mm) ? travel_mm : std::numeric_limits<double>::quiet_NaN();
}

bool EquilibriumSolver::Run::resists_turn(double turn)
{
  const double limit_nmm = current_.potential.energy_nmm + turn_cost_tolerances * tolerance_mm_ * push_n_;
  PlanOptions options = plan_options_;
  options.is_free[about_y] = false;
  options.radius_mm = 2.0 * state_.scale.lever_mm * turn_rad;
  Configuration configuration = current_.configuration;
  configuration.theta_rad += turn;
  constraints_ = sample_.constraints;
  for (int k = 0; k < max_turn_iterations; ++k) {
    const StepPlan plan = planner_.plan(candidate_under(constraints_, configuration), constraints_, options);
    if (plan.end.potential.energy_nmm > limit_nmm) return true;
    sample_gap(plan.end.configuration, trial_sample_);
    if (!std::isfinite(trial_sample_.travel_mm)) return false;
    const EquilibriumCandidate candidate = candidate_at(plan.end.configuration, trial_sample_.travel_mm);
    if (!candidate.is_bounded || candidate.potential.energy_nmm <= limit_nmm) return false;
    if (!add_cuts(trial_sample_.constraints, constraints_)) return true;
  }
  return true;
}

void EquilibriumSolver::Run::fill_balance(StepRecord& record) const
{
  Balance& out = record.balance;
  out.energy_nmm = current_.potential.energy_nmm;
  out.residual_n = balance_.residual_n;
  out.worst_gap_mm = sample_.ceiling_mm - current_.configuration.pivot_mm.y();
  double sum_n = 0.0, weighted = 0.0, varus_nmm = current_.potential.gradient(about_varus);
  for (const ContactForceBalance::ActiveConstraint& b : balance_.active) {
    const Clearance& c = clearances_[b.row];
    out.forces.push_back(contact_force(touching_[b.row], c, b.along_delta_n));
    sum_n += b.along_delta_n;
    weighted += b.along_delta_n * std::max(c.travel_mm, 0.0);
    varus_nmm -= b.along_delta_n * c.gradient(about_varus);
  }
  out.complementarity_mm = sum_n > 0.0 ? weighted / sum_n : 0.0;
  out.varus_moment_nmm = task_.is_varus_free ? 0.0 : varus_nmm;
  out.flexion_moment_nmm = flexion_moment_nmm(out.forces);
}

ContactForce EquilibriumSolver::Run::contact_force(const ContactConstraint& constraint, const Clearance& c,
                                                   double along_delta_n) const
{
  const Rotations rotations(current_.configuration, task_.attitude.flexion_rad);
  ContactForce force;
  force.point_solver_mm = contact_point_mm(constraint, current_.configuration, rotations);
  force.normal_solver = c.gradient.head<3>().normalized();  // -n / n.y
  force.along_delta_n = along_delta_n;
  force.triangle_reference = constraint.triangles.reference;
  force.triangle_moving = constraint.triangles.moving;
  if (!state_.joint.compartment_of_triangle.empty()) {
    force.compartment = static_cast<std::int8_t>(
        state_.joint.compartment_of_triangle[static_cast<std::size_t>(constraint.triangles.moving)]);
  }
  return force;
}

double EquilibriumSolver::Run::ligament_energy_at(double flexion_rad) const
{
  if (state_.ligaments.fibres.empty()) return 0.0;
  return model::ligament_energy(state_.ligaments, {flexion_rad, current_.configuration.varus_rad},
                                   pose_at(current_.configuration, state_.scale))
      .energy_nmm;
}

double EquilibriumSolver::Run::flexion_moment_nmm(const std::vector<ContactForce>& forces) const
{
  const Eigen::Vector3d axis = rotation_x(-current_.configuration.varus_rad) * Eigen::Vector3d::UnitZ();
  const Loads& loads = task_.loads;
  double sum_nmm = axis.dot(loads.point_mm.cross(loads.force_n)) + loads.moment_nmm * axis.y();
  if (forces_.applied != nullptr) {
    const Wrench applied =
        wrench_of(loads, attitude_at(current_.configuration), pose_at(current_.configuration, state_.scale));
    sum_nmm += axis.dot(applied.moment_nmm);
  }
  for (const ContactForce& f : forces) {
    const Eigen::Vector3d force_n = f.normal_solver * (f.along_delta_n / -f.normal_solver.y());
    sum_nmm += axis.dot(f.point_solver_mm.cross(force_n));
  }
  const double flexion_rad = task_.attitude.flexion_rad;
  return sum_nmm + (ligament_energy_at(flexion_rad + difference_rad) -
                    ligament_energy_at(flexion_rad - difference_rad)) /
                       (2.0 * difference_rad);
}

}  // namespace vrda::solve
