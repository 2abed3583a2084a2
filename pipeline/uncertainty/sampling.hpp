/// Samples of the unit cube: the same numbers for the same arguments on every machine.
#pragma once

#include <Eigen/Core>

#include "load/uncertainty.hpp"

namespace vrda::uncertainty {

/// Number of dimensions of the Sobol sequence (Joe and Kuo, direction numbers of Boost).
inline constexpr std::size_t most_sobol_dimensions = 3667;

/// [n_samples, n_dimensions], above 0 and below 1. `sobol`: the sequence from its first point, with a random
/// digital shift of each dimension; `latin_hypercube`: one sample in each of n_samples equal intervals of
/// each dimension.
Eigen::MatrixXd unit_samples(load::SampleSequence sequence, Eigen::Index n_samples, Eigen::Index n_dimensions,
                             std::uint32_t seed);

}  // namespace vrda::uncertainty
