#include "solve/equilibrium.hpp"

#include <algorithm>
#include <cmath>

#include "solve/equilibrium_run.hpp"

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
  return state_.gap.n_queries() + state_.medial.n_queries() + state_.lateral.n_queries();
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

}  // namespace vrda::solve
