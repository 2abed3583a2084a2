/// Identification: the unknowns of a job with which its solved motion, or its laxity, is nearest to measured
/// ones, and how well the measurements determine them.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "analysis/offset_fit.hpp"
#include "analysis/unknowns.hpp"
#include "analysis/published_values.hpp"
#include "analysis/sequence.hpp"

namespace vrda::analysis {

/// What the joint is fitted to. At least one of the two cases and its data are given.
struct FitData {
  std::vector<analysis::Sequence> trials;  ///< measured motions
  analysis::Convention convention;         ///< of their coordinates
  /// Of job::over_flexions() over ascending flexions that cover those of the trials; null without trials.
  const job::Case* motion = nullptr;
  std::vector<analysis::PublishedValue> laxities;  ///< measured ones
  job::LaxityJob loads;                         ///< of the laxities, without cuts
  const job::Case* laxity = nullptr;            ///< over the flexions of `loads`; null without laxities
};

/// A solved model: of one kind at one point, from which an interrupted fit continues.
struct Evaluation {
  std::int8_t kind = 0;
  std::vector<double> at;      ///< changes, in units of the prior's deviation; of a difference also its base
  std::vector<double> values;  ///< poses or laxities
};

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
const char* name_of(Identifiability identifiability);

struct FittedUnknown {
  double change = 0.0, sd = 0.0;  ///< posterior, in the unit of the unknown
  double explained = 0.0;         ///< share of the prior's variance that the data remove
  Identifiability identifiability = Identifiability::undecided;
  std::size_t partner = 0;  ///< the unknown whose error is most correlated with that of this one
  double correlation = 0.0;
};

/// Root mean square differences of the coordinates (rad, mm); NaN where not measured.
using Misfit = std::array<double, analysis::n_scored>;

/// A trial, or half of the only one.
struct TrialMisfit {
  std::string name;
  std::size_t n_rows = 0;
  Misfit before{}, after{};
  Misfit without{};  ///< after a fit to the others
};

struct LaxityMisfit {
  analysis::PublishedValue measured;
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

}  // namespace vrda::analysis
