/// Prediction errors of a smoothed set for blocks of attitudes that are left out together.
#pragma once

#include <vector>

#include "analysis/smooth.hpp"

namespace vrda::analysis {

/// Attitudes of a contiguous block of the grid.
struct BlockSize {
  Eigen::Index flexion = 1, varus = 1;  ///< at least 1
};

/// [n_flexion, n_varus] number of each cell's block, from 0. The last blocks of an axis may be smaller.
store::GridI block_numbers(Eigen::Index n_flexion, Eigen::Index n_varus, const BlockSize& size);

/// Raw minus predicted value of a fit without the cell's block, in the order of fit.set.surfaces; NaN where
/// the cell is not fitted, or if the other cells do not determine the fit. Exact for least squares, e = (I -
/// H)^-1 r with the block's part H of the hat matrix; for a robust fit the weights are kept. `fit` is of
/// `input`.
std::vector<store::GridD> leave_blocks_out(const SmoothInput& input, const SmoothFit& fit,
                                           const BlockSize& size);

}  // namespace vrda::analysis
