#include "analysis/band_matrix.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"

namespace vrda::analysis {

BandMatrix::BandMatrix(Eigen::Index n, Eigen::Index width)
    : n_(n), width_(width), values_(static_cast<std::size_t>(n * (width + 1)), 0.0)
{
}

void BandMatrix::factorise()
{
  for (Eigen::Index i = 0; i < n_; ++i) {
    const Eigen::Index first = std::max<Eigen::Index>(0, i - width_);
    for (Eigen::Index j = first; j <= i; ++j) {
      double sum = at(i, j);
      for (Eigen::Index k = std::max(first, j - width_); k < j; ++k) sum -= at(i, k) * at(j, k);
      if (j < i) {
        at(i, j) = sum / at(j, j);
      } else {
        check(sum > 0.0, "the band matrix is positive definite");
        at(i, i) = std::sqrt(sum);
      }
    }
  }
}

std::vector<double> BandMatrix::solve(std::vector<double> b) const
{
  check(static_cast<Eigen::Index>(b.size()) == n_, "one value per row of the band matrix");
  const auto element = [&b](Eigen::Index i) -> double& { return b[static_cast<std::size_t>(i)]; };
  for (Eigen::Index i = 0; i < n_; ++i) {
    for (Eigen::Index j = std::max<Eigen::Index>(0, i - width_); j < i; ++j)
      element(i) -= at(i, j) * element(j);
    element(i) /= at(i, i);
  }
  for (Eigen::Index i = n_ - 1; i >= 0; --i) {
    for (Eigen::Index j = i + 1; j <= std::min(n_ - 1, i + width_); ++j) element(i) -= at(j, i) * element(j);
    element(i) /= at(i, i);
  }
  return b;
}

std::vector<double> BandMatrix::inverse_diagonal() const
{
  BandMatrix inverse(n_, width_);
  std::vector<double> diagonal(static_cast<std::size_t>(n_));
  for (Eigen::Index j = n_ - 1; j >= 0; --j) {
    const Eigen::Index last = std::min(n_ - 1, j + width_);
    for (Eigen::Index i = last; i >= j; --i) {
      double sum = i == j ? 1.0 / at(j, j) : 0.0;
      for (Eigen::Index k = j + 1; k <= last; ++k)
        sum -= at(k, j) * inverse.at(std::max(i, k), std::min(i, k));
      inverse.at(i, j) = sum / at(j, j);
    }
    diagonal[static_cast<std::size_t>(j)] = inverse.at(j, j);
  }
  return diagonal;
}

}  // namespace vrda::analysis
