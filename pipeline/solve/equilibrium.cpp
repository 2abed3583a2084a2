#include "solve/equilibrium.hpp"

#include <algorithm>
#include <cmath>

#include "solve/equilibrium_run.hpp"

namespace vrda {

using namespace equilibrium_rules;

namespace {

// Travel left in the end, as a share of the tolerance: keeps the final pose from overlapping by rounding.
constexpr double tolerance_share_left = 0.1;
// Stiffness of the pull to the seed, as a share of the push per mm: 30 mm away it weighs 3e-5 of the push.
constexpr double spring_share_per_mm = 1e-6;
// Falls of the potential below this share of push times tolerance are rounding; what the spring alone gains
// is not worth a step.
constexpr double negligible_gain_share = 1e-6;
// Above the rounding of places, far below the standoff.
constexpr double rounding_mm = 1e-9;
constexpr double small_step_by_fibres = 0.02;  // of the tolerance
constexpr double largest_radius_mm = 16.0;
constexpr double least_radius_mm = 0.05;  // after a rejection and a step that was accepted
constexpr double accepted_share = 0.1;    // of the predicted gain
constexpr double good_share = 0.7;
constexpr double poor_share = 0.25;
constexpr std::size_t most_fresh = 200;
// As many facets of a rounded surface lie within a band as its height over a facet's area.
constexpr double band_mm_per_mm2 = 0.043;
constexpr double largest_band_mm = 0.2;
// Features wanted: more cost more than the iterations they save, fewer hide what is next.
constexpr std::size_t many_features = 20;
constexpr std::size_t few_features = 4;
// Then the way is shortened; until then the obstacles met bend it.
constexpr int most_rejections = 3;

double mean_area_mm2(const Mesh& mesh)
{
  return area_mm2(mesh) / static_cast<double>(std::max<Eigen::Index>(mesh.triangles.rows(), 1));
}

}  // namespace

double band_of(const Mesh& reference, const Mesh& moving)
{
  const double of_reference = mean_area_mm2(reference), of_moving = mean_area_mm2(moving);
  const double facet_mm2 = of_reference * of_moving / (of_reference + of_moving);
  return facet_mm2 > 0.0 ? std::min(band_mm_per_mm2 * facet_mm2, largest_band_mm) : largest_band_mm;
}

EquilibriumSolver::Run::Run(State& tools, const Task& task)
    : tools_(tools),
      task_(task),
      forces_{tools.ligaments, task.loads, tools.grip, task.attitude.flexion_rad},
      push_n_(task.loads.force_n.norm() > 0.0 ? task.loads.force_n.norm() : 1.0),
      tolerance_mm_(tools.options.tolerance_mm),
      band_mm_(tools.band_mm),
      seed_(place_at(task.seed, task.attitude.varus_rad, tools.grip)),
      planner_(forces_, {seed_, spring_share_per_mm * push_n_})
{
  plan_options_.is_free[about_varus] = task.is_varus_free;
  plan_options_.standoff_mm = tolerance_share_left * tolerance_mm_;
  plan_options_.tolerance_mm = tolerance_mm_;
  plan_options_.reach_mm = tools.reach_mm;
  plan_options_.force_tolerance_n = 1e-6 * push_n_;
}

StepRecord EquilibriumSolver::Run::run()
{
  n_queries_before_ = n_gap_queries();
  StepRecord record;
  record.status = settle();
  record.iterations = iteration_;
  record.residual_mm = residual_mm_;
  record.pose = pose_at(here_.place, tools_.grip);
  record.varus_rad = here_.place.varus_rad;
  if (record.status == StepStatus::stable) {
    if (task_.is_measured) measure(record);
    fill_balance(record);
  }
  record.queries += n_gap_queries() - n_queries_before_ + n_spared_;
  return record;
}

StepStatus EquilibriumSolver::Run::settle()
{
  here_.place = seed_;
  look(seed_, fresh_);
  if (!std::isfinite(fresh_.travel_mm)) return StepStatus::no_contact;
  here_ = rest_at(seed_, fresh_.travel_mm);
  if (!here_.is_bounded) return StepStatus::unbounded;
  // Plans see fibres to second order, so that the step after a small one is far smaller.
  const double small_step_mm = tolerance_mm_ * (tools_.ligaments.fibres.empty() ? 1.0 : small_step_by_fibres);
  radius_mm_ = first_radius_mm;
  for (iteration_ = 1; iteration_ <= tools_.options.max_iterations; ++iteration_) {
    const StepPlan plan = next_plan();
    residual_mm_ = plan.length_mm;
    const bool is_small =
        plan.length_mm <= small_step_mm || here_.potential.energy_nmm - plan.end.potential.energy_nmm <=
                                               negligible_gain_share * tolerance_mm_ * push_n_;
    if (is_small) {
      if (is_certified(plan)) {
        if (is_at_the_rim()) return StepStatus::unbounded;
        if (!passes_a_ridge()) return StepStatus::stable;
      } else if (!looks_closer()) {
        break;
      }
      continue;
    }
    if (attempt(plan) == Outcome::led_off && radius_mm_ < tolerance_mm_) return StepStatus::unbounded;
  }
  iteration_ = std::min(iteration_, tools_.options.max_iterations);
  return StepStatus::iteration_limit;
}

int EquilibriumSolver::Run::n_gap_queries() const
{
  return tools_.gap.n_queries() + tools_.medial.n_queries() + tools_.lateral.n_queries();
}

Attitude EquilibriumSolver::Run::attitude_at(const Place& place) const
{
  return {task_.attitude.flexion_rad, place.varus_rad};
}

void EquilibriumSolver::Run::look(const Place& place, GapSight& sight)
{
  look(place, band_mm_, sight);
  if (sight.n_features > many_features) band_mm_ *= 0.5;
  if (sight.n_features < few_features) band_mm_ = std::min(1.5 * band_mm_, largest_band_mm);
}

void EquilibriumSolver::Run::look(const Place& place, double band, GapSight& sight)
{
  tools_.stand(attitude_at(place));
  const GapAnswer& answer = tools_.gap.features(pose_at(place, tools_.grip), band);
  sight.n_features = answer.features.size();
  sight.travel_mm = answer.travel_mm;
  sight.ceiling_mm = place.pivot_mm.y() + answer.travel_mm;
  sight.obstacles.clear();
  const TouchingMeshes meshes{tools_.joint.reference.solid.mesh, tools_.joint.moving.solid.mesh, tools_.grip};
  const Rotations rotations(place, task_.attitude.flexion_rad);
  for (std::size_t k = 0; k < answer.features.size() && sight.obstacles.size() < most_fresh; ++k) {
    const Obstacle o = obstacle_of(answer.features[k], meshes, place, rotations);
    if (can_bear(o)) sight.obstacles.push_back(o);
  }
}

bool EquilibriumSolver::Run::can_bear(const Obstacle& o) const
{
  if (o.vertex < 0) return true;
  const std::vector<bool>& sticks_out = o.kind == Obstacle::Kind::face_of_reference
                                            ? tools_.joint.moving_sticks_out
                                            : tools_.joint.reference_sticks_out;
  return sticks_out[static_cast<std::size_t>(o.vertex)];
}

Rest EquilibriumSolver::Run::rest_at(const Place& place, double travel_mm) const
{
  return rest_along_delta(forces_, place,
                          {place.pivot_mm.y() + travel_mm - plan_options_.standoff_mm, plan_options_.reach_mm,
                           plan_options_.force_tolerance_n});
}

StepPlan EquilibriumSolver::Run::next_plan()
{
  known_ = fresh_.obstacles;
  known_.insert(known_.end(), cuts_.begin(), cuts_.end());
  plan_options_.radius_mm = radius_mm_;
  return planner_.plan(here_, known_, plan_options_);
}

bool EquilibriumSolver::Run::bears_by_cuts(const StepPlan& plan) const
{
  return std::any_of(plan.bearing.begin(), plan.bearing.begin() + static_cast<std::ptrdiff_t>(plan.n_bearing),
                     [&](std::size_t row) { return row >= fresh_.obstacles.size(); });
}

bool EquilibriumSolver::Run::holds_here(const Obstacle& obstacle, const Rotations& rotations) const
{
  return clearance(obstacle, here_.place, rotations).travel_mm >= plan_options_.standoff_mm - rounding_mm;
}

EquilibriumSolver::Run::Outcome EquilibriumSolver::Run::attempt(const StepPlan& plan)
{
  look(plan.end.place, trial_);
  const Rest rest = std::isfinite(trial_.travel_mm) ? rest_at(plan.end.place, trial_.travel_mm) : plan.end;
  if (!std::isfinite(trial_.travel_mm) || !rest.is_bounded) {
    led_off_ = plan.end.place;
    radius_mm_ = 0.25 * std::min(radius_mm_, plan.length_mm);
    return Outcome::led_off;
  }
  const double gain_nmm = planner_.merit_nmm(here_) - planner_.merit_nmm(rest);
  if (gain_nmm < accepted_share * plan.gain_nmm) {
    reject(plan);
    return Outcome::rejected;
  }
  if (n_rejections_ > 0) radius_mm_ = std::min(radius_mm_, std::max(2.0 * plan.length_mm, least_radius_mm));
  accept(rest);
  if (gain_nmm < poor_share * plan.gain_nmm) radius_mm_ = 0.5 * plan.length_mm;
  if (gain_nmm > good_share * plan.gain_nmm && plan.length_mm > 0.8 * radius_mm_)
    radius_mm_ = std::min(2.0 * radius_mm_, largest_radius_mm);
  return Outcome::accepted;
}

void EquilibriumSolver::Run::reject(const StepPlan& plan)
{
  const bool is_bent = take_cuts(trial_.obstacles, cuts_);
  ++n_rejections_;
  if (is_bent && n_rejections_ < most_rejections) return;
  n_rejections_ = 0;
  radius_mm_ = 0.25 * plan.length_mm;
}

bool EquilibriumSolver::Run::take_cuts(const std::vector<Obstacle>& met, std::vector<Obstacle>& cuts) const
{
  const Rotations rotations(here_.place, task_.attitude.flexion_rad);
  const std::size_t n_before = cuts.size();
  for (const Obstacle& o : met) {
    if (cuts.size() < n_before + most_fresh && holds_here(o, rotations)) cuts.push_back(o);
  }
  return cuts.size() > n_before;
}

void EquilibriumSolver::Run::accept(const Rest& rest)
{
  here_ = rest;
  std::swap(fresh_, trial_);
  cuts_.clear();
  n_rejections_ = 0;
}

bool EquilibriumSolver::Run::looks_closer()
{
  radius_mm_ = std::min(0.25 * radius_mm_, 1.0);
  cuts_.clear();
  n_rejections_ = 0;
  return radius_mm_ > 0.1 * tolerance_mm_;
}

EquilibriumSolver::EquilibriumSolver(const Joint& joint, const Ligaments& ligaments,
                                     const EquilibriumOptions& options)
    : state_(std::make_unique<State>(joint, ligaments, options))
{
}

EquilibriumSolver::~EquilibriumSolver() = default;
EquilibriumSolver::EquilibriumSolver(EquilibriumSolver&&) noexcept = default;

StepRecord EquilibriumSolver::solve(const Task& task)
{
  return Run(*state_, task).run();
}

}  // namespace vrda
