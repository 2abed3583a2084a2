/// One motion step of the equilibrium under way. Only for the files that implement it.
#pragma once

#include <optional>

#include "solve/equilibrium.hpp"
#include "solve/potential.hpp"
#include "solve/step_plan.hpp"

namespace vrda {

namespace equilibrium_rules {
// A step of the grid moves a knee by as much at most. Measured: 2 mm takes a tenth more iterations, a third
// of a millimetre a twentieth fewer, but three times as many where a seed lies 20 mm away.
inline constexpr double first_radius_mm = 0.9;
}  // namespace equilibrium_rules

/// How much further than the first touch features are asked for in the beginning, mm. Follows the facets, so
/// that coarse and fine meshes show about as many; a step then follows what it sees. What lies beyond comes
/// as cuts of rejected steps. Measured: twice as many save an iteration in eight and cost more than that.
double band_of(const Mesh& reference, const Mesh& moving);

struct EquilibriumSolver::State {
  State(const Joint& j, const Ligaments& l, const EquilibriumOptions& o)
      : joint(j),
        ligaments(l),
        options(o),
        grip(grip_of(j.moving.solid.mesh)),
        reach_mm(2.0 * (extent_along_delta_mm(j.reference.solid.mesh) +
                        extent_along_delta_mm(j.moving.solid.mesh))),
        band_mm(band_of(j.reference.solid.mesh, j.moving.solid.mesh)),
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
  double band_mm;
  GapQuery gap;
  GapQuery medial;
  GapQuery lateral;
  NarrowPhase narrow_phase;
  Attitude at;  // of `gap`
  bool stands = false;
};

/// What a gap query at a place shows.
struct GapSight {
  double travel_mm = 0.0;
  double ceiling_mm = 0.0;          ///< height of the pivot at the first touch
  std::size_t n_features = 0;       ///< of which only some can bear
  std::vector<Obstacle> obstacles;  ///< nearest first
};

class EquilibriumSolver::Run {
 public:
  Run(State& tools, const Task& task);
  StepRecord run();

 private:
  enum class Outcome { accepted, rejected, led_off };
  StepStatus settle();
  int n_gap_queries() const;
  Attitude attitude_at(const Place& place) const;
  // Into a sight that keeps its memory.
  void look(const Place& place, double band, GapSight& sight);
  // As wide as the last looks found good.
  void look(const Place& place, GapSight& sight);
  // A vertex in the flat or in a hollow extends to an obstacle that is not there.
  bool can_bear(const Obstacle& o) const;
  Rest rest_at(const Place& place, double travel_mm) const;
  StepPlan next_plan();
  bool bears_by_cuts(const StepPlan& plan) const;
  // Where it stands the obstacle must leave the standoff; one that does not was extended too far.
  bool holds_here(const Obstacle& obstacle, const Rotations& rotations) const;
  Outcome attempt(const StepPlan& plan);
  // The obstacles met there bend the next plan; where none helps, a shorter way.
  void reject(const StepPlan& plan);
  // Adds those that hold where it stands; false when none does.
  bool take_cuts(const std::vector<Obstacle>& met, std::vector<Obstacle>& cuts) const;
  // Obstacles of the pose left behind are forgotten: extended too far they block the way.
  void accept(const Rest& rest);
  // Not solved after all: without the cuts, from nearer. False when there is no nearer.
  bool looks_closer();
  // From fresh features alone, whatever the plan believed.
  bool is_certified(const StepPlan& plan);
  // A rim that leaves another rim touches it to the last: whether a hair further the way leads off.
  bool is_at_the_rim();
  // Obstacles that meet in one point of both objects may be alternatives instead of walls: a tip that crosses
  // a ridge leaves one flank for the other, though each, extended, blocks the way beyond. So each is tried
  // alone, and a step that really rises is taken.
  bool passes_a_ridge();
  // Against the obstacles known.
  bool rises_really();
  bool gains(double share, const StepPlan& plan, const Rest& rest) const;
  // Those that touch here.
  void take_touching(const std::vector<Obstacle>& obstacles);
  void balance();
  void measure(StepRecord& record);
  static double gap_left_mm(GapQuery& query, const Attitude& attitude, const MovingPose& pose);
  // Everything free re-adapting to the obstacles known; where the turn seems cheap, to those met there.
  bool turning_costs(double turn);
  void fill_balance(StepRecord& record) const;
  ContactForce contact_force(const Obstacle& o, const Clearance& c, double along_delta_n) const;
  double ligament_energy_at(double flexion_rad) const;
  // More flexion turns the reference about `axis`, so a moment that flexes acts on the moving object against
  // it. Ligaments by differences: their energy has no flexion among its coordinates.
  double flexion_moment_nmm(const std::vector<ContactForce>& forces) const;
  State& tools_;
  const Task& task_;
  Forces forces_;
  double push_n_;
  double tolerance_mm_;
  double band_mm_;  // follows how many features are seen
  Place seed_;
  StepPlanner planner_;
  PlanOptions plan_options_;
  Rest here_;
  GapSight fresh_, trial_;
  std::vector<Obstacle> cuts_;  // met by steps rejected from here
  std::vector<Obstacle> known_, touching_;
  std::vector<Clearance> clearances_;
  Held held_;
  double radius_mm_ = equilibrium_rules::first_radius_mm;
  double residual_mm_ = 0.0;
  std::optional<Place> led_off_;  // where nothing faced any more
  int n_rejections_ = 0;
  int iteration_ = 0;
  int n_queries_before_ = 0;
  int n_spared_ = 0;
};

}  // namespace vrda
