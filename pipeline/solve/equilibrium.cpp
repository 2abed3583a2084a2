#include "solve/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/units.hpp"
#include "solve/compliant_contact.hpp"
#include "solve/stability_search.hpp"

namespace vrda::solve {

using namespace equilibrium_rules;

namespace {

// Travel left in the end, as a share of the tolerance: rounding must not make the final pose overlap.
constexpr double standoff_share = 0.1;
// Stiffness of the proximal term, as a share of the push per mm: 30 mm away its force is 3e-5 of the push.
constexpr double spring_share_per_mm = 1e-6;
// Gains below this share of push times tolerance are rounding or come from the proximal term alone.
constexpr double negligible_gain_share = 1e-6;
constexpr double small_step_with_fibres = 0.02;  // of the tolerance
// A plan expands fibres to second order. At the end of one this short they are expanded again, which saves
// the gap query of a trial.
constexpr double expanded_again_mm = 0.1;
constexpr double max_radius_mm = 16.0;
constexpr double min_radius_mm = 0.05;  // when a step is accepted after a rejection
constexpr double accepted_share = 0.1;  // of the predicted gain
constexpr double good_share = 0.7;
constexpr double poor_share = 0.25;
constexpr std::size_t max_constraints = 200;
// The number of facets of a curved surface within a band is proportional to its height over the facet area.
constexpr double band_mm_per_mm2 = 0.043;
constexpr double max_band_mm = 0.2;
// Range of the number of features: more cost more than the iterations they save, fewer miss the next contact.
constexpr std::size_t max_features = 20;
constexpr std::size_t min_features = 4;
// A plan that ends this near a known equilibrium, and not lower, leads to it. A tenth of the distance at
// which equilibria are distinct.
constexpr double entered_mm = 0.01;
// Until then rejected trials add cutting planes; then the trust region shrinks.
constexpr int max_rejections = 3;
// Loads that turn with an object are turned again at each pose found until they change by less than this
// share of the push: a hundredth of the smallest residual that a certificate demands.
constexpr double turned_share = 1e-6;
constexpr int max_turns = 50;

double push_of(const Loads& loads)
{
  return loads.force_n.norm() > 0.0 ? loads.force_n.norm() : 1.0;
}

double mean_area_mm2(const Mesh& mesh)
{
  return area_mm2(mesh) / static_cast<double>(std::max<Eigen::Index>(mesh.triangles.rows(), 1));
}

}  // namespace

double feature_band_mm(const Mesh& reference, const Mesh& moving)
{
  const double of_reference = mean_area_mm2(reference), of_moving = mean_area_mm2(moving);
  const double facet_mm2 = of_reference * of_moving / (of_reference + of_moving);
  return facet_mm2 > 0.0 ? std::min(band_mm_per_mm2 * facet_mm2, max_band_mm) : max_band_mm;
}

EquilibriumSolver::Run::Run(State& state, const Task& task, const LoadPotential* applied,
                            const SearchObserver& observer)
    : state_(state),
      task_(task),
      observer_(observer),
      forces_{state.ligaments, task.loads, state.scale, task.attitude.flexion_rad, nullptr, applied},
      push_n_(push_of(task.loads)),
      tolerance_mm_(state.options.tolerance_mm),
      band_mm_(state.band_mm),
      seed_(configuration_at(task.seed, task.attitude.varus_rad, state.scale)),
      planner_(forces_, {seed_, spring_share_per_mm * push_n_})
{
  plan_options_.is_free[about_varus] = task.is_varus_free;
  plan_options_.standoff_mm = standoff_share * tolerance_mm_;
  plan_options_.tolerance_mm = tolerance_mm_;
  plan_options_.reach_mm = state.reach_mm;
  plan_options_.force_tolerance_n = 1e-6 * push_n_;
}

StepRecord EquilibriumSolver::Run::run()
{
  n_queries_before_ = n_gap_queries();
  StepRecord record;
  record.status = find_equilibrium();
  if (entered_ != nullptr) {
    record = *entered_;
    current_.configuration = configuration_at(record.pose, record.varus_rad, state_.scale);
    report_iterate();
    record.iterations = iteration_;
    record.queries = n_gap_queries() - n_queries_before_ + n_queries_saved_;
    return record;
  }
  if (has_rejected_last_) report_iterate();  // a trace ends at the result
  record.iterations = iteration_;
  record.residual_mm = residual_mm_;
  record.pose = pose_at(current_.configuration, state_.scale);
  record.varus_rad = current_.configuration.varus_rad;
  if (record.status == StepStatus::stable) {
    if (task_.is_measured) measure(record);
    fill_balance(record);
  }
  record.queries += n_gap_queries() - n_queries_before_ + n_queries_saved_;
  return record;
}

StepStatus EquilibriumSolver::Run::find_equilibrium()
{
  current_.configuration = seed_;
  sample_gap(seed_, sample_);
  if (!std::isfinite(sample_.travel_mm)) return StepStatus::no_contact;
  current_ = candidate_at(seed_, sample_.travel_mm);
  if (!current_.is_bounded) return StepStatus::unbounded;
  // A plan approximates fibres to second order; the step after a small one is much smaller.
  small_step_mm_ = tolerance_mm_ * (forces_.is_linear() ? 1.0 : small_step_with_fibres);
  radius_mm_ = first_radius_mm;
  report_iterate();
  for (iteration_ = 1; iteration_ <= state_.options.max_iterations; ++iteration_) {
    const StepPlan plan = next_plan();
    residual_mm_ = plan.length_mm;
    const bool is_small =
        plan.length_mm <= small_step_mm_ || current_.potential.energy_nmm - plan.end.potential.energy_nmm <=
                                                negligible_gain_share * tolerance_mm_ * push_n_;
    if (is_small) {
      if (is_certified(plan)) {
        if (is_at_border()) return StepStatus::unbounded;
        if (!crosses_ridge()) return StepStatus::stable;
      } else if (!shrink_trust_region()) {
        break;
      }
      continue;
    }
    entered_ = entered(plan);
    if (entered_ != nullptr) return StepStatus::stable;
    if (attempt(plan) == Outcome::unbounded && radius_mm_ < tolerance_mm_) return StepStatus::unbounded;
  }
  iteration_ = std::min(iteration_, state_.options.max_iterations);
  return StepStatus::iteration_limit;
}

int EquilibriumSolver::Run::n_gap_queries() const
{
  return state_.gap.n_queries() + state_.compartment_gap[0].n_queries() +
         state_.compartment_gap[1].n_queries();
}

Attitude EquilibriumSolver::Run::attitude_at(const Configuration& configuration) const
{
  return {task_.attitude.flexion_rad, configuration.varus_rad};
}

void EquilibriumSolver::Run::sample_gap(const Configuration& configuration, GapSample& sample)
{
  sample_gap(configuration, band_mm_, sample);
  if (sample.n_features > max_features) band_mm_ *= 0.5;
  if (sample.n_features < min_features) band_mm_ = std::min(1.5 * band_mm_, max_band_mm);
}

void EquilibriumSolver::Run::sample_gap(const Configuration& configuration, double band, GapSample& sample)
{
  state_.set_attitude(attitude_at(configuration));
  const geometry::GapResult& answer = state_.gap.features(pose_at(configuration, state_.scale), band);
  sample.n_features = answer.features.size();
  sample.travel_mm = answer.travel_mm;
  sample.ceiling_mm = configuration.pivot_mm.y() + answer.travel_mm;
  sample.constraints.clear();
  const ConstraintMeshes meshes{state_.joint.reference.tree_mesh.mesh, state_.joint.moving.tree_mesh.mesh,
                                state_.scale};
  const Rotations rotations(configuration, task_.attitude.flexion_rad);
  for (std::size_t k = 0; k < answer.features.size() && sample.constraints.size() < max_constraints; ++k) {
    const ContactConstraint constraint =
        contact_constraint_of(answer.features[k], meshes, configuration, rotations);
    if (can_carry_load(constraint, state_.joint)) sample.constraints.push_back(constraint);
  }
}

bool can_carry_load(const ContactConstraint& constraint, const Joint& joint)
{
  if (constraint.vertex < 0) return true;
  const std::vector<bool>& protrudes = constraint.kind == ContactConstraint::Kind::face_of_reference
                                           ? joint.moving_protrudes
                                           : joint.reference_protrudes;
  return protrudes[static_cast<std::size_t>(constraint.vertex)];
}

EquilibriumCandidate EquilibriumSolver::Run::candidate_at(const Configuration& configuration,
                                                          double travel_mm) const
{
  return equilibrium_along_delta(forces_, configuration,
                                 {configuration.pivot_mm.y() + travel_mm - plan_options_.standoff_mm,
                                  plan_options_.reach_mm, plan_options_.force_tolerance_n});
}

StepPlan EquilibriumSolver::Run::next_plan()
{
  constraints_ = sample_.constraints;
  constraints_.insert(constraints_.end(), cuts_.begin(), cuts_.end());
  plan_options_.radius_mm = radius_mm_;
  StepPlan plan = planner_.plan(current_, constraints_, plan_options_);
  const bool is_expanded_again =
      !forces_.is_linear() && plan.length_mm <= expanded_again_mm && plan.length_mm > small_step_mm_;
  if (!is_expanded_again) return plan;
  const EquilibriumCandidate from = candidate_under(constraints_, plan.end.configuration);
  if (!from.is_bounded) return plan;
  const StepPlan rest = planner_.plan(from, constraints_, plan_options_);
  const double gain_nmm = planner_.merit_nmm(current_) - planner_.merit_nmm(from) + rest.gain_nmm;
  if (gain_nmm <= 0.0) return plan;
  plan = rest;
  plan.gain_nmm = gain_nmm;
  plan.length_mm =
      largest_but_height(step_between(current_.configuration, rest.end.configuration, state_.scale));
  return plan;
}

EquilibriumCandidate EquilibriumSolver::Run::candidate_under(
    const std::vector<ContactConstraint>& constraints, const Configuration& configuration) const
{
  const Rotations rotations(configuration, task_.attitude.flexion_rad);
  double least_mm = plan_options_.reach_mm;
  for (const ContactConstraint& constraint : constraints)
    least_mm = std::min(least_mm, clearance(constraint, configuration, rotations).travel_mm);
  return candidate_at(configuration, least_mm);
}

const StepRecord* EquilibriumSolver::Run::entered(const StepPlan& plan) const
{
  if (task_.known == nullptr) return nullptr;
  const double least_nmm = plan.end.potential.energy_nmm + negligible_gain_share * tolerance_mm_ * push_n_;
  const auto is_end = [&](const StepRecord& known) {
    if (known.status != StepStatus::stable || known.balance.energy_nmm > least_nmm) return false;
    const Configuration there = configuration_at(known.pose, known.varus_rad, state_.scale);
    return step_between(plan.end.configuration, there, state_.scale).norm() <= entered_mm;
  };
  const auto found = std::find_if(task_.known->begin(), task_.known->end(), is_end);
  return found == task_.known->end() ? nullptr : &*found;
}

bool EquilibriumSolver::Run::active_set_uses_cuts(const StepPlan& plan) const
{
  return std::any_of(plan.active.begin(), plan.active.begin() + static_cast<std::ptrdiff_t>(plan.n_active),
                     [&](std::size_t row) { return row >= sample_.constraints.size(); });
}

bool EquilibriumSolver::Run::is_satisfied_here(const ContactConstraint& constraint,
                                               const Rotations& rotations) const
{
  return clearance(constraint, current_.configuration, rotations).travel_mm >=
         plan_options_.standoff_mm - rounding_mm;
}

EquilibriumSolver::Run::Outcome EquilibriumSolver::Run::attempt(const StepPlan& plan)
{
  sample_gap(plan.end.configuration, trial_sample_);
  const EquilibriumCandidate candidate = std::isfinite(trial_sample_.travel_mm)
                                             ? candidate_at(plan.end.configuration, trial_sample_.travel_mm)
                                             : plan.end;
  if (!std::isfinite(trial_sample_.travel_mm) || !candidate.is_bounded) {
    unbounded_trial_ = plan.end.configuration;
    radius_mm_ = 0.25 * std::min(radius_mm_, plan.length_mm);
    return Outcome::unbounded;
  }
  const double gain_nmm = planner_.merit_nmm(current_) - planner_.merit_nmm(candidate);
  if (gain_nmm < accepted_share * plan.gain_nmm) {
    report_trial(candidate.configuration);
    reject(plan);
    return Outcome::rejected;
  }
  if (n_rejections_ > 0) radius_mm_ = std::min(radius_mm_, std::max(2.0 * plan.length_mm, min_radius_mm));
  accept(candidate);
  if (gain_nmm < poor_share * plan.gain_nmm) radius_mm_ = 0.5 * plan.length_mm;
  if (gain_nmm > good_share * plan.gain_nmm && plan.length_mm > 0.8 * radius_mm_)
    radius_mm_ = std::min(2.0 * radius_mm_, max_radius_mm);
  return Outcome::accepted;
}

void EquilibriumSolver::Run::reject(const StepPlan& plan)
{
  const bool has_new_cuts = add_cuts(trial_sample_.constraints, cuts_);
  ++n_rejections_;
  if (has_new_cuts && n_rejections_ < max_rejections) return;
  n_rejections_ = 0;
  radius_mm_ = 0.25 * plan.length_mm;
}

bool EquilibriumSolver::Run::add_cuts(const std::vector<ContactConstraint>& found,
                                      std::vector<ContactConstraint>& cuts) const
{
  const Rotations rotations(current_.configuration, task_.attitude.flexion_rad);
  const std::size_t n_before = cuts.size();
  for (const ContactConstraint& constraint : found) {
    if (cuts.size() < n_before + max_constraints && is_satisfied_here(constraint, rotations))
      cuts.push_back(constraint);
  }
  return cuts.size() > n_before;
}

void EquilibriumSolver::Run::accept(const EquilibriumCandidate& candidate)
{
  current_ = candidate;
  std::swap(sample_, trial_sample_);
  cuts_.clear();
  n_rejections_ = 0;
  report_iterate();
}

bool EquilibriumSolver::Run::shrink_trust_region()
{
  radius_mm_ = std::min(0.25 * radius_mm_, 1.0);
  cuts_.clear();
  n_rejections_ = 0;
  return radius_mm_ > 0.1 * tolerance_mm_;
}

EquilibriumSolver::EquilibriumSolver(const Joint& joint, const model::Ligaments& ligaments,
                                     const EquilibriumOptions& options)
    : state_(std::make_unique<State>(joint, ligaments, options))
{
  if (options.contact_stiffness_n_per_mm3 > 0.0)
    state_->compliant = std::make_shared<CompliantSolver>(joint, ligaments, options);
}

EquilibriumSolver::~EquilibriumSolver() = default;
EquilibriumSolver::EquilibriumSolver(EquilibriumSolver&&) noexcept = default;

namespace {

// The record without what a stable pose alone has.
StepRecord unconverged(const StepRecord& record)
{
  StepRecord out;
  out.status = StepStatus::iteration_limit;
  out.pose = record.pose;
  out.varus_rad = record.varus_rad;
  out.residual_mm = record.residual_mm;
  out.iterations = record.iterations;
  out.queries = record.queries;
  return out;
}

}  // namespace

StepRecord EquilibriumSolver::solve(const Task& task, const SearchObserver& observer)
{
  if (state_->compliant) return state_->compliant->solve(task, observer);
  if (task.loads.applied.empty() && task.loads.lines.empty())
    return Run(*state_, task, nullptr, observer).run();
  return solve_with_turned_loads(task, observer);
}

StepRecord EquilibriumSolver::solve_with_turned_loads(const Task& task, const SearchObserver& observer)
{
  Task pass = task;
  LoadPotential loads = potential_near(task.loads, task.attitude, task.seed);
  // An energy depends on the pose at which the loads were turned, so that of another step decides nothing.
  if (!task.loads.applied.empty()) pass.known = nullptr;
  int iterations = 0, queries = 0;
  SearchObserver counted;
  if (observer) {
    counted = [&](const SearchMove& move) {
      SearchMove later = move;
      later.iteration += iterations;
      observer(later);
    };
  }
  StepRecord record;
  for (int k = 0; k < max_turns; ++k) {
    record = Run(*state_, pass, &loads, counted).run();
    iterations += record.iterations;
    queries += record.queries;
    record.iterations = iterations;
    record.queries = queries;
    if (record.status != StepStatus::stable) return record;
    const Attitude attitude{task.attitude.flexion_rad, record.varus_rad};
    const LoadPotential turned = potential_near(task.loads, attitude, record.pose);
    Vector5d change =
        energy_of(turned, attitude, record.pose).gradient - energy_of(loads, attitude, record.pose).gradient;
    if (!task.is_varus_free) {
      record.balance.varus_moment_nmm += change(about_varus);
      change(about_varus) = 0.0;
    }
    change.tail<2>() /= state_->scale.lever_mm;
    if (change.norm() <= turned_share * push_of(task.loads)) return record;
    pass.attitude.varus_rad = record.varus_rad;
    pass.seed = record.pose;
    loads = turned;
  }
  return unconverged(record);
}

// The certificate of a motion step and its record.

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
  state_.set_attitude(attitude);
  measure_contacts(state_.joint, attitude, state_.gap, state_.narrow_phase,
                   state_.options.contact_resolution_mm, record);
  if (!state_.joint.compartment_of_triangle.empty()) {
    for (const Compartment side : all_compartments)
      record.gap_mm[side] = gap_left_mm(side, attitude, record.pose);
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

double EquilibriumSolver::Run::gap_left_mm(Compartment compartment, const Attitude& attitude,
                                           const MovingPose& pose)
{
  std::vector<geometry::TrianglePair> touching;
  for (const ContactConstraint& constraint : sample_.constraints) {
    const auto row = static_cast<std::size_t>(constraint.triangles.moving);
    if (state_.joint.compartment_of_triangle[row] == compartment) touching.push_back(constraint.triangles);
  }
  // No compartment is nearer than the whole object, so one in contact needs no query.
  const double bound_mm = state_.gap.travel_upper_bound_mm(pose, touching);
  if (bound_mm <= sample_.ceiling_mm - current_.configuration.pivot_mm.y() + rounding_mm) return bound_mm;
  return state_.compartment_gap[compartment].gap_mm(attitude, pose);
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
  const double overlap = overlap_mm(state_.joint.reference.tree_mesh.mesh, constraint.triangles.reference);
  if (overlap > 0.0) force.point_solver_mm += overlap * force.normal_solver;
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

// Balance of the compartments of a step: the rule of the spine by search.

double imbalance_mm(const StepRecord& record)
{
  const double difference = std::abs(record.gap_mm[0] - record.gap_mm[1]);
  const bool is_known = record.status == StepStatus::stable && std::isfinite(difference);
  return is_known ? difference : std::numeric_limits<double>::infinity();
}

bool is_better_balanced(const StepRecord& a, const StepRecord& b)
{
  const bool a_touches = a.status == StepStatus::stable && a.is_in_contact[0] && a.is_in_contact[1];
  const bool b_touches = b.status == StepStatus::stable && b.is_in_contact[0] && b.is_in_contact[1];
  if (a_touches != b_touches) return a_touches;
  if (a_touches) return a.pose.translation_mm.y() > b.pose.translation_mm.y();
  return imbalance_mm(a) < imbalance_mm(b);
}

// Directions in which the stability search rotates and translates next, from the contacts (thesis 3.4 and
// 3.5).

namespace {

// A moment (mm, unit normal) or a projection below this is rounding: contact points are accurate to 1e-8 mm.
constexpr double negligible = 1e-7;

// Limit of iterations over the contacts; ten are rarely needed.
constexpr std::size_t max_prediction_steps = 100;

// +1 or -1 when all moments that are not negligible agree in sign, 0 otherwise. Contact `skipped` is ignored.
int common_sign(const std::vector<contact::Contact>& contacts, const Eigen::Vector3d& centre,
                std::size_t skipped)
{
  int sign = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (k == skipped) continue;
    const double moment = moment_about_mm(contacts[k], centre);
    if (std::abs(moment) <= negligible) continue;
    const int own = moment > 0.0 ? 1 : -1;
    if (sign != 0 && own != sign) return 0;
    sign = own;
  }
  return sign;
}

// Whether a normal that is not parallel to Delta has no moment about the centre.
bool passes_through(const contact::Contact& contact, const Eigen::Vector3d& centre)
{
  const bool is_oblique =
      std::abs(contact.normal.x()) > negligible || std::abs(contact.normal.z()) > negligible;
  return is_oblique && std::abs(moment_about_mm(contact, centre)) <= negligible;
}

// Mean of the positive components; 0 without any.
class HalfAxis {
 public:
  void add(double component)
  {
    if (component <= 0.0) return;
    sum_ += component;
    ++n_;
  }
  double mean() const { return n_ > 0 ? sum_ / n_ : 0.0; }

 private:
  double sum_ = 0.0;
  int n_ = 0;
};

using Vectors = std::vector<Eigen::Vector3d>;

// The point nearest to the origin on the line or plane through two or three corners, if it is between them.
std::optional<Eigen::Vector3d> nearest_on_span(const Vectors& c)
{
  if (c.size() == 1) return c[0];
  const Eigen::Vector3d u = c[1] - c[0];
  if (c.size() == 2) {
    const double t = -c[0].dot(u) / u.squaredNorm();
    if (t > 0.0 && t < 1.0) return c[0] + t * u;
    return std::nullopt;
  }
  const Eigen::Vector3d v = c[2] - c[0];
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), cu = -c[0].dot(u), cv = -c[0].dot(v);
  const double area_sq = uu * vv - uv * uv;
  const double s = (cu * vv - cv * uv) / area_sq, t = (cv * uu - cu * uv) / area_sq;
  if (s > 0.0 && t > 0.0 && s + t < 1.0) return c[0] + s * u + t * v;
  return std::nullopt;
}

struct Nearest {
  Eigen::Vector3d point;
  Vectors corners;  // the fewest that span it
};

// Over the corners, edges and faces of a simplex of at most four corners.
Nearest nearest_of_simplex(const Vectors& simplex)
{
  std::optional<Nearest> best;
  for (unsigned chosen = 1; chosen < 1U << simplex.size(); ++chosen) {
    Vectors corners;
    for (std::size_t k = 0; k < simplex.size(); ++k) {
      if ((chosen >> k & 1U) != 0) corners.push_back(simplex[k]);
    }
    if (corners.size() > 3) continue;
    const std::optional<Eigen::Vector3d> point = nearest_on_span(corners);
    if (point && (!best || point->squaredNorm() < best->point.squaredNorm())) best = {*point, corners};
  }
  return *best;
}

// Gilbert, Johnson and Keerthi (1988): adds the support point towards the origin to the simplex until none is
// nearer. Zero when the hull contains the origin: then no plane has all points on its far side.
Eigen::Vector3d nearest_of_hull(const Vectors& points)
{
  Nearest nearest{points.front(), {points.front()}};
  for (std::size_t k = 0; k < max_prediction_steps; ++k) {
    const Eigen::Vector3d& p = nearest.point;
    const double distance_sq = p.squaredNorm();
    if (distance_sq <= negligible * negligible) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d& support = *std::min_element(
        points.begin(), points.end(), [&](const auto& l, const auto& r) { return l.dot(p) < r.dot(p); });
    if (support.dot(p) >= (1.0 - negligible) * distance_sq) return p;
    Vectors simplex = nearest.corners;
    simplex.push_back(support);
    const Nearest next = nearest_of_simplex(simplex);
    // No progress: the simplex contains the origin, or what is left to gain is rounding.
    if (next.point.squaredNorm() >= distance_sq) {
      if (support.dot(p) > 0.0) return p;
      break;
    }
    nearest = next;
  }
  return Eigen::Vector3d::Zero();
}

}  // namespace

double moment_about_mm(const contact::Contact& contact, const Eigen::Vector3d& centre)
{
  const Eigen::Vector3d arm = contact.application_mm - centre;
  return arm.z() * contact.normal.x() - arm.x() * contact.normal.z();
}

Eigen::Vector3d mean_point(const std::vector<contact::Contact>& contacts)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const contact::Contact& c : contacts) sum += c.application_mm;
  return contacts.empty() ? sum : Eigen::Vector3d(sum / static_cast<double>(contacts.size()));
}

RotationPrediction predict_rotation(const std::vector<contact::Contact>& contacts)
{
  if (contacts.size() < 2) return {};
  const std::size_t none_skipped = contacts.size();
  const Eigen::Vector3d middle = mean_point(contacts);
  const int sign = common_sign(contacts, middle, none_skipped);
  if (sign != 0) return {sign, middle};
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int n_centres = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (common_sign(contacts, contacts[k].application_mm, k) == 0) continue;
    sum += contacts[k].application_mm;
    ++n_centres;
  }
  if (n_centres == 0) return {};
  const Eigen::Vector3d centre = sum / n_centres;
  // Two opposite forces on one line both qualify and their mean is on that line; a third contact beside it
  // translates the object instead.
  if (std::any_of(contacts.begin(), contacts.end(),
                  [&](const contact::Contact& c) { return passes_through(c, centre); }))
    return {};
  return {common_sign(contacts, centre, none_skipped), centre};
}

RotationPrediction predict_rotation_about(const std::vector<contact::Contact>& contacts,
                                          const Eigen::Vector3d& centre_mm)
{
  return {contacts.empty() ? 0 : common_sign(contacts, centre_mm, contacts.size()), centre_mm};
}

Eigen::Vector3d predict_translation(const std::vector<contact::Contact>& contacts)
{
  HalfAxis plus_x, minus_x, plus_z, minus_z;
  for (const contact::Contact& c : contacts) {
    const double length = std::sqrt(c.normal.x() * c.normal.x() + c.normal.z() * c.normal.z());
    if (length <= negligible) continue;
    const double x = c.normal.x() / length, z = c.normal.z() / length;
    plus_x.add(x);
    minus_x.add(-x);
    plus_z.add(z);
    minus_z.add(-z);
  }
  return {plus_x.mean() - minus_x.mean(), 0.0, plus_z.mean() - minus_z.mean()};
}

Ascent predict_ascent(const std::vector<contact::Contact>& contacts, std::optional<double> lever_mm,
                      const HeldMotions& held, const Eigen::Vector3d& origin_mm)
{
  if (contacts.empty()) return {};
  const bool turns = lever_mm.has_value() && !held.theta;
  Ascent climb;
  climb.centre_mm = held.any_translation() ? origin_mm : mean_point(contacts);
  std::vector<Eigen::Vector3d> slopes;
  for (const contact::Contact& c : contacts) {
    const double moment = turns ? moment_about_mm(c, climb.centre_mm) / *lever_mm : 0.0;
    const double x = held.x ? 0.0 : c.normal.x(), z = held.z ? 0.0 : c.normal.z();
    slopes.push_back(Eigen::Vector3d(x, moment, z) / -c.normal.y());
  }
  const Eigen::Vector3d nearest = nearest_of_hull(slopes);
  climb.rise = nearest.norm();
  if (climb.rise <= negligible) return {};
  climb.direction = Eigen::Vector3d(nearest.x(), 0.0, nearest.z()) / climb.rise;
  if (turns) climb.turn_rad_per_mm = nearest.y() / climb.rise / *lever_mm;
  return climb;
}

}  // namespace vrda::solve
