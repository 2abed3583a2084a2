#include "analysis/huber.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.hpp"

namespace vrda::analysis {
namespace {

/// Enough to converge with few outliers, at a tenth of the cost.
constexpr int unweighted_steps = 30;
/// Enough for the scale to converge if a third of the rows are outliers.
constexpr int steps_with_new_scale = 50;
/// Fraction of the noise; smaller changes of the fit are imperceptible.
constexpr double convergence_tolerance = 1e-6;
/// Residuals this far below the data are rounding of the sums over the terms.
constexpr double rounding = 64.0 * std::numeric_limits<double>::epsilon();

Eigen::VectorXd weights_of(const Eigen::VectorXd& residuals, double scale)
{
  const double limit = huber_constant * scale;
  return residuals.unaryExpr([&](double r) { return std::abs(r) <= limit ? 1.0 : limit / std::abs(r); });
}

using WeightedNormal = Eigen::LDLT<Eigen::MatrixXd>;

/// Decomposes Q^T diag(weights) Q. Matrix-vector products and LDLT (not LLT) do not depend on the cache sizes
/// (least_squares.hpp).
WeightedNormal weighted_normal(const PivotedQr& qr, const Eigen::VectorXd& weights)
{
  const Eigen::Index n = qr.Q.cols();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::VectorXd weighted = weights.cwiseProduct(qr.Q.col(k));
    lower.col(k).tail(n - k).noalias() = qr.Q.rightCols(n - k).transpose() * weighted;
  }
  WeightedNormal normal(lower);
  check(normal.vectorD().minCoeff() > 0.0, "positive weights leave the rank full");
  return normal;
}

/// weights(i) * row i of Q * (Q^T diag(weights) Q)^-1 * row i of Q.
Eigen::VectorXd weighted_leverages(const PivotedQr& qr, const WeightedNormal& normal,
                                   const Eigen::VectorXd& weights)
{
  Eigen::VectorXd leverage(qr.Q.rows());
  for (Eigen::Index i = 0; i < qr.Q.rows(); ++i) {
    Eigen::VectorXd y = normal.transpositionsP() * qr.Q.row(i).transpose();
    normal.matrixL().solveInPlace(y);
    leverage(i) = weights(i) * (y.array().square() / normal.vectorD().array()).sum();
  }
  return leverage;
}

/// Iterates weights and scale; does not set the coefficients.
HuberFit iterated_weights(const PivotedQr& qr, const Eigen::VectorXd& data, int most_steps)
{
  const double largest = data.cwiseAbs().maxCoeff();
  const double root_n = std::sqrt(static_cast<double>(data.size()));
  Eigen::VectorXd along = qr.Q.transpose() * data;
  HuberFit fit;
  fit.weights = Eigen::VectorXd::Ones(data.size());
  while (fit.n_iterations < most_steps && !fit.is_converged) {
    const Eigen::VectorXd residuals = data - qr.Q * along;
    const double scale = fit.n_iterations < steps_with_new_scale ? robust_scale(residuals) : fit.scale;
    if (scale <= rounding * largest) {  // more than half of the rows are on the surface
      fit.is_converged = true;
      break;
    }
    fit.scale = scale;
    fit.weights = weights_of(residuals, scale);
    Eigen::VectorXd move = qr.Q.transpose() * fit.weights.cwiseProduct(residuals);
    if (fit.n_iterations >= unweighted_steps) move = weighted_normal(qr, fit.weights).solve(move).eval();
    along += move;
    fit.is_converged = move.norm() <= convergence_tolerance * scale * root_n;
    ++fit.n_iterations;
  }
  return fit;
}

}  // namespace

double robust_scale(Eigen::VectorXd values)
{
  if (values.size() == 0) return 0.0;
  values = values.cwiseAbs();
  double* const middle = values.data() + values.size() / 2;
  std::nth_element(values.data(), middle, values.data() + values.size());
  if (values.size() % 2 == 1) return normal_scale * *middle;
  return normal_scale * 0.5 * (*middle + *std::max_element(values.data(), middle));
}

HuberFit huber_fit(const PivotedQr& qr, const Eigen::VectorXd& data, const HuberOptions& options)
{
  HuberFit fit = iterated_weights(qr, data, options.max_iterations);
  const WeightedNormal normal = weighted_normal(qr, fit.weights);
  const Eigen::VectorXd along = normal.solve(qr.Q.transpose() * fit.weights.cwiseProduct(data));
  fit.coefficients = coefficients_of(qr, along);
  fit.leverage = weighted_leverages(qr, normal, fit.weights);
  return fit;
}

}  // namespace vrda::analysis
