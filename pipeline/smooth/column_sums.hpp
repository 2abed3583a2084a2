/// Sums over the rows of columns, in one order whatever the processor: a library's order follows its caches.
#pragma once

#include <Eigen/Core>

namespace vrda {

/// Sum of x[i] * y[i]: in eight sums side by side, added pairwise, since one sum would wait for itself.
inline double sum_of_products(const double* x, const double* y, Eigen::Index n)
{
  using Lanes = Eigen::Array<double, 8, 1>;
  Lanes sums = Lanes::Zero();
  Eigen::Index i = 0;
  for (; i + 8 <= n; i += 8) sums += Eigen::Map<const Lanes>(x + i) * Eigen::Map<const Lanes>(y + i);
  double rest = 0.0;
  for (; i < n; ++i) rest += x[i] * y[i];
  return (((sums[0] + sums[1]) + (sums[2] + sums[3])) + ((sums[4] + sums[5]) + (sums[6] + sums[7]))) + rest;
}

/// y += scale * x.
inline void add_scaled(double* y, double scale, const double* x, Eigen::Index n)
{
  using Lanes = Eigen::Array<double, 8, 1>;
  Eigen::Index i = 0;
  for (; i + 8 <= n; i += 8) Eigen::Map<Lanes>(y + i) += scale * Eigen::Map<const Lanes>(x + i);
  for (; i < n; ++i) y[i] += scale * x[i];
}

}  // namespace vrda
