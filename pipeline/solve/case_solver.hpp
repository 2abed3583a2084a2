/// Builds the inputs of solver and sweep from a Case, and solves its steps by the method of the job.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "job/case.hpp"
#include "model/coordinates.hpp"
#include "model/step_record.hpp"
#include "solve/coordinate_equilibrium.hpp"
#include "solve/equilibrium.hpp"
#include "solve/stability_search.hpp"
#include "solve/sweep.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda::solve {

/// Both objects in the solver frame with the Delta of `frame`.
solve::Joint joint_of(const job::Case& job_case, const SolverFrame& frame);
/// The same, with what `joint` has of a moving object that is the same: of the case, or of a sample of it.
solve::Joint joint_like(const solve::Joint& joint, const job::Case& job_case, const SolverFrame& frame);

/// What `joint_of` gives at the job's own Delta, without the parts for solving: a third of its memory.
struct InitialBodies {
  geometry::TreeMesh reference, moving;
  double substep_mm = 0.0;
};
InitialBodies initial_bodies_of(const job::Case& job_case);

/// `job_case` must outlive the plan.
solve::SweepPlan plan_of(const job::Case& job_case);

/// The neutral pose is the start pose moved along Delta into contact at the grid's attitude nearest to zero.
/// Travel: half the smallest horizontal extent of the narrower object of a knee, of the wider one otherwise.
/// Rotation: 45 degrees for a knee, else 90.
JointBounds joint_bounds_of(const job::Case& job_case);

/// Changes when the same job may give other bytes.
std::string solver_version_of(const job::Case& job_case);

/// SHA-256 of everything that determines the steps: solver version, resolved job, inputs. If scaling keeps
/// the steps it is that of the unscaled job, so one journal serves every size.
std::string fingerprint_of(const job::Case& job_case);

/// The solver frame at a flexion index of the grid; its Delta depends on the flexion.
SolverFrame frame_of(const job::Case& job_case, const job::Push& push);

/// The loads at a flexion index, in the solver frame there.
Loads loads_of(const job::Case& job_case, const job::Push& push);

/// Shared by the workers of a sweep. Meshes are transformed to the solver frame once for each Delta.
class CaseSolver {
 public:
  /// `job_case` must outlive the solver. `joint`: that of another case with the same meshes and frame.
  CaseSolver(const job::Case& job_case, int n_threads, std::shared_ptr<const solve::Joint> joint = nullptr);

  /// In the frame of the first flexion.
  std::shared_ptr<const solve::Joint> joint() const { return first_->joint; }

  /// May be called from several threads at once, each with its own worker number. `observer` is used by the
  /// stability search only.
  StepRecord operator()(const solve::StepTask& task, const SearchObserver& observer = {});

 private:
  /// Both objects and the ligaments in the frame of one Delta.
  struct PushFrame {
    Eigen::Vector3d delta;
    std::shared_ptr<const solve::Joint> joint;
    model::Ligaments ligaments;
  };
  struct Worker {
    std::shared_ptr<const PushFrame> push_frame;
    std::unique_ptr<solve::EquilibriumSolver> solver;
    std::unique_ptr<solve::CoordinateEquilibrium> coordinates;  ///< if the job has roles of its own
  };

  std::shared_ptr<const PushFrame> push_frame_of(const SolverFrame& frame,
                                                 std::shared_ptr<const solve::Joint> joint = nullptr);
  Worker& worker_at(int number, const SolverFrame& frame);
  StepRecord search_coordinates(const solve::StepTask& task, const MovingPose& seed, const SolverFrame& frame,
                                const solve::Joint& joint, const SearchObserver& observer) const;
  StepRecord solve_plain(const solve::StepTask& task, const MovingPose& seed, const SolverFrame& frame,
                         const Loads& loads, solve::EquilibriumSolver& solver) const;
  JointCoordinates seed_coordinates(const solve::StepTask& task, const MovingPose& seed,
                                    const solve::JointMap& map) const;
  StepRecord solve_with_followers(const solve::StepTask& task, const MovingPose& seed,
                                  const SolverFrame& frame, Loads loads, const Worker& worker) const;
  StepRecord solve_coordinates(const solve::StepTask& task, const MovingPose& seed, const SolverFrame& frame,
                               const Loads& loads, solve::CoordinateEquilibrium& solver) const;

  const job::Case& case_;
  std::shared_ptr<const PushFrame> first_;  // of the first flexion, usually the only one
  std::vector<Worker> workers_;
};

/// The result for a joint `factor` times as large: scales each record (model/step_record.hpp) and the energy
/// spread. Contact has no intrinsic length: the scaled poses balance the same forces if the point of the push
/// is scaled too.
solve::SweepResult scaled(const solve::SweepResult& result, double factor);

// From solved steps to the motion model and its trace.

/// The model without smoothed surfaces, at the subject's size (of_subject()). Cells that are not stable
/// contain NaN and their status.
store::MotionModel motion_model_of(const job::Case& job_case, const solve::SweepResult& result);

/// The model of the start file: plan and meshes at the subject's size, every cell pending.
store::MotionModel pending_model_of(const job::Case& job_case);

/// Fibres and wraps in the layout of the file, without cells.
store::LigamentRows ligament_rows(const model::Ligaments& canonical);

/// Fills contact_paths, equilibrium and ligaments of `model` where present. Poses and contacts must be
/// filled.
void add_balance(store::MotionModel& model, const job::Case& job_case, const solve::SweepResult& result);

/// Fills the cells of the model's followers from `result.followers`.
void add_followers(store::MotionModel& model, const job::Case& job_case, const solve::SweepResult& result);

/// `spine_column` as in SweepResult: identifies the probes that became spine cells.
store::Trace trace_of(const job::Case& job_case, const std::string& job_key,
                      const std::map<StepKey, SearchTrace>& searches,
                      const std::vector<std::int32_t>& spine_column);

/// Bands and shares of the spread from the solved samples of an uncertain job. `records`: of kind
/// StepKind::sample, one for each flexion and sample, and those of the samples' followers, in any order.
/// Clinical coordinates are about the rotation centre of the job, also where the samples' centres differ.
store::UncertainMotion uncertain_motion_of(const job::Case& job_case, const std::vector<StepRecord>& records);

// Bands of an uncertain motion by quantity, and the contributions of the draws to the spread of a quantity.

/// A quantity and its place in the tables of the motion, which must outlive it.
struct BandQuantity {
  std::string name;                              ///< of a follower "patella_flexion"
  const char* unit = "";                         ///< degree, mm or N
  const store::UncertainPose* of = nullptr;      ///< the motion or one of its followers
  const std::vector<double>* samples = nullptr;  ///< in column row % 3 of three
  const std::vector<double>* bands = nullptr;    ///< likewise
  std::size_t row = 0, n_rows = 0;               ///< in the tables of shares

  /// Quantile at a flexion; `probability` is a row of store::band_probabilities.
  double band_at(std::size_t probability, std::size_t flexion) const;
  /// Index in the tables of shares, [n_flexion, n_rows, n_draws].
  std::size_t share_row(std::size_t flexion, std::size_t draw) const;
};
/// Those that the model has: the forces of compartments only where there are any; then those of followers.
std::vector<BandQuantity> quantities_of(const store::UncertainMotion& motion);

/// [n_flexion] variances over the samples.
std::vector<double> variances_of(const BandQuantity& quantity);

/// Of one draw: first-order index with its interval, and rank correlation, as means over the flexions
/// weighted by the variance of the quantity there: shares of the whole spread.
struct SpreadShare {
  std::size_t draw = 0;
  double index = 0.0, low = 0.0, high = 0.0, rank_correlation = 0.0;
};
/// Largest first; draws without an index are left out.
std::vector<SpreadShare> spread_shares(const BandQuantity& quantity);

// The motion of one sample of an uncertain job: one step at each flexion, varus free (or by the roles of its
// coordinates), started from the equilibria of the job and from the sample's own neighbouring flexions.

struct SampleOptions {
  std::int32_t sample = 0;                  ///< number of the sample, in the keys
  std::vector<PriorTerm> prior;             ///< of the sample
  std::function<bool()> is_stopped;         ///< polled
  decltype(SweepPlan::follow) follow = {};  ///< solves the sample's followers; empty without any
};

/// `job` is the result of `plan`, whose spine has a free varus; `solve` solves the steps of the sample's
/// case. Records [n_flexion] of kind `sample`, measured; a flexion without an equilibrium keeps the status of
/// its first start. Then those of its followers, of kind `sample_follower`. Empty when stopped. Pure, like
/// `solve`.
std::vector<StepRecord> sample_motion(const SweepPlan& plan, const SweepResult& job, const SolveStep& solve,
                                      const SampleOptions& options);

}  // namespace vrda::solve
