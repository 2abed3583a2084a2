/// Bands of an uncertain motion by quantity, and the contributions of the draws to the spread of a quantity.
#pragma once

#include <functional>
#include <vector>

#include "solve/sweep.hpp"
#include "store/motion_model.hpp"

namespace vrda::solve {

/// A quantity's place in the tables of the motion; its unit is degree, mm or N.
struct BandQuantity {
  std::size_t row = 0;  ///< of store::uncertain_quantities
  const char* name = "";
  const char* unit = "";
};
/// Those that the model has: the forces of compartments only where there are any.
std::vector<BandQuantity> quantities_of(const store::UncertainMotion& motion);

/// Quantile of a quantity at a flexion; `probability` is a row of store::band_probabilities.
double band_at(const store::UncertainMotion& motion, std::size_t probability, std::size_t flexion,
               std::size_t quantity);

/// [n_flexion] variances over the samples.
std::vector<double> variances_of(const store::UncertainMotion& motion, std::size_t quantity);

/// Of one draw: first-order index with its interval, and rank correlation, as means over the flexions
/// weighted by the variance of the quantity there: shares of the whole spread.
struct SpreadShare {
  std::size_t draw = 0;
  double index = 0.0, low = 0.0, high = 0.0, rank_correlation = 0.0;
};
/// Largest first; draws without an index are left out.
std::vector<SpreadShare> spread_shares(const store::UncertainMotion& motion, std::size_t quantity);

// The motion of one sample of an uncertain job: one step at each flexion, varus free (or by the roles of its
// coordinates), started from the equilibria of the job and from the sample's own neighbouring flexions.

struct SampleOptions {
  std::int32_t sample = 0;           ///< number of the sample, in the keys
  std::function<bool()> is_stopped;  ///< polled
};

/// `job` is the result of `plan`, whose spine has a free varus; `solve` solves the steps of the sample's
/// case. Records [n_flexion] of kind `sample`, measured; a flexion without an equilibrium keeps the status of
/// its first start. Empty when stopped. Pure, like `solve`.
std::vector<StepRecord> sample_motion(const SweepPlan& plan, const SweepResult& job, const SolveStep& solve,
                                      const SampleOptions& options);

}  // namespace vrda::solve
