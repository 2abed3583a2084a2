#include "calibration/aligned_marks.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace vrda {
namespace {

Eigen::Matrix2d leverage(const LeastSquares& fit, Eigen::Index mark)
{
  const auto J = fit.J.middleRows<2>(2 * mark);
  return J * fit.covariance * J.transpose();
}

}  // namespace

double noise_dof(const LeastSquares& fit, Eigen::Index n_marks)
{
  double dof = 2.0 * static_cast<double>(n_marks);
  for (Eigen::Index mark = 0; mark < n_marks; ++mark) dof -= leverage(fit, mark).trace();
  return dof;
}

double interval_dof(const LeastSquares& fit, Eigen::Index n_marks, const Eigen::MatrixXd& to_numbers)
{
  const Eigen::MatrixXd gain =
      to_numbers * fit.covariance * fit.J.topRows(2 * n_marks).transpose();  // of numbers by marks
  const Eigen::VectorXd by_marks = gain.rowwise().squaredNorm();
  const Eigen::VectorXd all = (to_numbers * fit.covariance * to_numbers.transpose()).diagonal();
  double shares = 0.0, n = 0.0;
  for (Eigen::Index k = 0; k < all.size(); ++k) {
    if (!(all[k] > 0.0)) continue;
    shares += by_marks[k] / all[k];
    n += 1.0;
  }
  const double share = n > 0.0 ? shares / n : 0.0;
  return noise_dof(fit, n_marks) / (share * share);
}

FurthestMark furthest_mark(const LeastSquares& fit, Eigen::Index n_marks)
{
  constexpr double alone = 1e-9;  // a mark that no other one says anything about
  constexpr double least_sum = std::numeric_limits<double>::min();
  const double square_sum = fit.residuals.head(2 * n_marks).squaredNorm();
  const double dof_without = noise_dof(fit, n_marks) - 2.0;
  FurthestMark furthest;
  for (Eigen::Index mark = 0; mark < n_marks; ++mark) {
    const Eigen::Matrix2d left_over = Eigen::Matrix2d::Identity() - leverage(fit, mark);
    if (left_over.determinant() < alone || dof_without <= 0.0) continue;
    const Eigen::Vector2d left = fit.residuals.segment<2>(2 * mark);
    const Eigen::Vector2d off = left_over.inverse() * left;
    const double gain = left.dot(off);
    const double variance_without = std::max(square_sum - gain, least_sum) / dof_without;
    const double deviations = std::sqrt(std::max(gain, 0.0) / variance_without);
    if (deviations > furthest.deviations) furthest = {mark, deviations, off};
  }
  return furthest;
}

}  // namespace vrda
