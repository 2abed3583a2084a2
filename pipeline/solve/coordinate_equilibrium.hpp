/// Equilibrium with any of the joint's six coordinates held: the others minimise ligament energy minus work
/// of the loads under exact contact. EquilibriumSolver is faster where flexion, or flexion and varus, are
/// held.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "model/ligaments.hpp"
#include "model/step_record.hpp"
#include "solve/equilibrium.hpp"
#include "solve/potential.hpp"
#include "solve/sweep.hpp"

namespace vrda::solve {

/// Solver of one thread for one joint. Scratch memory and hints kept between steps do not affect results.
class CoordinateEquilibrium {
 public:
  /// `ligaments` are in the frames of S, which `frame` defines. The references must outlive the solver.
  CoordinateEquilibrium(const Joint& joint, const model::Ligaments& ligaments, const SolverFrame& frame,
                        const EquilibriumOptions& options);
  ~CoordinateEquilibrium();
  CoordinateEquilibrium(CoordinateEquilibrium&&) noexcept;

  struct Task {
    JointCoordinates seed;  ///< held coordinates keep its values
    std::array<bool, n_joint_coordinates> is_free{};
    Loads loads;
    bool is_measured = true;    ///< false: contacts, gaps and what is determined are not filled
    bool tests_freedom = true;  ///< whether what determines a free coordinate is measured: most of the time
  };

  /// Pure: the same task gives the same bits. Statuses: `stable` is certified: the contact forces balance the
  /// free coordinates, and the record's `coordinates` hold the rest. `no_contact` if no triangles face each
  /// other along Delta at the seed; `no_clearance` if the held coordinates make the objects overlap;
  /// `unbounded` if the loads move the object off the reference; else `iteration_limit`.
  /// Each iteration minimises with NLopt (SLSQP) subject to the features of one gap query, extended to planes
  /// and lines; features of rejected trials are added. Every accepted position is free of overlap.
  StepRecord solve(const Task& task);

 private:
  struct State;
  class Run;
  std::unique_ptr<State> state_;
};

// State of one step with roles for the coordinates. Included only by its implementation files.

namespace coordinate_rules {
// As in the other equilibrium: of the tolerance, of the push per mm, of the push.
inline constexpr double standoff_share_of_tolerance = 0.1;
inline constexpr double proximal_share_per_mm = 1e-6;
inline constexpr double residual_share = 1e-2;
inline constexpr double touching_within_tolerances = 10.0;
inline constexpr double first_step_mm = 0.9, longest_step_mm = 16.0, crossing_step_mm = 0.02;
inline constexpr double enough_of_predicted = 0.1, good_of_predicted = 0.7;
inline constexpr std::size_t most_features = 60;
inline constexpr int most_rejections = 3;
inline constexpr int most_lifts = 40;
// Positions closer to contact than this have rounding errors of the same size.
inline constexpr double overlap_rounding_mm = 1e-9;
// Violation of a constraint at which SLSQP's result is infeasible.
inline constexpr double infeasible_mm = 1e-7;
// A free coordinate is determined if moving it by this much either way, the others adapted, costs the push
// ten tolerances of height.
inline constexpr double trial_rotation_rad = rad_from_deg(1.0), trial_translation_mm = 1.0;
inline constexpr double determined_tolerances = 10.0;
inline constexpr int most_trials = 8;
inline constexpr double turned_load_share = 1e-6;  // as in the other equilibrium, of the push
inline constexpr int most_turns = 50;
// Of the fibres' gradient: truncation of 1e-4 of its change per mm, rounding of 1e-11 N.
inline constexpr double difference_mm = 1e-4;
}  // namespace coordinate_rules

/// Result of a gap query at one position.
struct Sampled {
  double travel_mm = 0.0;
  std::vector<ContactConstraint> features;
};

struct CoordinateEquilibrium::State {
  State(const Joint& j, const model::Ligaments& l, const SolverFrame& frame, const EquilibriumOptions& o)
      : joint(j),
        ligaments(l),
        map(frame),
        options(o),
        scale(rotation_scale_of(j.moving.tree_mesh.mesh)),
        band_mm(feature_band_mm(j.reference.tree_mesh.mesh, j.moving.tree_mesh.mesh)),
        gap(j.reference_gap, j.moving_gap)
  {
  }

  const Joint& joint;
  const model::Ligaments& ligaments;
  JointMap map;
  EquilibriumOptions options;
  RotationScale scale;
  double band_mm;
  geometry::GapQuery gap;
  contact::NarrowPhase narrow_phase;
};

class CoordinateEquilibrium::Run {
 public:
  Run(State& state, const Task& task);

  StepRecord run();

 private:
  // Step in mm from `current_` along the free coordinates; rotations are multiplied by the lever.
  struct Plan {
    JointCoordinates end = JointCoordinates::Zero();
    double energy_mm = 0.0;  // energy over the push
    double length_mm = 0.0;
    double violation_mm = 0.0;  // of the worst constraint
  };
  // Fibres' energy over the push to second order about the start of a plan, over the free coordinates in mm.
  struct FibreExpansion {
    bool is_used = false;
    double energy_mm = 0.0;
    Vector6d gradient = Vector6d::Zero();
    Matrix6d hessian = Matrix6d::Zero();
  };
  // A trial of a plan and what NLopt asks for there, several times.
  struct Trial {
    std::vector<double> step_mm;
    JointCoordinates q;
    SolverPosition at;
    Matrix6d twists;
  };
  struct Minimisation {
    Run* run = nullptr;
    const JointCoordinates* from = nullptr;
    const std::vector<ContactConstraint>* features = nullptr;
    bool has_slack = false;  // minimises the largest violation instead of the energy
    FibreExpansion fibres = {};
    Trial trial = {};
  };

  SolverPosition position(const JointCoordinates& q) const { return state_.map.position_at(q); }

  FeatureMeter meter(const SolverPosition& at) const { return {at, state_.scale.pivot_mm}; }

  // At the step of a plan; evaluated unless it is that of the call before.
  static const Trial& trial_at(Minimisation& m, const double* step_mm);

  std::size_t n_free() const;

  JointCoordinates moved_from(const JointCoordinates& from, const double* step_mm) const;

  // The entries of the free coordinates, per mm of the step.
  void pick_free(const Vector6d& gradient, double* out) const;

  // Energy of the fibres and its derivative, a wrench.
  double fibre_energy_nmm(const SolverPosition& at, Vector6d& wrench) const;

  double energy_nmm(const SolverPosition& at, Vector6d& wrench) const;

  // Work of the loads and the term that selects the point nearest the seed of a continuum, over the push;
  // derivatives over the free coordinates, per mm.
  double load_merit_mm(const Trial& trial, double* gradient) const;

  double merit_mm(const JointCoordinates& q) const;

  // The Hessian by differences of the gradient: six evaluations instead of one per trial of a plan.
  FibreExpansion fibre_expansion(const JointCoordinates& q) const;

  static double objective(unsigned n, const double* z, double* gradient, void* data);

  // Standoff minus the distance of each feature: at most 0.
  static void constraints(unsigned m_rows, double* result, unsigned n, const double* z, double* gradient,
                          void* data);

  Plan minimise(const JointCoordinates& from, const std::vector<ContactConstraint>& features,
                double radius_mm, bool has_slack = false);

  double worst_violation_mm(const JointCoordinates& q, const std::vector<ContactConstraint>& features) const;

  void sample(const JointCoordinates& q, Sampled& out, double band_mm);

  // Step of the free translations that moves the object by 1 mm along Delta; empty if they cannot.
  std::optional<Vector6d> lift_at(const JointCoordinates& q) const;

  // Moves along Delta to the standoff from first contact; `only_down`: out of an overlap only.
  bool bring_to_contact(JointCoordinates& q, Sampled& sampled, bool only_down);

  // From a seed that overlaps while the position along Delta is held.
  bool leave_overlap();

  const LoadPotential* applied() const { return has_applied_ ? &applied_ : nullptr; }

  // Loads that turn with an object are turned again at each position found until they no longer change.
  StepStatus find_with_turned_loads();

  StepStatus find_equilibrium();

  // Features that the current position satisfies; others were extended too far.
  bool add_cuts(const std::vector<ContactConstraint>& found, std::vector<ContactConstraint>& cuts) const;

  void add_touching(const std::vector<ContactConstraint>& features);

  // Contact forces that come nearest to balancing the free coordinates: the projection of the gradient on
  // their cone, by its dual.
  void update_balance();

  bool is_certified();

  // Constraints through one point may be alternatives (a tip crosses a ridge): tries each alone.
  bool crosses_ridge();

  bool accept_if_lower(const std::vector<ContactConstraint>& features);

  // Whether moving one coordinate by `shift` costs energy however the others adapt.
  bool resists(std::size_t coordinate, double shift);

  Vector6d flexing_force() const;

  void fill_balance(StepRecord& record);

  void measure(StepRecord& record);

  State& state_;
  const Task& task_;
  std::array<bool, n_joint_coordinates> is_free_;
  double push_n_, tolerance_mm_, standoff_mm_;
  bool has_applied_ = false;
  LoadPotential applied_;             // of the applied loads and lines near a position
  Vector6d unit_ = Vector6d::Ones();  // of each coordinate per mm of a step
  JointCoordinates current_ = JointCoordinates::Zero();
  Sampled sampled_;
  std::vector<ContactConstraint> touching_;
  std::vector<FeatureDistance> distances_;  // [n_touching], like the next two
  std::vector<Vector6d> over_coordinates_;
  std::vector<double> force_n_;
  Vector6d gradient_ = Vector6d::Zero(), unbalanced_n_ = Vector6d::Zero();
  double energy_nmm_ = 0.0;
  double residual_mm_ = 0.0;
  int iteration_ = 0;
  int n_queries_before_ = 0;
};

}  // namespace vrda::solve
