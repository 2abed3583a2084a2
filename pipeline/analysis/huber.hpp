/// Robust regression: outliers have a limited influence.
#pragma once

#include "analysis/least_squares.hpp"

namespace vrda::analysis {

/// Residuals beyond this multiple of the scale get less weight: 95 % efficiency on normal noise (Huber 1981).
inline constexpr double huber_constant = 1.345;

/// Standard deviation of normal noise over the median of its absolute value: 1 / quantile(3/4).
inline constexpr double normal_scale = 1.4826022185056018;

/// normal_scale * median of |value|; 0 without values.
double robust_scale(Eigen::VectorXd values);

/// A weighted least-squares solution with Huber weights of its residuals.
struct HuberFit {
  Eigen::VectorXd coefficients;  ///< columns in the order of the decomposed matrix
  Eigen::VectorXd weights;       ///< [n_rows] min(1, huber_constant * scale / |residual|)
  Eigen::VectorXd leverage;      ///< [n_rows] diagonal of the hat matrix of the weighted problem
  double scale = 0.0;            ///< robust_scale of the residuals that set the weights
  int n_iterations = 0;
  bool is_converged = false;  ///< if false, the iterate after max_iterations
};

struct HuberOptions {
  int max_iterations = 300;
};

/// Huber's M-estimate: solves sum of weight * residual * row = 0. The first 30 iterations use the unweighted
/// matrix (Huber, Dutter 1974): same fixed point, no decomposition. The others are iteratively reweighted
/// least squares. The scale is estimated in the first 50 iterations and then fixed, so the loss is convex and
/// every iteration descends. Stops when an iteration changes the fit by less than 1e-6 of the scale (root
/// mean square), or when most of the data is fitted to rounding. The result is the weighted least-squares
/// solution with the final weights, so residual / (1 - leverage) is exactly the error of a refit without the
/// row and with these weights. The rank must be full.
HuberFit huber_fit(const PivotedQr& qr, const Eigen::VectorXd& data, const HuberOptions& options = {});

}  // namespace vrda::analysis
