// The end of a motion step: whether it rests, and what is recorded of its rest.
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/units.hpp"
#include "solve/equilibrium_run.hpp"
#include "solve/joint.hpp"

namespace vrda {

using namespace equilibrium_rules;

namespace {

// Certified: force left unbalanced, as a share of the push (DESIGN.md 5.3). Tighter where obstacles met
// elsewhere bear the plan's load, since they may not be what holds here.
constexpr double unbalanced_share = 1e-2;
constexpr double unbalanced_share_by_cuts = 1e-4;
// Obstacles within this many tolerances of contact may bear load: a step of one tolerance against a slope
// of 10.
constexpr double touching_tolerances = 10.0;
// Looks round the corner for what holds a force left over: a vertex in a valley lies over one of its flanks.
constexpr int most_probes = 4;
constexpr double longer_hair = 3.0;  // where nothing new was seen
// How far a way past a ridge is tried.
constexpr double ridge_radius_mm = 0.02;
// Of the gain that a plan past a ridge predicts; a hint must miss it by more than rounding to decide.
constexpr double rising_share = 0.5;
constexpr double rounding_share = 0.01;
// Theta counts as determined when a degree either way costs this many tolerances of height.
constexpr double turn_rad = pi / 180.0;
constexpr double turn_cost_tolerances = 10.0;
// Looks for a cheap place at the turned angle: two or three decide.
constexpr int most_turn_looks = 8;
// Central differences of an energy of 1e3 N mm: 1e-9 N mm of rounding against 1e-8 of its third derivative.
constexpr double difference_rad = 1e-4;

}  // namespace

bool EquilibriumSolver::Run::is_certified(const StepPlan& plan)
{
  const double allowed = bears_by_cuts(plan) ? unbalanced_share_by_cuts : unbalanced_share;
  touching_.clear();
  take_touching(fresh_.obstacles);
  balance();
  double hair_mm = tolerance_mm_;
  for (int k = 0; k < most_probes && held_.residual_n > unbalanced_share_by_cuts * push_n_; ++k) {
    // What would hold the force left over lies a hair in its direction.
    Vector5d hair = held_.unbalanced_n * (hair_mm / held_.residual_n);
    hair(along_y) = 0.0;
    look(moved(here_.place, hair, tools_.grip), touching_tolerances * tolerance_mm_, trial_);
    const double before_n = held_.residual_n;
    take_touching(trial_.obstacles);
    balance();
    if (held_.residual_n > 0.99 * before_n) hair_mm *= longer_hair;
  }
  return held_.residual_n <= allowed * push_n_;
}

bool EquilibriumSolver::Run::is_at_the_rim()
{
  if (!led_off_) return false;
  Vector5d way = step_between(here_.place, *led_off_, tools_.grip);
  way(along_y) = 0.0;
  if (way.norm() > ridge_radius_mm) way *= ridge_radius_mm / way.norm();
  look(moved(here_.place, way, tools_.grip), 0.0, trial_);
  return !std::isfinite(trial_.travel_mm);
}

bool EquilibriumSolver::Run::passes_a_ridge()
{
  const Rotations rotations(here_.place, task_.attitude.flexion_rad);
  const auto point = [&](const Obstacle& o) {
    return Eigen::Vector3d(rotations.of_reference * o.reference_mm);
  };
  for (const Held::Bearing& bearing : held_.bearing) {
    const Eigen::Vector3d at = point(touching_[bearing.row]);
    const auto meets = [&](const Obstacle& o) {
      return (point(o) - at).cwiseAbs().maxCoeff() <= touching_tolerances * tolerance_mm_;
    };
    known_.clear();
    std::remove_copy_if(fresh_.obstacles.begin(), fresh_.obstacles.end(), std::back_inserter(known_), meets);
    if (std::count_if(touching_.begin(), touching_.end(), meets) < 2) continue;
    for (const Obstacle& alone : touching_) {
      if (!meets(alone)) continue;
      known_.push_back(alone);
      if (rises_really()) return true;
      known_.pop_back();
    }
  }
  return false;
}

bool EquilibriumSolver::Run::gains(double share, const StepPlan& plan, const Rest& rest) const
{
  return rest.is_bounded && planner_.merit_nmm(here_) - planner_.merit_nmm(rest) >= share * plan.gain_nmm;
}

bool EquilibriumSolver::Run::rises_really()
{
  plan_options_.radius_mm = ridge_radius_mm;
  const StepPlan plan = planner_.plan(here_, known_, plan_options_);
  if (plan.gain_nmm <= tolerance_mm_ * push_n_) return false;
  // Most do not rise, and what touched last time tells: with more travel than there is no pose is worse. It
  // counts as the query that it spares.
  tools_.stand(attitude_at(plan.end.place));
  const double most_mm = tools_.gap.travel_at_most_mm(pose_at(plan.end.place, tools_.grip));
  if (std::isfinite(most_mm) &&
      !gains(rising_share - rounding_share, plan, rest_at(plan.end.place, most_mm))) {
    ++n_spared_;
    return false;
  }
  look(plan.end.place, band_mm_, trial_);
  if (!std::isfinite(trial_.travel_mm)) return false;
  const Rest rest = rest_at(plan.end.place, trial_.travel_mm);
  if (!gains(rising_share, plan, rest)) return false;
  accept(rest);
  radius_mm_ = first_radius_mm;
  return true;
}

void EquilibriumSolver::Run::take_touching(const std::vector<Obstacle>& obstacles)
{
  const Rotations rotations(here_.place, task_.attitude.flexion_rad);
  for (const Obstacle& o : obstacles) {
    const double travel_mm = clearance(o, here_.place, rotations).travel_mm;
    if (travel_mm >= 0.0 && travel_mm <= touching_tolerances * tolerance_mm_) touching_.push_back(o);
  }
}

void EquilibriumSolver::Run::balance()
{
  const Rotations rotations(here_.place, task_.attitude.flexion_rad);
  clearances_.clear();
  for (const Obstacle& o : touching_) clearances_.push_back(clearance(o, here_.place, rotations));
  held_ = held_by(here_.potential, clearances_, tools_.grip, plan_options_.is_free);
}

void EquilibriumSolver::Run::measure(StepRecord& record)
{
  const Attitude attitude = attitude_at(here_.place);
  ContactOptions exact;
  exact.band_mm = tools_.options.contact_resolution_mm;
  tools_.stand(attitude);
  measure_contacts(
      tools_.joint,
      find_contacts(tools_.joint.reference, tools_.joint.moving, {attitude, record.pose},
                    tools_.gap.close_pairs(record.pose, exact.band_mm), tools_.narrow_phase, exact),
      tools_.options.contact_resolution_mm, record);
  if (!tools_.joint.compartment_of_triangle.empty()) {
    record.gap_medial_mm = gap_left_mm(tools_.medial, attitude, record.pose);
    record.gap_lateral_mm = gap_left_mm(tools_.lateral, attitude, record.pose);
  }
  record.theta_determined = turning_costs(-turn_rad) && turning_costs(turn_rad);
}

double EquilibriumSolver::Run::gap_left_mm(GapQuery& query, const Attitude& attitude, const MovingPose& pose)
{
  query.set_attitude(attitude);
  const double travel_mm = query.travel_mm(pose);
  return std::isfinite(travel_mm) ? travel_mm : std::numeric_limits<double>::quiet_NaN();
}

bool EquilibriumSolver::Run::turning_costs(double turn)
{
  const double most_nmm = here_.potential.energy_nmm + turn_cost_tolerances * tolerance_mm_ * push_n_;
  PlanOptions options = plan_options_;
  options.is_free[about_y] = false;
  options.radius_mm = 2.0 * tools_.grip.lever_mm * turn_rad;
  Place place = here_.place;
  place.theta_rad += turn;
  const Rotations rotations(place, task_.attitude.flexion_rad);
  known_ = fresh_.obstacles;
  for (int k = 0; k < most_turn_looks; ++k) {
    double least_mm = plan_options_.reach_mm;
    for (const Obstacle& o : known_) least_mm = std::min(least_mm, clearance(o, place, rotations).travel_mm);
    const StepPlan plan = planner_.plan(rest_at(place, least_mm), known_, options);
    if (plan.end.potential.energy_nmm > most_nmm) return true;
    look(plan.end.place, trial_);
    if (!std::isfinite(trial_.travel_mm)) return false;
    const Rest rest = rest_at(plan.end.place, trial_.travel_mm);
    if (!rest.is_bounded || rest.potential.energy_nmm <= most_nmm) return false;
    if (!take_cuts(trial_.obstacles, known_)) return true;
  }
  return true;
}

void EquilibriumSolver::Run::fill_balance(StepRecord& record) const
{
  Balance& out = record.balance;
  out.energy_nmm = here_.potential.energy_nmm;
  out.residual_n = held_.residual_n;
  out.worst_gap_mm = fresh_.ceiling_mm - here_.place.pivot_mm.y();
  double sum_n = 0.0, weighted = 0.0, varus_nmm = here_.potential.gradient(about_varus);
  for (const Held::Bearing& b : held_.bearing) {
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

ContactForce EquilibriumSolver::Run::contact_force(const Obstacle& o, const Clearance& c,
                                                   double along_delta_n) const
{
  const Rotations rotations(here_.place, task_.attitude.flexion_rad);
  ContactForce force;
  force.point_solver_mm = rotations.of_reference * o.reference_mm;
  force.normal_solver = c.gradient.head<3>().normalized();  // -n / n.y
  force.along_delta_n = along_delta_n;
  force.triangle_reference = o.triangles.reference;
  force.triangle_moving = o.triangles.moving;
  if (!tools_.joint.compartment_of_triangle.empty()) {
    force.compartment = static_cast<std::int8_t>(
        tools_.joint.compartment_of_triangle[static_cast<std::size_t>(o.triangles.moving)]);
  }
  return force;
}

double EquilibriumSolver::Run::ligament_energy_at(double flexion_rad) const
{
  if (tools_.ligaments.fibres.empty()) return 0.0;
  return ligament_energy(tools_.ligaments, {flexion_rad, here_.place.varus_rad},
                         pose_at(here_.place, tools_.grip))
      .energy_nmm;
}

double EquilibriumSolver::Run::flexion_moment_nmm(const std::vector<ContactForce>& forces) const
{
  const Eigen::Vector3d axis = rotation_x(-here_.place.varus_rad) * Eigen::Vector3d::UnitZ();
  const Loads& loads = task_.loads;
  double sum_nmm = axis.dot(loads.point_mm.cross(loads.force_n)) + loads.moment_nmm * axis.y();
  for (const ContactForce& f : forces) {
    const Eigen::Vector3d force_n = f.normal_solver * (f.along_delta_n / -f.normal_solver.y());
    sum_nmm += axis.dot(f.point_solver_mm.cross(force_n));
  }
  const double flexion_rad = task_.attitude.flexion_rad;
  return sum_nmm + (ligament_energy_at(flexion_rad + difference_rad) -
                    ligament_energy_at(flexion_rad - difference_rad)) /
                       (2.0 * difference_rad);
}

}  // namespace vrda
