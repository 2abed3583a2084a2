/// The trial step of one iteration of the equilibrium: minimises the potential subject to the known contact
/// constraints only. Makes no gap query.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "contact/contacts.hpp"
#include "geometry/gap_query.hpp"
#include "model/ligaments.hpp"
#include "model/mesh.hpp"
#include "model/step_record.hpp"
#include "solve/contact_constraint.hpp"
#include "solve/potential.hpp"
#include "solve/quadratic_program.hpp"

namespace vrda::solve {

struct PlanOptions {
  std::array<bool, 5> is_free{true, true, true, true, true};
  double radius_mm = 1.0;        ///< trust region of all coordinates but the height, angles times the lever
  double standoff_mm = 1e-5;     ///< travel left to every constraint
  double tolerance_mm = 1e-4;    ///< the plan ends at steps below a tenth of this
  double reach_mm = 1e3;         ///< largest distance from contact under the ligaments' pull
  double force_tolerance_n = 0;  ///< along Delta, in equilibrium without contact
};

/// Of a step in mm.
double largest_but_height(const Vector5d& step);

struct StepPlan {
  EquilibriumCandidate end;
  double length_mm = 0.0;  ///< largest coordinate of the step but the height, angles times the lever
  double gain_nmm = 0.0;   ///< decrease of potential and proximal term; never negative
  std::array<std::size_t, 5> active{};  ///< rows of the active constraints at the end
  std::size_t n_active = 0;
};

/// Sequential quadratic programming. Each iterate linearises the constraints, and its Hessian is that of the
/// potential plus, in the null space of the active constraints, theirs, both made positive definite. Heights
/// are restored exactly; ligament energy is expanded to second order. Scratch memory does not affect results.
class StepPlanner {
 public:
  StepPlanner(const NonContactForces& forces, const ProximalTerm& spring) : forces_(forces), spring_(spring)
  {
  }

  /// `from` must satisfy every constraint with its standoff, to rounding.
  StepPlan plan(const EquilibriumCandidate& from, const std::vector<ContactConstraint>& constraints,
                const PlanOptions& options);

  /// Potential plus proximal term.
  double merit_nmm(const EquilibriumCandidate& candidate) const;

 private:
  EquilibriumCandidate candidate_after(const EquilibriumCandidate& at, const QpVector& d,
                                       const std::vector<ContactConstraint>& constraints,
                                       const PlanOptions& options);
  EquilibriumCandidate corrected(const EquilibriumCandidate& at, const Vector5d& travelled, QpVector d,
                                 const std::vector<ContactConstraint>& constraints,
                                 const PlanOptions& options);
  void update_active_set(const QpSolution& qp, StepPlan& plan, std::size_t n_constraints);
  void sample_constraints(const std::vector<ContactConstraint>& constraints,
                          const Configuration& configuration);
  QpMatrix curvature(const EquilibriumCandidate& at, const std::vector<ContactConstraint>& constraints,
                     const PlanOptions& options);
  QpMatrix scaled(const Matrix5d& hessian, const PlanOptions& options) const;
  QpSolution solve_linearised(const EquilibriumCandidate& at, const Vector5d& travelled,
                              const std::vector<ContactConstraint>& constraints, const PlanOptions& options,
                              double radius_mm);

  // Within a plan the potential's Hessian is mostly the same.
  struct BaseHessian {
    Matrix5d of;
    QpMatrix positive;
  };

  NonContactForces forces_;
  ProximalTerm spring_;
  std::optional<BaseHessian> base_;
  std::vector<Clearance> clearances_;   // of the iterate
  std::vector<Clearance> trial_;        // of a trial
  std::vector<Clearance> linear_;       // linearised constraints of the programme
  double drop_mm_ = 0.0;                // of a trial: from its linear height to its equilibrium along Delta
  std::vector<HalfSpace> half_spaces_;  // constraints first
  std::vector<double> row_length_;      // of the constraints' half-spaces before normalisation
  std::vector<double> multipliers_;     // of the constraints, N along Delta
};

// One flexion of a spine with free varus: solves it from several starts and selects one of its equilibria,
// that of the lowest energy. Poses are in the solver frame S: mm, rad; energies in N mm. A flexion of which
// no start is solved keeps the status of its first result.

/// Offset of a restart from the lower result of the two chains, added to its pose.
struct SpineOffset {
  double theta_rad = 0.0;
  double shift_x_mm = 0.0;
  double shift_z_mm = 0.0;
};

/// The first `n` (at most 8) of a fixed list of rotations and shifts, small ones first.
std::vector<SpineOffset> spine_offsets(int n);

/// One of the distinct equilibria of a flexion: no other one is within 0.1 mm and 0.1 degrees.
struct SpineEquilibrium {
  MovingPose pose;
  double varus_rad = 0.0;
  double energy_nmm = 0.0;
  bool is_chosen = false;
  std::size_t end = 0;  ///< row of its result among the ends
};

/// Results of all starts of one flexion.
struct FreeSpineStep {
  StepRecord chosen;                         ///< by the branch rule; if none is stable, the first result
  std::int32_t n_optima = 0;                 ///< stable poses that differ by more than 0.1 mm or 0.1 degrees
  double theta_spread_rad = 0.0;             ///< largest minus smallest theta of them
  double energy_spread_nmm = 0.0;            ///< largest minus smallest energy of them
  std::vector<SpineEquilibrium> equilibria;  ///< [n_optima] in the order of their first starts
  StepRecord band_low;   ///< with the extra moment against theta; `pending` without a band
  StepRecord band_high;  ///< with the extra moment along theta
};

/// `ends` in the order of their starts: of equal energies (within 1e-6 N mm) the earlier is chosen.
FreeSpineStep select_lowest(const std::vector<StepRecord>& ends);

/// An equilibrium and the row of its flexion in the path.
struct PathPoint {
  MovingPose pose;
  double varus_rad = 0.0;
  std::int32_t path_row = 0;
};

// schemas/job.schema.json states the formula of a continuous path.
inline constexpr double path_compliance_mm = 5.0;  ///< the forces over the stiffness against change
inline constexpr double most_path_work_mm = 1.0;   ///< its energies above the lowest, over the forces

/// N mm, at least 0: penalty on the change between the equilibria of neighbouring flexions.
using ChangePenalty = std::function<double(const PathPoint& from, const PathPoint& to)>;

/// One of the entries of a row.
struct PathEntry {
  std::size_t row = 0;
  std::size_t entry = 0;
};
using PairPenalty = std::function<double(const PathEntry& from, const PathEntry& to)>;  // N mm

/// `energy_nmm` [n][entries of the row]. The entry of each row on the path with the least sum of energies and
/// of penalties between neighbouring rows, by dynamic programming; of equal sums the earlier entries. Rows
/// without an entry are passed over and have 0.
std::vector<std::size_t> least_path(const std::vector<std::vector<double>>& energy_nmm,
                                    const PairPenalty& penalty_nmm);

/// `ends` and `path_row` [n]: the results of each flexion, in order, and its row. Chooses among the
/// equilibria of select_lowest() those of least_path(). Flexions without an equilibrium are passed over.
std::vector<FreeSpineStep> select_continuous(const std::vector<std::vector<StepRecord>>& ends,
                                             const std::vector<std::int32_t>& path_row,
                                             const ChangePenalty& penalty_nmm);

// Solves every attitude of a flexion x varus grid along a fixed seeding graph (solve/README.md): a spine,
// which is the continuation path along flexion through the cells where both compartments are nearest to
// balance, then rows outward from it. The result does not depend on the number of workers or on
// interruptions.

/// How the spine selects its column at a flexion.
enum class SpineRule {
  nearest_zero,     ///< nearest to zero varus
  walk_to_balance,  ///< from the previous column to better balanced neighbours
  free_varus,       ///< nearest to the solution with free varus
};

struct SweepPlan;
struct StepTask;
struct SweepHooks;
struct SweepResult;
/// Pure but for logging under `task.key`; called from several threads at once. A spine cell is solved as a
/// probe of the walk or as a start of a free spine; its own key is then used for `recall` and `keep` only.
using SolveStep = std::function<StepRecord(const StepTask& task)>;

struct SweepPlan {
  std::vector<double> flexion_rad;  ///< [n_flexion]; of a sequence of frames, the numbers of the rows
  std::vector<double> varus_rad;    ///< [n_varus]
  /// Flexions of the spine with free varus; they contain the grid's. Empty: the grid's.
  std::vector<double> path_flexion_rad;
  MovingPose initial;  ///< seed of the first step
  SpineRule spine = SpineRule::walk_to_balance;
  /// Whether a pose at a path row is in the joint. A step that fails or ends outside it is solved again from
  /// other seeds, if `max_seed_step_rad` is above 0, and poses outside are not seeds. Empty: all poses are.
  std::function<bool(const MovingPose&, std::int32_t path_row)> is_in_joint;
  /// Largest change of flexion or varus between a seed and its step in a subdivided path; 0: no subdivision
  /// and no other seeds.
  double max_seed_step_rad = 0.0;
  /// Rotations of the start pose from which a step is solved if no other seed leads to a stable pose.
  std::vector<double> last_resort_thetas_rad;
  // The next three apply to `free_varus` only.
  bool is_varus_free = false;  ///< the grid has one column, which takes the spine's own poses
  /// With a free varus: the chosen equilibrium of each flexion is solved again and measured, so the starts
  /// need not be.
  bool measures_chosen = false;
  bool has_band = false;  ///< each flexion is also solved with extra moments
  int n_restarts = 0;     ///< starts besides the two chains along flexion (solve/sweep.hpp)
  /// Exact contact: facets make equilibria a fraction of a degree apart, between which small offsets lead.
  bool has_facets = true;
  ChangePenalty change_penalty_nmm;  ///< set: the continuous path is chosen; empty: the lowest energies
  /// The flexions whose rows are solved, each once; absent: all, empty: the spine only. The spine is always
  /// needed, solved or recalled.
  std::optional<std::vector<std::int32_t>> rows;
  /// Springs to published curves; with `free_varus` only. The spine is then solved without them first.
  std::vector<PriorTerm> prior;
  double band_moment_nmm = 0.0;  ///< of the steps with `band`: measures the joint's own stiffness
  // Of a sweep with a prior, once it is estimated; each [n_path] or empty.
  std::vector<std::vector<CoordinateSpring>> springs;
  std::vector<std::optional<StepRecord>> starts;  ///< further starts of the spine
  /// Solves the bodies that follow the joint in the cells of a complete result (solve/followers.hpp), and
  /// those cells again where they react; false when stopped. Empty without followers.
  std::function<bool(const SweepPlan&, const SolveStep&, const SweepHooks&, int n_threads, SweepResult&)>
      follow;
};

/// Small offsets to either side, in theta, x and z, of two sizes; none without restarts or facets.
std::vector<SpineOffset> polish_offsets(const SweepPlan& plan);

/// What the springs of a plan depend on besides its terms (solve/prior.hpp).
struct PriorState {
  std::vector<double> flexion_rad;    ///< [n_flexion] of the grid
  std::vector<double> own_stiffness;  ///< [n_flexion] N mm per rad about Delta; NaN where not measured
  std::vector<double> factor;         ///< [n_flexion] of the terms with a factor
  std::vector<double> level;          ///< [n_terms] rad or mm
};

inline const std::vector<double>& path_of(const SweepPlan& plan)
{
  return plan.path_flexion_rad.empty() ? plan.flexion_rad : plan.path_flexion_rad;
}

/// What the followers do to the joint: fibres between its objects, canonical, and loads in the frame S.
struct FollowerForces {
  model::Ligaments fibres;
  std::vector<AppliedLoad> loads;
};

/// One step to solve.
struct StepTask {
  StepKey key;
  Attitude attitude;  ///< with free varus, its varus is the seed
  MovingPose seed;
  std::optional<Attitude> seed_attitude;  ///< at which the seed was solved; empty: the start pose of the plan
  std::int32_t path_row = 0;              ///< row of the path flexions, or of the grid's if there is no path
  std::int32_t seed_path_row = 0;         ///< of the seed: its Delta may differ
  bool is_varus_free = false;
  const std::vector<StepRecord>* known = nullptr;  ///< results of other starts of the same step
  int band = 0;             ///< -1 or +1: with the extra moment against theta or with it
  bool is_measured = true;  ///< false: only pose, status and energy are needed, under no key of the result
  std::vector<CoordinateSpring> springs = {};
  int worker = 0;  ///< index below the number of threads, for scratch memory kept between steps
  const FollowerForces* followers = nullptr;
};

/// Each may be empty. `recall` and `keep` are called from the workers.
struct SweepHooks {
  std::function<std::optional<StepRecord>(const StepKey&)> recall;  ///< a step solved in an earlier run
  std::function<void(const StepRecord&)> keep;                      ///< a new step, key set
  std::function<bool()> is_stopped;  ///< true: the sweep finishes its current steps and returns
};

struct SweepResult {
  std::vector<std::vector<StepRecord>> followers;  ///< [n_cells, n_followers]; empty without followers
  std::vector<StepRecord> cells;           ///< [n_flexion * n_varus], flexion-major; `pending` if stopped
  std::vector<std::int32_t> spine_column;  ///< [n_flexion] varus index, -1 if stopped
  std::vector<FreeSpineStep> free_spine;   ///< [n_flexion] with SpineRule::free_varus, else empty
  bool is_complete = false;                ///< the spine and every requested row are solved
  std::vector<FreeSpineStep> alone;        ///< [n_flexion] without the prior, else empty
  PriorState prior;                        ///< of a plan with a prior
};

/// Rethrows the first exception of `solve` or a hook after the other workers have finished their steps.
SweepResult sweep(const SweepPlan& plan, const SolveStep& solve, const SweepHooks& hooks, int n_threads);

/// Imbalance of the compartments, for the rule of the spine by search: |medial - lateral gap|; infinite
/// if the record is not stable or a compartment has no gap.
double imbalance_mm(const StepRecord& record);

/// Whether `a` is the better spine cell: contact of both compartments first, then the smaller imbalance. If
/// both cells have contact on both sides, the one further along Delta, which is where free varus would
/// settle.
bool is_better_balanced(const StepRecord& a, const StepRecord& b);

// The solver's input, both objects in the solver frame S at zero attitude with their search trees, and the
// measurements at a final pose, common to all methods.

/// A mesh in S and the component of each triangle (empty: one component).
struct SolverBody {
  Mesh mesh;
  std::vector<std::int32_t> component;
};

class LazyCompliantSurfaces;

struct Joint {
  contact::Collider reference;
  contact::Collider moving;
  std::vector<Compartment> compartment_of_triangle;  ///< [n_moving_triangles], empty without compartments
  geometry::GapTree reference_gap;                   ///< the same objects, prepared for gap queries
  geometry::GapTree moving_gap;
  OfCompartments<geometry::GapTree> compartment_gap;  ///< of their moving triangles
  std::vector<bool> reference_protrudes;              ///< [n_vertices] convex: can touch a face first
  std::vector<bool> moving_protrudes;
  double substep_mm = 0.0;  ///< upper bound of one motion of any vertex: half the thinnest part
  std::shared_ptr<const LazyCompliantSurfaces> compliant;  ///< for compliant contact (compliant_contact.hpp)
  /// By which the objects are thicker together than those of `compliant`.
  double thicker_than_compliant_mm = 0.0;
};

/// One a compartment.
OfCompartments<geometry::GapQuery> compartment_queries(const geometry::GapTree& reference,
                                                       const OfCompartments<geometry::GapTree>& moving);

/// `compartment_of_triangle` is empty or has one entry per moving triangle. Neither mesh may be empty.
Joint make_joint(const SolverBody& reference, const SolverBody& moving,
                 const std::vector<Compartment>& compartment_of_triangle);

/// Height of the bounding box: the extent along Delta in S.
double extent_along_delta_mm(const Mesh& mesh);

/// Thickness of the thinnest component: twice volume over area if closed, else its mean edge length.
double thinnest_part_mm(const SolverBody& body);

/// Joint::substep_mm of two bodies.
double substep_mm(const SolverBody& reference, const SolverBody& moving);

/// The record of a contact; its compartment is that of the moving triangle.
ContactRecord contact_record(const Joint& joint, const contact::Contact& contact);

/// Fills contacts, condyle flags and theta_determined of `record` from the contacts at its pose. Rotation is
/// determined when at least two contacts resist a turn about their mean point with a moment arm above
/// `resolution_mm`.
void measure_contacts(const Joint& joint, const std::vector<contact::Contact>& contacts, double resolution_mm,
                      StepRecord& record);
/// The same from the features of both objects within `resolution_mm`; `gap` is a query between them at the
/// attitude.
void measure_contacts(const Joint& joint, const Attitude& attitude, geometry::GapQuery& gap,
                      contact::NarrowPhase& narrow_phase, double resolution_mm, StepRecord& record);

/// Fills the gap that each compartment has left along Delta at the pose; nothing without compartments. Adds
/// its queries to the record.
void measure_gaps(const Joint& joint, const Attitude& attitude, const MovingPose& pose, StepRecord& record);

// Start poses of the steps of a grid, and the choice among their results.

/// Start of a step.
struct Seed {
  MovingPose pose;
  std::optional<Attitude> attitude;  ///< at which the pose was solved; empty for the start pose of the job
  std::int32_t path_row = 0;         ///< its Delta
  bool is_last_resort = false;       ///< tried only while no result is stable
};

/// The seed, the start pose of the plan, and its rotations as last resorts.
std::vector<Seed> seeds_from(const SweepPlan& plan, const Seed& seed);

/// Solves `task` (its seed is ignored) from each seed in turn until a result is usable. From each seed first
/// directly; then, if it has an attitude, along attitudes at most `max_seed_step_rad` apart in flexion and in
/// varus, solved with is_measured = false, as far as these are usable. Without a usable result: the last
/// stable one, else the last. The task of the result is the last that was solved with is_measured = true.
/// With `max_seed_step_rad` 0 only the first seed is tried, directly.
StepRecord solve_from_seeds(StepTask task, const std::vector<Seed>& seeds, double max_seed_step_rad,
                            const SolveStep& solve, const std::function<bool(const StepRecord&)>& is_usable);

}  // namespace vrda::solve
