#include "compare/roughness.hpp"

#include <cmath>

#include "core/error.hpp"

namespace vrda {
namespace {

/// Coefficient (i, j) of P_i(u) P_j(v).
using Series = Eigen::MatrixXd;

/// d/du: P'_n = (2n - 1) P_{n-1} + (2n - 5) P_{n-3} + ...
Series derivative_by_rows(const Series& series)
{
  Series derivative = Series::Zero(series.rows(), series.cols());
  for (Eigen::Index n = 1; n < series.rows(); ++n) {
    for (Eigen::Index k = n - 1; k >= 0; k -= 2) {
      for (Eigen::Index j = 0; j < series.cols(); ++j)
        derivative(k, j) += static_cast<double>(2 * k + 1) * series(n, j);
    }
  }
  return derivative;
}

Series derivative_by_columns(const Series& series)
{
  return derivative_by_rows(series.transpose()).transpose();
}

/// Mean of the square over [-1, 1]^2: that of P_i is 1 / (2i + 1).
double mean_square(const Series& series)
{
  double sum = 0.0;
  for (Eigen::Index i = 0; i < series.rows(); ++i) {
    for (Eigen::Index j = 0; j < series.cols(); ++j)
      sum += series(i, j) * series(i, j) / static_cast<double>((2 * i + 1) * (2 * j + 1));
  }
  return sum;
}

/// du/dx; 0 where the axis has one value.
double slope(const AxisRange& range)
{
  return range.first_deg == range.last_deg ? 0.0 : 2.0 / (range.last_deg - range.first_deg);
}

}  // namespace

double roughness(const SmoothedSet& set, const SmoothedSurface& surface, const AxisRanges& ranges)
{
  check(static_cast<Eigen::Index>(surface.coefficients.size()) == set.exponents.rows(),
        "a coefficient a term");
  Series series = Series::Zero(set.degree + 1, set.degree + 1);
  for (Eigen::Index k = 0; k < set.exponents.rows(); ++k)
    series(set.exponents(k, 0), set.exponents(k, 1)) = surface.coefficients[static_cast<std::size_t>(k)];
  const double f = slope(ranges.flexion), w = slope(ranges.varus);
  const Series by_flexion = derivative_by_rows(series) * f, by_varus = derivative_by_columns(series) * w;
  return std::sqrt(mean_square(derivative_by_rows(by_flexion) * f) +
                   2.0 * mean_square(derivative_by_columns(by_flexion) * w) +
                   mean_square(derivative_by_columns(by_varus) * w));
}

}  // namespace vrda
