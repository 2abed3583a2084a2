/// The unknowns of [fit], and a case with them changed.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "analysis/laxity.hpp"
#include "analysis/offset_fit.hpp"
#include "analysis/score.hpp"
#include "core/fields.hpp"
#include "job/case.hpp"
#include "job/job.hpp"
#include "solve/equilibrium.hpp"
#include "solve/followers.hpp"

namespace vrda::analysis {

/// One number that is fitted: a change of strain, length (mm), force (N) or moment (N mm).
struct Unknown : job::Parameter {
  Eigen::Index axis = 0;                  ///< of an attachment, canonical
  double flexion_rad = nan;               ///< of a load that changes over flexion
  std::vector<double> all_flexions_rad;   ///< of the same load, ascending; empty: constant
  double sd = 0.0, from = 0.0, to = 0.0;  ///< prior and bounds of the change

  const char* unit() const;
};

/// Expands the parameters of the job: one unknown per bundle, fibre or flexion. Throws InputError naming the
/// key: a fibre or bundle that the case does not have, or a load that leaves no force along Delta at `from`.
std::vector<Unknown> unknowns_of(const job::Job& job, const job::Case& job_case);

/// The changes of all loads at a flexion: linear between the angles of an unknown, constant beyond.
struct LoadChange {
  Eigen::Vector3d force_n = Eigen::Vector3d::Zero();  ///< anterior, proximal, right
  double moment_nmm = 0.0, varus_moment_nmm = 0.0;
};
/// The part of the change that an unknown of this kind sets.
double& component(LoadChange& change, job::InputLoad load);
LoadChange load_change_at(const std::vector<Unknown>& unknowns, const Eigen::VectorXd& change,
                          double flexion_rad);

/// Fibres of the joint, or of a follower by its row, with changed attachments and slack lengths: the
/// reference strain (at the pose of the meshes, of a follower of the scan) is the case's plus its change,
/// wherever the attachments are.
model::Ligaments changed_ligaments(const job::Case& job_case, const std::vector<Unknown>& unknowns,
                                   const Eigen::VectorXd& change,
                                   std::optional<std::size_t> follower = std::nullopt);

/// Lengths of fibres there.
std::vector<double> reference_lengths_mm(const job::Case& job_case, const model::Ligaments& ligaments,
                                         std::optional<std::size_t> follower);

/// The case with the changes applied to fibres and loads.
job::Case changed_case(const job::Case& job_case, const std::vector<Unknown>& unknowns,
                       const Eigen::VectorXd& change);

// Identification: the unknowns of a job with which its solved motion, or its laxity, is nearest to measured
// ones, and how well the measurements determine them.

/// What the joint is fitted to. At least one of the two cases and its data are given.
struct FitData {
  std::vector<Sequence> trials;  ///< measured motions
  Convention convention;         ///< of their coordinates
  /// Of job::over_flexions() over ascending flexions that cover those of the trials, and with `laxity` have
  /// those of the loads; null without trials.
  const job::Case* motion = nullptr;
  /// [n_trials, n_followers of `motion`, n_rows] their measured coordinates; no rows where not measured.
  std::vector<std::vector<std::vector<JointCoordinates>>> followers = {};
  std::vector<PublishedValue> laxities;  ///< measured ones
  job::LaxityJob loads;                  ///< of the laxities, without cuts
  const job::Case* laxity = nullptr;     ///< over the flexions of `loads`; null without laxities
};

/// A solved model: of one kind at one point, from which an interrupted fit continues.
struct Evaluation {
  std::int8_t kind = 0;
  std::vector<double> at;      ///< changes, in units of the prior's deviation; of a difference also its base
  std::vector<double> values;  ///< poses or laxities
};

constexpr auto fields_of(const Evaluation*)
{
  return std::tuple{Field{"kind", &Evaluation::kind}, Field{"at", &Evaluation::at},
                    Field{"values", &Evaluation::values}};
}

struct IdentifyPlan {
  job::FitJob fit;
  std::vector<Unknown> unknowns;
  int n_threads = 1;
  std::vector<Evaluation> known = {};                ///< of an earlier run
  std::function<void(const Evaluation&)> keep = {};  ///< a new one; called from any worker
  std::function<void()> on_progress = {};            ///< after each one, from any worker
  std::function<bool()> is_stopped = {};             ///< true: returns `stopped`
};

enum class Identifiability {
  decided,    ///< the fit converged, and the data remove at least 0.9 of the prior's variance
  partly,     ///< between
  undecided,  ///< less than 0.1: posterior and prior are the same
  at_bound,   ///< at `from` or `to`
};
inline constexpr Named<Identifiability> identifiability_names[] = {{Identifiability::decided, "decided"},
                                                                   {Identifiability::partly, "partly"},
                                                                   {Identifiability::undecided, "undecided"},
                                                                   {Identifiability::at_bound, "at_bound"}};
constexpr const auto& names_of(Identifiability)
{
  return identifiability_names;
}

struct FittedUnknown {
  double change = 0.0, sd = 0.0;  ///< posterior, in the unit of the unknown
  double explained = 0.0;         ///< share of the prior's variance that the data remove
  Identifiability identifiability = Identifiability::undecided;
  std::size_t partner = 0;  ///< the unknown whose error is most correlated with that of this one
  double correlation = 0.0;
};

/// Root mean square differences of the coordinates (rad, mm); NaN where not measured.
using Misfit = std::array<double, n_scored>;

/// Of the joint in a trial, or of a follower.
struct BodyMisfit {
  Misfit before{}, after{};
  Misfit without{};  ///< after a fit to the other trials
};

/// A trial, or half of the only one.
struct TrialMisfit {
  std::string name;
  std::size_t n_rows = 0;
  BodyMisfit joint;
  std::vector<std::pair<std::string, BodyMisfit>> followers;  ///< by name, those measured
};

struct LaxityMisfit {
  PublishedValue measured;
  double before = nan, after = nan;  ///< mm or degrees
};

struct Identification {
  FitStatus status = FitStatus::iteration_limit;
  bool is_stopped = false;  ///< nothing below is valid
  int n_iterations = 0;
  double misfit_before = nan, misfit_after = nan;  ///< sum of weighted squares of the data
  double noise_scale = 1.0;  ///< by which residuals exceed the stated noise; at least 1, in all `sd`
  std::vector<FittedUnknown> unknowns;
  Eigen::MatrixXd covariance;    ///< posterior, in the units of the unknowns
  std::size_t n_directions = 0;  ///< independent combinations of the unknowns that the data decide
  std::vector<TrialMisfit> trials;
  std::vector<LaxityMisfit> laxities;

  Eigen::VectorXd change() const;
};

/// Minimises half the sum of the squared differences, each divided by its noise, and of the squared changes,
/// each divided by the prior's deviation: Gauss-Newton steps in a trust region, each the minimum of a
/// quadratic by NLopt within the bounds. A row counts by the number of rows within `independent_deg`, so that
/// these count as one. Every point is solved by the whole spine of `vrda run`; derivatives are differences
/// of equilibria followed from there, first long ones, then short ones. Each trial is left out once, the
/// halves of an only one; the whole fit continues from the end of another that is lower.
/// One solve a core; the same bits for any number of threads, and from `known`.
Identification identify(const FitData& data, const IdentifyPlan& plan);

// The differences between a model with some changes and the measurements.

/// Differences divided by their noise, one per row and coordinate: motions first, then laxities. NaN where
/// the model has no pose.
using Residuals = Eigen::VectorXd;

/// Thread-safe. The data and the plan must outlive it.
class ModelEvaluation {
 public:
  ModelEvaluation(const FitData& data, const IdentifyPlan& plan);

  struct Row {
    std::size_t trial = 0;       ///< trials.size(): a laxity
    std::size_t row = 0;         ///< of the trial, or of the laxities
    std::size_t coordinate = 0;  ///< of a motion
    double weight = 1.0;
    double noise = 1.0;                                  ///< rad or mm; of a laxity mm or degrees
    std::optional<std::size_t> follower = std::nullopt;  ///< of the case's followers; else of the joint
  };
  const std::vector<Row>& rows() const { return rows_; }
  bool is_measured(std::size_t trial, std::size_t follower) const;

  /// At changes `x`, in units of the prior's deviation, by the whole spine.
  Residuals at(const Eigen::VectorXd& x);
  /// At `x`, from the equilibria found at `base`, which is near.
  Residuals near(const Eigen::VectorXd& base, const Eigen::VectorXd& x);
  /// Derivatives by changes, columns, at `x`: differences over `step` to either side.
  Eigen::MatrixXd derivatives(const Eigen::VectorXd& x, double step);
  /// Of the laxities, mm or degrees.
  std::vector<double> laxities_at(const Eigen::VectorXd& x);

  bool is_stopped() const { return plan_.is_stopped && plan_.is_stopped(); }
  Eigen::VectorXd change(const Eigen::VectorXd& x) const;

 private:
  using Key = std::pair<std::int8_t, std::vector<double>>;
  struct Stopped {};

  std::vector<double> recalled(const Key& key, const std::function<std::vector<double>()>& compute);
  std::vector<double> spine_poses(const Eigen::VectorXd& x);
  std::vector<double> near_poses(const Eigen::VectorXd& base, const Eigen::VectorXd& x);
  std::vector<double> laxity_values(const Eigen::VectorXd& x);
  std::vector<double> near_laxity_values(const Eigen::VectorXd& base, const Eigen::VectorXd& x);
  std::vector<double> solved_laxities(const Eigen::VectorXd& x, const std::vector<StepRecord>& unloaded);
  Residuals residuals(const std::vector<double>& poses, const std::vector<double>& laxities) const;
  void add_rows();
  void add_follower_rows(std::size_t trial, std::size_t row, double weight);
  const double* follower_values(const std::vector<double>& poses, std::size_t flexion,
                                std::size_t follower) const;
  void append_near_followers(std::vector<double>& values, const job::Case& changed, const StepRecord& cell,
                             const std::vector<double>& from);
  double follower_difference(const std::vector<double>& poses, const Row& row) const;

  const FitData& data_;
  const IdentifyPlan& plan_;
  std::vector<Row> rows_;
  bool has_followers_ = false;  ///< measured ones
  std::vector<solve::FollowerSolver::Shared> surfaces_;
  std::shared_ptr<const solve::Joint> joint_;  ///< its bodies, the same for every change
  std::vector<bool> is_needed_;                ///< [n_flexion] next to the flexion of a row
  std::map<Key, std::vector<double>> known_;
  std::mutex mutex_;
};

}  // namespace vrda::analysis
