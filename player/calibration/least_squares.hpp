/// The least sum of squares of residuals, by NLopt.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace vrda {

struct FitProblem {
  /// [m] of x [n]; each in units of its standard deviation. May throw; must have the same size always.
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residuals;
  Eigen::VectorXd start;        ///< [n] within the bounds
  Eigen::VectorXd scale;        ///< [n] how much of each number is much: steps of differences are 1e-6 of it
  Eigen::VectorXd least, most;  ///< [n] bounds; empty: none
};

enum class LeastSquaresStatus {
  converged,
  at_a_bound,  ///< a number stands at its bound
  iteration_limit,
  undetermined  ///< the residuals do not tell some combination of the numbers
};
const char* name_of(LeastSquaresStatus status);

struct LeastSquares {
  Eigen::VectorXd x;           ///< [n]
  Eigen::VectorXd residuals;   ///< [m] at x
  Eigen::MatrixXd J;           ///< [m, n] at x, by central differences
  Eigen::MatrixXd covariance;  ///< [n, n] inverse of J^T J; zero where undetermined
  LeastSquaresStatus status = LeastSquaresStatus::iteration_limit;
};

/// Rethrows what `residuals` throws.
LeastSquares fit_least_squares(const FitProblem& problem);

}  // namespace vrda
