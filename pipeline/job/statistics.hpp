/// Statistics of samples: quantiles, rank correlation, and first-order Sobol indices from given samples.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace vrda::job {

/// Quantile of the finite values, linear between order statistics (type 7 of Hyndman and Fan, 1996, Am Stat
/// 50:361); NaN without any. 0: smallest, 1: largest.
double quantile(std::vector<double> values, double probability);

/// Spearman's rank correlation of the pairs of finite numbers, ties by mean rank; NaN with fewer than 3 pairs
/// or without spread.
double rank_correlation(std::span<const double> x, std::span<const double> y);

/// Share of the variance of a result that one input explains alone, and its 90 % interval, both within 0 and
/// 1; NaN with fewer than 40 samples or without spread.
struct FirstOrderIndex {
  double index = 0.0, low = 0.0, high = 0.0;
};

/// First-order Sobol indices of one input for many results. The conditional mean of a result is a polynomial
/// of the input's score (Hermite, to degree 3): its adjusted coefficient of determination is the index
/// (polynomial chaos of one variable; Sudret, 2008, Reliab Eng Syst Saf 93:964). The interval is the
/// index +- 1.645 times its standard error by the jackknife over 20 groups of samples.
/// `scores` [n]: standard normal; `results` [n, m]: rows with a number that is not finite are left out. `group` [n]: from 0 to
/// n_jackknife_groups - 1, at random.
std::vector<FirstOrderIndex> first_order_indices(const Eigen::VectorXd& scores, const Eigen::MatrixXd& results,
                                                 const std::vector<int>& group);
inline constexpr int n_jackknife_groups = 20;

/// Groups of equal size in random order.
std::vector<int> jackknife_groups(std::size_t n, std::uint32_t seed);

}  // namespace vrda::job
