/// Static equilibrium of the moving object under exact or compliant contact, loads and ligaments
/// (solve/README.md).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "model/ligaments.hpp"
#include "model/step_record.hpp"
#include "solve/potential.hpp"
#include "solve/sweep.hpp"

namespace vrda::solve {

/// Solver of one thread for one joint. Scratch memory and hints kept between steps do not affect results.
class EquilibriumSolver {
 public:
  /// `ligaments` are in the solver's frames and may have no fibre. The references must outlive the solver.
  EquilibriumSolver(const Joint& joint, const model::Ligaments& ligaments, const EquilibriumOptions& options);
  ~EquilibriumSolver();
  EquilibriumSolver(EquilibriumSolver&&) noexcept;

  struct Task {
    Attitude attitude;  ///< with free varus, its varus is the seed
    MovingPose seed;
    Loads loads;
    bool is_varus_free = false;
    bool is_measured = true;  ///< false: contacts, gaps and theta_determined are not filled
    /// Results of the same step from other seeds. A step that enters one of these equilibria returns its
    /// record with counts of its own.
    const std::vector<StepRecord>* known = nullptr;
  };

  /// Pure: the same task gives the same bits, independent of earlier steps and, without applied loads, of the
  /// seed's height.
  /// Statuses: `stable` is certified, with `balance`, contacts and gaps filled; `no_contact` if no triangles
  /// face each other at the seed; `unbounded` if the loads move it off the reference; else `iteration_limit`.
  /// Cost on thesis-sized knees: about ten gap queries per step from a seed one degree away.
  /// Applied loads that turn with an object are turned to the pose found and the step is solved again from
  /// there, until generalised forces change by less than 1e-6 of the push: the certificate holds for the
  /// final directions. `iteration_limit` after 50 times. `observer` gets every iterate and rejected trial:
  /// the last iterate is the result. With compliant contact: CompliantSolver::solve().
  StepRecord solve(const Task& task, const SearchObserver& observer = {});

 private:
  struct State;
  class Run;
  StepRecord solve_with_turned_loads(const Task& task, const SearchObserver& observer);
  std::unique_ptr<State> state_;
};

// State of one motion step of the equilibrium. Included only by its implementation files.

namespace equilibrium_rules {
// A grid step moves a knee by at most this. Measured: 2 mm takes 10 % more iterations; 0.33 mm takes 5 %
// fewer, but three times as many from a seed 20 mm away.
inline constexpr double first_radius_mm = 0.9;
// Above the rounding of configurations, far below the standoff.
inline constexpr double rounding_mm = 1e-9;
}  // namespace equilibrium_rules

/// Initial width of the band beyond the first contact in which features are returned, mm. Depends on the mean
/// facet areas, so that coarse and fine meshes give similar numbers of features. Others become cutting planes
/// of rejected steps. Measured: twice the features save an iteration in eight and cost more.
double feature_band_mm(const Mesh& reference, const Mesh& moving);

/// False for a vertex in a flat or concave region, whose constraint would not exist.
bool can_carry_load(const ContactConstraint& constraint, const Joint& joint);

class CompliantSolver;

struct EquilibriumSolver::State {
  State(const Joint& j, const model::Ligaments& l, const EquilibriumOptions& o)
      : joint(j),
        ligaments(l),
        options(o),
        scale(rotation_scale_of(j.moving.tree_mesh.mesh)),
        reach_mm(2.0 * (extent_along_delta_mm(j.reference.tree_mesh.mesh) +
                        extent_along_delta_mm(j.moving.tree_mesh.mesh))),
        band_mm(feature_band_mm(j.reference.tree_mesh.mesh, j.moving.tree_mesh.mesh)),
        gap(j.reference_gap, j.moving_gap),
        compartment_gap(compartment_queries(j.reference_gap, j.compartment_gap))
  {
  }

  // Skips the rotation of the reference when the attitude is unchanged.
  void set_attitude(const Attitude& attitude)
  {
    if (is_set && at.flexion_rad == attitude.flexion_rad && at.varus_rad == attitude.varus_rad) return;
    gap.set_attitude(attitude);
    at = attitude;
    is_set = true;
  }

  const Joint& joint;
  const model::Ligaments& ligaments;
  EquilibriumOptions options;
  RotationScale scale;
  double reach_mm;
  double band_mm;
  geometry::GapQuery gap;
  OfCompartments<geometry::GapQuery> compartment_gap;
  contact::NarrowPhase narrow_phase;
  Attitude at;  // of `gap`
  bool is_set = false;
  std::shared_ptr<CompliantSolver> compliant;  // if contact is compliant
};

/// Result of a gap query at one configuration.
struct GapSample {
  double travel_mm = 0.0;
  double ceiling_mm = 0.0;                     ///< height of the pivot at the first contact
  std::size_t n_features = 0;                  ///< including those that cannot carry load
  std::vector<ContactConstraint> constraints;  ///< nearest first
};

class EquilibriumSolver::Run {
 public:
  /// `applied` is null without applied loads and lines.
  Run(State& state, const Task& task, const LoadPotential* applied, const SearchObserver& observer);
  StepRecord run();

 private:
  enum class Outcome { accepted, rejected, unbounded };
  StepStatus find_equilibrium();
  int n_gap_queries() const;
  Attitude attitude_at(const Configuration& configuration) const;
  // Overwrites `sample`, whose memory is reused.
  void sample_gap(const Configuration& configuration, double band, GapSample& sample);
  // With the current band, which is then adapted to the number of features.
  void sample_gap(const Configuration& configuration, GapSample& sample);
  EquilibriumCandidate candidate_at(const Configuration& configuration, double travel_mm) const;
  // At the height that the constraints allow.
  EquilibriumCandidate candidate_under(const std::vector<ContactConstraint>& constraints,
                                       const Configuration& configuration) const;
  StepPlan next_plan();
  // The known equilibrium that the plan leads to.
  const StepRecord* entered(const StepPlan& plan) const;
  bool active_set_uses_cuts(const StepPlan& plan) const;
  // A constraint violated at the current configuration was extended too far and is not valid there.
  bool is_satisfied_here(const ContactConstraint& constraint, const Rotations& rotations) const;
  Outcome attempt(const StepPlan& plan);
  // Adds the constraints found at the trial as cutting planes; without any, shrinks the trust region.
  void reject(const StepPlan& plan);
  // Adds the constraints that are satisfied at the current configuration; false if none is.
  bool add_cuts(const std::vector<ContactConstraint>& found, std::vector<ContactConstraint>& cuts) const;
  // Drops the cutting planes of the previous configuration: extended too far, they block valid steps.
  void accept(const EquilibriumCandidate& candidate);
  // After a failed certificate: drops the cutting planes too. False when the radius reaches its minimum.
  bool shrink_trust_region();
  // Uses only features sampled at the current configuration, not the constraints of the plan.
  bool is_certified(const StepPlan& plan);
  // Whether a small step towards the last unbounded trial loses contact.
  bool is_at_border();
  // Constraints through one point may be alternatives: a tip that crosses a ridge moves from one flank to the
  // other, though each, extended, blocks the step. Tries each constraint alone.
  bool crosses_ridge();
  // Plans with `constraints_` and accepts the trial if its true gain is sufficient.
  bool accept_if_improving();
  bool has_gain(double share, const StepPlan& plan, const EquilibriumCandidate& candidate) const;
  // Adds the constraints in contact at the current configuration.
  void add_touching(const std::vector<ContactConstraint>& constraints);
  void update_balance();
  void measure(StepRecord& record);
  // The current configuration with its contacts, or a rejected one.
  void report_iterate();
  void report_trial(const Configuration& configuration);
  SearchMove move_of(MoveKind kind, const Configuration& configuration) const;
  double gap_left_mm(Compartment compartment, const Attitude& attitude, const MovingPose& pose);
  // All other coordinates adapt to the constraints; those found at each trial are added.
  bool resists_turn(double turn);
  void fill_balance(StepRecord& record) const;
  ContactForce contact_force(const ContactConstraint& constraint, const Clearance& c,
                             double along_delta_n) const;
  double ligament_energy_at(double flexion_rad) const;
  // Flexion rotates the reference about `axis`, so a flexing moment acts on the moving object about -axis.
  // Ligaments by central differences: flexion is not a coordinate of their energy.
  double flexion_moment_nmm(const std::vector<ContactForce>& forces) const;
  State& state_;
  const Task& task_;
  const SearchObserver& observer_;
  NonContactForces forces_;
  double push_n_;
  double tolerance_mm_;
  double band_mm_;  // adapted to the number of features
  Configuration seed_;
  StepPlanner planner_;
  PlanOptions plan_options_;
  EquilibriumCandidate current_;
  GapSample sample_, trial_sample_;
  std::vector<ContactConstraint>
      cuts_;  // cutting planes: constraints found at trials rejected from `current_`
  std::vector<ContactConstraint> constraints_, touching_;
  std::vector<Clearance> clearances_;
  ContactForceBalance balance_;
  double radius_mm_ = equilibrium_rules::first_radius_mm;
  double small_step_mm_ = 0.0;  // a shorter plan is an equilibrium
  double residual_mm_ = 0.0;
  std::optional<Configuration> unbounded_trial_;  // last trial without contact
  int n_rejections_ = 0;
  bool has_rejected_last_ = false;  // the last reported move is a trial
  const StepRecord* entered_ = nullptr;
  int iteration_ = 0;
  int n_queries_before_ = 0;
  int n_queries_saved_ = 0;
};

}  // namespace vrda::solve
