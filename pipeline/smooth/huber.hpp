/// Robust regression: cells far off the surface pull at it with a limited force.
#pragma once

#include "smooth/least_squares.hpp"

namespace vrda {

/// Residuals beyond this many scales weigh less: 95 % as good as least squares on normal noise (Huber 1981).
inline constexpr double huber_constant = 1.345;

/// Times the median of |noise|: the standard deviation where the noise is normal, 1 / quantile(3/4).
inline constexpr double normal_scale = 1.4826022185056018;

/// normal_scale * median of |value|; 0 of none.
double robust_scale(Eigen::VectorXd values);

/// A weighted least-squares solution whose weights follow from its residuals.
struct HuberFit {
  Eigen::VectorXd coefficients;  ///< columns in the order of the matrix decomposed
  Eigen::VectorXd weights;       ///< [n_rows] min(1, huber_constant * scale / |residual|)
  Eigen::VectorXd leverage;      ///< [n_rows] diagonal of the hat matrix of the weighted problem
  double scale = 0.0;            ///< robust_scale of the residuals the weights were made of
  int n_steps = 0;
  bool is_converged = false;  ///< else the best after most_steps
};

struct HuberOptions {
  int most_steps = 300;
};

/// Huber's estimate: weighted least squares, the weights made of the residuals again until they stay, that is
/// sum of weight * residual * row = 0. The first 30 steps take the unweighted matrix in place of the weighted
/// one (Huber, Dutter 1974): they end at the same point and need no decomposition; the others are those of
/// iteratively reweighted least squares. The scale is estimated anew in the first 50 and held after them,
/// which makes the loss convex and every step descend. The steps end when one moves the fit by less than 1e-6
/// of the scale (root mean square), or when most of the data is fitted to rounding. The result is the
/// weighted least-squares solution with the weights reached, so `leverage` is exact for it: residual / (1 -
/// leverage) is what a refit without the row and with these weights leaves there. The rank must be full.
HuberFit huber_fit(const PivotedQr& qr, const Eigen::VectorXd& data, const HuberOptions& options = {});

}  // namespace vrda
