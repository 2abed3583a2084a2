#include "solve/equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/error.hpp"
#include "core/units.hpp"
#include "solve/balance.hpp"
#include "solve/measures.hpp"
#include "solve/step_plan.hpp"

namespace vrda {
namespace {

// Travel left in the end, as a share of the tolerance: keeps the final pose from overlapping by rounding.
constexpr double standoff_share = 0.1;
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
// Stiffness of the pull to the seed, as a share of the push per mm: 30 mm away it weighs 3e-5 of the push.
constexpr double spring_share_per_mm = 1e-6;
// Falls of the potential below this share of push times tolerance are rounding; what the spring alone gains
// is not worth a step.
constexpr double negligible_gain_share = 1e-6;

// How far a way past a ridge is tried.
constexpr double ridge_radius_mm = 0.02;
// Above the rounding of places, far below the standoff.
constexpr double rounding_mm = 1e-9;

constexpr double first_radius_mm = 2.0;
constexpr double largest_radius_mm = 16.0;
constexpr double least_radius_mm = 0.05;  // after a rejection and a step that was accepted
constexpr double accepted_share = 0.1;    // of the predicted gain
constexpr double good_share = 0.7;
constexpr double poor_share = 0.25;
// Features asked for: the nearest within a band. What lies beyond comes as cuts of rejected steps.
// Measured: 0.3 mm saves a query in six and costs 14 times as many features on a real knee.
constexpr double band_mm = 0.05;
constexpr std::size_t most_fresh = 200;
// Then the way is shortened; until then the obstacles met bend it.
constexpr int most_rejections = 3;
// Theta counts as determined when a degree either way costs this many tolerances of height.
constexpr double turn_rad = pi / 180.0;
constexpr double turn_cost_tolerances = 10.0;
// A degree at 60 mm from the axis against slopes of 0.3.
constexpr double turn_band_mm = 0.3;

Grip grip_of(const Mesh& moving)
{
  const Box box = bounding_box(moving);
  const Eigen::Vector3d middle = 0.5 * (box.min_mm + box.max_mm), size = box.max_mm - box.min_mm;
  return {{middle.x(), 0.0, middle.z()}, std::max(0.5 * std::max(size.x(), size.z()), 1e-6)};
}

// Central differences of an energy of 1e3 N mm: 1e-9 N mm of rounding against 1e-8 of its third derivative.
constexpr double difference_rad = 1e-4;

}  // namespace

struct EquilibriumSolver::State {
  State(const Joint& j, const Ligaments& l, const EquilibriumOptions& o)
      : joint(j),
        ligaments(l),
        options(o),
        grip(grip_of(j.moving.solid.mesh)),
        reach_mm(2.0 * (extent_along_delta_mm(j.reference.solid.mesh) +
                        extent_along_delta_mm(j.moving.solid.mesh))),
        gap(j.reference_gap, j.moving_gap),
        medial(j.reference_gap, j.medial_gap),
        lateral(j.reference_gap, j.lateral_gap)
  {
  }

  // Turning the reference costs time: only when it is not there.
  void stand(const Attitude& attitude)
  {
    if (stands && at.flexion_rad == attitude.flexion_rad && at.varus_rad == attitude.varus_rad) return;
    gap.set_attitude(attitude);
    at = attitude;
    stands = true;
  }

  const Joint& joint;
  const Ligaments& ligaments;
  EquilibriumOptions options;
  Grip grip;
  double reach_mm;
  GapQuery gap;
  GapQuery medial;
  GapQuery lateral;
  NarrowPhase narrow_phase;
  Attitude at;  // of `gap`
  bool stands = false;
};

namespace {

struct Sight {
  double travel_mm = 0.0;
  double ceiling_mm = 0.0;          // height of the pivot at the first touch
  std::vector<Obstacle> obstacles;  // nearest first
};

}  // namespace

class EquilibriumSolver::Run {
 public:
  Run(State& tools, const Task& task)
      : tools_(tools),
        task_(task),
        forces_{tools.ligaments, task.loads, tools.grip, task.attitude.flexion_rad},
        push_n_(task.loads.force_n.norm() > 0.0 ? task.loads.force_n.norm() : 1.0),
        tolerance_mm_(tools.options.tolerance_mm),
        seed_(place_at(task.seed, task.attitude.varus_rad, tools.grip)),
        planner_(forces_, {seed_, spring_share_per_mm * push_n_})
  {
    plan_options_.is_free[about_varus] = task.is_varus_free;
    plan_options_.standoff_mm = standoff_share * tolerance_mm_;
    plan_options_.tolerance_mm = tolerance_mm_;
    plan_options_.reach_mm = tools.reach_mm;
    plan_options_.force_tolerance_n = 1e-6 * push_n_;
  }

  StepRecord run()
  {
    n_queries_before_ = n_gap_queries();
    StepRecord record;
    record.status = settle();
    record.iterations = iteration_;
    record.residual_mm = residual_mm_;
    record.pose = pose_at(here_.place, tools_.grip);
    record.varus_rad = here_.place.varus_rad;
    if (record.status == StepStatus::stable) measure(record);
    record.queries += n_gap_queries() - n_queries_before_;
    return record;
  }

 private:
  enum class Outcome { accepted, rejected, led_off };

  StepStatus settle()
  {
    here_.place = seed_;
    look(seed_, band_mm, fresh_);
    if (!std::isfinite(fresh_.travel_mm)) return StepStatus::no_contact;
    here_ = rest_at(seed_, fresh_.travel_mm);
    if (!here_.is_bounded) return StepStatus::unbounded;
    radius_mm_ = first_radius_mm;
    for (iteration_ = 1; iteration_ <= tools_.options.max_iterations; ++iteration_) {
      const StepPlan plan = next_plan();
      residual_mm_ = plan.length_mm;
      const bool is_small =
          plan.length_mm <= tolerance_mm_ || here_.potential.energy_nmm - plan.end.potential.energy_nmm <=
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

  int n_gap_queries() const
  {
    return tools_.gap.n_queries() + tools_.medial.n_queries() + tools_.lateral.n_queries();
  }

  Attitude attitude_at(const Place& place) const { return {task_.attitude.flexion_rad, place.varus_rad}; }

  void look(const Place& place, double band, Sight& sight)
  {
    tools_.stand(attitude_at(place));
    const GapAnswer& answer = tools_.gap.features(pose_at(place, tools_.grip), band);
    sight.travel_mm = answer.travel_mm;
    sight.ceiling_mm = place.pivot_mm.y() + answer.travel_mm;
    sight.obstacles.clear();
    const TouchingMeshes meshes{tools_.joint.reference.solid.mesh, tools_.joint.moving.solid.mesh,
                                tools_.grip};
    const Rotations rotations(place, task_.attitude.flexion_rad);
    for (std::size_t k = 0; k < answer.features.size() && sight.obstacles.size() < most_fresh; ++k) {
      const Obstacle o = obstacle_of(answer.features[k], meshes, place, rotations);
      if (can_bear(o)) sight.obstacles.push_back(o);
    }
  }

  // A vertex in the flat or in a hollow extends to an obstacle that is not there.
  bool can_bear(const Obstacle& o) const
  {
    if (o.vertex < 0) return true;
    const std::vector<bool>& sticks_out = o.kind == Obstacle::Kind::face_of_reference
                                              ? tools_.joint.moving_sticks_out
                                              : tools_.joint.reference_sticks_out;
    return sticks_out[static_cast<std::size_t>(o.vertex)];
  }

  Rest rest_at(const Place& place, double travel_mm) const
  {
    return rest_along_delta(forces_, place,
                            {place.pivot_mm.y() + travel_mm - plan_options_.standoff_mm,
                             plan_options_.reach_mm, plan_options_.force_tolerance_n});
  }

  StepPlan next_plan()
  {
    known_ = fresh_.obstacles;
    known_.insert(known_.end(), cuts_.begin(), cuts_.end());
    plan_options_.radius_mm = radius_mm_;
    return planner_.plan(here_, known_, plan_options_);
  }

  bool bears_by_cuts(const StepPlan& plan) const
  {
    return std::any_of(plan.bearing.begin(),
                       plan.bearing.begin() + static_cast<std::ptrdiff_t>(plan.n_bearing),
                       [&](std::size_t row) { return row >= fresh_.obstacles.size(); });
  }

  // Where it stands the obstacle must leave the standoff; one that does not was extended too far.
  bool holds_here(const Obstacle& obstacle, const Rotations& rotations) const
  {
    return clearance(obstacle, here_.place, rotations).travel_mm >= plan_options_.standoff_mm - rounding_mm;
  }

  Outcome attempt(const StepPlan& plan)
  {
    look(plan.end.place, band_mm, trial_);
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

  // The obstacles met there bend the next plan; where none helps, a shorter way.
  void reject(const StepPlan& plan)
  {
    const Rotations rotations(here_.place, task_.attitude.flexion_rad);
    const std::size_t n_before = cuts_.size();
    for (const Obstacle& o : trial_.obstacles) {
      if (cuts_.size() < n_before + most_fresh && holds_here(o, rotations)) cuts_.push_back(o);
    }
    ++n_rejections_;
    if (cuts_.size() > n_before && n_rejections_ < most_rejections) return;
    n_rejections_ = 0;
    radius_mm_ = 0.25 * plan.length_mm;
  }

  // Obstacles of the pose left behind are forgotten: extended too far they block the way.
  void accept(const Rest& rest)
  {
    here_ = rest;
    std::swap(fresh_, trial_);
    cuts_.clear();
    n_rejections_ = 0;
  }

  // Not solved after all: without the cuts, from nearer. False when there is no nearer.
  bool looks_closer()
  {
    radius_mm_ = std::min(0.25 * radius_mm_, 1.0);
    cuts_.clear();
    n_rejections_ = 0;
    return radius_mm_ > 0.1 * tolerance_mm_;
  }

  // From fresh features alone, whatever the plan believed.
  bool is_certified(const StepPlan& plan)
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

  // A rim that leaves another rim touches it to the last: whether a hair further the way leads off.
  bool is_at_the_rim()
  {
    if (!led_off_) return false;
    Vector5d way = step_between(here_.place, *led_off_, tools_.grip);
    way(along_y) = 0.0;
    if (way.norm() > ridge_radius_mm) way *= ridge_radius_mm / way.norm();
    look(moved(here_.place, way, tools_.grip), 0.0, trial_);
    return !std::isfinite(trial_.travel_mm);
  }

  // Obstacles that meet in one point of both objects may be alternatives instead of walls: a tip that crosses
  // a ridge leaves one flank for the other, though each, extended, blocks the way beyond. So each is tried
  // alone, and a step that really rises is taken.
  bool passes_a_ridge()
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
      std::remove_copy_if(fresh_.obstacles.begin(), fresh_.obstacles.end(), std::back_inserter(known_),
                          meets);
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

  // Against the obstacles known.
  bool rises_really()
  {
    plan_options_.radius_mm = ridge_radius_mm;
    const StepPlan plan = planner_.plan(here_, known_, plan_options_);
    if (plan.gain_nmm <= tolerance_mm_ * push_n_) return false;
    look(plan.end.place, band_mm, trial_);
    if (!std::isfinite(trial_.travel_mm)) return false;
    const Rest rest = rest_at(plan.end.place, trial_.travel_mm);
    if (!rest.is_bounded || planner_.merit_nmm(here_) - planner_.merit_nmm(rest) < 0.5 * plan.gain_nmm)
      return false;
    accept(rest);
    radius_mm_ = first_radius_mm;
    return true;
  }

  // Those that touch here.
  void take_touching(const std::vector<Obstacle>& obstacles)
  {
    const Rotations rotations(here_.place, task_.attitude.flexion_rad);
    for (const Obstacle& o : obstacles) {
      const double travel_mm = clearance(o, here_.place, rotations).travel_mm;
      if (travel_mm >= 0.0 && travel_mm <= touching_tolerances * tolerance_mm_) touching_.push_back(o);
    }
  }

  void balance()
  {
    const Rotations rotations(here_.place, task_.attitude.flexion_rad);
    clearances_.clear();
    for (const Obstacle& o : touching_) clearances_.push_back(clearance(o, here_.place, rotations));
    held_ = held_by(here_.potential, clearances_, tools_.grip, plan_options_.is_free);
  }

  void measure(StepRecord& record)
  {
    const Attitude attitude = attitude_at(here_.place);
    const TreeMesh reference = turned(tools_.joint.reference.solid, attitude);
    ContactOptions exact;
    exact.band_mm = tools_.options.contact_resolution_mm;
    measure_contacts(tools_.joint,
                     find_contacts({reference, tools_.joint.reference.features, tools_.joint.moving},
                                   record.pose, tools_.narrow_phase, exact),
                     tools_.options.contact_resolution_mm, record);
    ++record.queries;
    if (!tools_.joint.compartment_of_triangle.empty()) {
      record.gap_medial_mm = gap_left_mm(tools_.medial, attitude, record.pose);
      record.gap_lateral_mm = gap_left_mm(tools_.lateral, attitude, record.pose);
    }
    record.theta_determined = is_theta_determined();
    fill_balance(record);
  }

  static double gap_left_mm(GapQuery& query, const Attitude& attitude, const MovingPose& pose)
  {
    query.set_attitude(attitude);
    const double travel_mm = query.travel_mm(pose);
    return std::isfinite(travel_mm) ? travel_mm : std::numeric_limits<double>::quiet_NaN();
  }

  // Obstacles beyond the narrow band can only make a turn dearer, so they are asked for where it seems cheap.
  bool is_theta_determined()
  {
    if (turning_costs(fresh_.obstacles)) return true;
    look(here_.place, turn_band_mm, trial_);
    return turning_costs(trial_.obstacles);
  }

  // Either way, everything free re-adapting to these obstacles.
  bool turning_costs(const std::vector<Obstacle>& obstacles)
  {
    PlanOptions options = plan_options_;
    options.is_free[about_y] = false;
    options.radius_mm = 2.0 * tools_.grip.lever_mm * turn_rad;
    for (const double turn : {-turn_rad, turn_rad}) {
      Place place = here_.place;
      place.theta_rad += turn;
      const Rotations rotations(place, task_.attitude.flexion_rad);
      double least_mm = plan_options_.reach_mm;
      for (const Obstacle& o : obstacles)
        least_mm = std::min(least_mm, clearance(o, place, rotations).travel_mm);
      const StepPlan plan = planner_.plan(rest_at(place, least_mm), obstacles, options);
      const double cost_nmm = plan.end.potential.energy_nmm - here_.potential.energy_nmm;
      if (!(cost_nmm > turn_cost_tolerances * tolerance_mm_ * push_n_)) return false;
    }
    return true;
  }

  void fill_balance(StepRecord& record) const
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

  ContactForce contact_force(const Obstacle& o, const Clearance& c, double along_delta_n) const
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

  double ligament_energy_at(double flexion_rad) const
  {
    if (tools_.ligaments.fibres.empty()) return 0.0;
    return ligament_energy(tools_.ligaments, {flexion_rad, here_.place.varus_rad},
                           pose_at(here_.place, tools_.grip))
        .energy_nmm;
  }

  // More flexion turns the reference about `axis`, so a moment that flexes acts on the moving object against
  // it. Ligaments by differences: their energy has no flexion among its coordinates.
  double flexion_moment_nmm(const std::vector<ContactForce>& forces) const
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

  State& tools_;
  const Task& task_;
  Forces forces_;
  double push_n_;
  double tolerance_mm_;
  Place seed_;
  StepPlanner planner_;
  PlanOptions plan_options_;
  Rest here_;
  Sight fresh_, trial_;
  std::vector<Obstacle> cuts_;  // met by steps rejected from here
  std::vector<Obstacle> known_, touching_;
  std::vector<Clearance> clearances_;
  Held held_;
  double radius_mm_ = first_radius_mm;
  double residual_mm_ = 0.0;
  std::optional<Place> led_off_;  // where nothing faced any more
  int n_rejections_ = 0;
  int iteration_ = 0;
  int n_queries_before_ = 0;
};

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
