/// Reads [uncertainty] of a job.
#pragma once

#include <optional>

#include "job/case.hpp"
#include "job/job.hpp"
#include "job/ligament_files.hpp"

namespace vrda::job {

struct LoadedUncertainty {
  std::optional<Uncertainty> uncertainty;  ///< empty without [uncertainty]
  std::vector<LoadedInput> inputs;         ///< tables of values
};

/// `loaded` has bodies, fibres, loads and lines. Throws InputError naming the key: a fibre, bundle, component
/// or load that the job does not have, a distribution without its numbers, one that would make a stiffness
/// negative, or a method other than the equilibrium.
LoadedUncertainty load_uncertainty(const Job& job, const std::string& data_directory, const Case& loaded,
                                   const LoadedLigaments& ligaments);

// Distributions of one number (job/case.hpp): quantiles from probabilities.

/// Standard normal distribution: probability below `score`, and its inverse for a probability above 0 and
/// below 1.
double probability_of_score(double score);
double score_of_probability(double probability);

/// The radius within which the unit ball has the same share of its volume as the three-dimensional standard
/// normal distribution has of its probability within `size`: maps three scores to a uniform point of the
/// ball.
double radius_in_ball(double size);

/// The value below which the distribution has this probability.
double quantile_of(const job::Distribution& distribution, double probability);

/// The same for the distribution truncated to values above `least`. Throws InternalError if nothing is left.
double quantile_above(const job::Distribution& distribution, double probability, double least);

}  // namespace vrda::job
