#include "smooth/huber.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "smooth/column_sums.hpp"

namespace vrda {
namespace {

/// These settle a fit where few rows are far off, at a tenth of the cost.
constexpr int unweighted_steps = 30;
/// Enough for the scale to settle where a third of the rows is far off.
constexpr int steps_with_new_scale = 50;
/// Of the noise: no one sees a smaller move of the fit.
constexpr double least_move = 1e-6;
/// Residuals this far below the data are rounding of the sums over the terms.
constexpr double rounding = 64.0 * std::numeric_limits<double>::epsilon();

std::vector<double> residuals_of(const PivotedQr& qr, const std::vector<double>& along,
                                 const std::vector<double>& data)
{
  std::vector<double> residuals = data;
  for (Eigen::Index k = 0; k < qr.Q.cols(); ++k) {
    add_scaled(residuals.data(), -along[static_cast<std::size_t>(k)], qr.Q.col(k).data(), qr.Q.rows());
  }
  return residuals;
}

std::vector<double> weights_of(const std::vector<double>& residuals, double scale)
{
  std::vector<double> weights;
  for (const double residual : residuals) {
    const double limit = huber_constant * scale;
    weights.push_back(std::abs(residual) <= limit ? 1.0 : limit / std::abs(residual));
  }
  return weights;
}

std::vector<double> products(const std::vector<double>& a, const std::vector<double>& b)
{
  std::vector<double> product;
  for (std::size_t i = 0; i < a.size(); ++i) product.push_back(a[i] * b[i]);
  return product;
}

/// Lower triangle L with L L^T = Q^T diag(weights) Q.
Eigen::MatrixXd weighted_triangle(const PivotedQr& qr, const std::vector<double>& weights)
{
  const Eigen::Index m = qr.Q.rows(), n = qr.Q.cols();
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(n, n);
  std::vector<double> weighted(weights.size());
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index i = 0; i < m; ++i)
      weighted[static_cast<std::size_t>(i)] = weights[static_cast<std::size_t>(i)] * qr.Q(i, a);
    for (Eigen::Index b = a; b < n; ++b) L(b, a) = sum_of_products(weighted.data(), qr.Q.col(b).data(), m);
  }
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index c = 0; c < a; ++c)
      add_scaled(L.col(a).data() + a, -L(a, c), L.col(c).data() + a, n - a);
    check(L(a, a) > 0.0, "positive weights leave the rank full");
    const double root = std::sqrt(L(a, a));
    for (Eigen::Index b = a; b < n; ++b) L(b, a) /= root;
  }
  return L;
}

/// L^-1 x; L^-T x.
std::vector<double> forward(const Eigen::MatrixXd& L, std::vector<double> x)
{
  for (Eigen::Index k = 0; k < L.rows(); ++k) {
    x[static_cast<std::size_t>(k)] /= L(k, k);
    add_scaled(x.data() + k + 1, -x[static_cast<std::size_t>(k)], L.col(k).data() + k + 1, L.rows() - k - 1);
  }
  return x;
}

std::vector<double> backward(const Eigen::MatrixXd& L, std::vector<double> x)
{
  for (Eigen::Index k = L.rows(); k-- > 0;) {
    double& value = x[static_cast<std::size_t>(k)];
    value -= sum_of_products(L.col(k).data() + k + 1, x.data() + k + 1, L.rows() - k - 1);
    value /= L(k, k);
  }
  return x;
}

/// (L L^T)^-1 x.
std::vector<double> weighted_solution(const Eigen::MatrixXd& L, std::vector<double> x)
{
  return backward(L, forward(L, std::move(x)));
}

/// weights[i] * |L^-1 row i of Q|^2.
std::vector<double> weighted_leverages(const PivotedQr& qr, const Eigen::MatrixXd& L,
                                       const std::vector<double>& weights)
{
  std::vector<double> leverage;
  std::vector<double> row(static_cast<std::size_t>(qr.Q.cols()));
  for (Eigen::Index i = 0; i < qr.Q.rows(); ++i) {
    for (Eigen::Index k = 0; k < qr.Q.cols(); ++k) row[static_cast<std::size_t>(k)] = qr.Q(i, k);
    const std::vector<double> y = forward(L, row);
    leverage.push_back(weights[static_cast<std::size_t>(i)] * sum_of_products(y.data(), y.data(), L.rows()));
  }
  return leverage;
}

/// The steps: weights, scale and how they ended; the coefficients are not made yet.
HuberFit settled_weights(const PivotedQr& qr, const std::vector<double>& data, int most_steps)
{
  double largest = 0.0;
  for (const double datum : data) largest = std::max(largest, std::abs(datum));
  const double n = static_cast<double>(data.size());
  std::vector<double> along = projection(qr, data);
  HuberFit fit;
  fit.weights.assign(data.size(), 1.0);
  while (fit.n_steps < most_steps && !fit.is_converged) {
    const std::vector<double> residuals = residuals_of(qr, along, data);
    const double scale = fit.n_steps < steps_with_new_scale ? robust_scale(residuals) : fit.scale;
    if (scale <= rounding * largest) {  // more than half the rows lie on the surface
      fit.is_converged = true;
      break;
    }
    fit.scale = scale;
    fit.weights = weights_of(residuals, scale);
    std::vector<double> move = projection(qr, products(fit.weights, residuals));
    if (fit.n_steps >= unweighted_steps) move = weighted_solution(weighted_triangle(qr, fit.weights), move);
    add_scaled(along.data(), 1.0, move.data(), qr.Q.cols());
    const double length_sq = sum_of_products(move.data(), move.data(), qr.Q.cols());
    fit.is_converged = std::sqrt(length_sq / n) <= least_move * scale;
    ++fit.n_steps;
  }
  return fit;
}

}  // namespace

double robust_scale(std::vector<double> values)
{
  if (values.empty()) return 0.0;
  for (double& value : values) value = std::abs(value);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return normal_scale * *middle;
  return normal_scale * 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

HuberFit huber_fit(const PivotedQr& qr, const std::vector<double>& data, const HuberOptions& options)
{
  HuberFit fit = settled_weights(qr, data, options.most_steps);
  const Eigen::MatrixXd L = weighted_triangle(qr, fit.weights);
  fit.coefficients = coefficients_of(qr, weighted_solution(L, projection(qr, products(fit.weights, data))));
  fit.leverage = weighted_leverages(qr, L, fit.weights);
  return fit;
}

}  // namespace vrda
