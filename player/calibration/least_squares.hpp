/// The least sum of squares of residuals, by NLopt, and what it leaves at marks.
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

/// Noise of an alignment by eye that fits begin with.
inline constexpr double start_noise_px = 0.5;
/// No hand aligns better; keeps weights finite where marks fit exactly.
inline constexpr double least_noise_px = 1e-4;

/// Degrees of freedom of the marks' noise: their coordinates less the share of the fitted numbers that they
/// determine (the trace of their part of the hat matrix); what was known before determines the rest.
double noise_dof(const LeastSquares& fit, Eigen::Index n_marks);

/// One for the intervals of all numbers `to_numbers` x [k, n]: the variance of what was known before is not
/// uncertain as that of the noise is, so a number has more than noise_dof(), the more the smaller the marks'
/// share of its variance. That of the mean share; infinite where the marks tell nothing. Source:
/// Satterthwaite (1946) Biometrics Bulletin 2, of two variances one known.
double interval_dof(const LeastSquares& fit, Eigen::Index n_marks, const Eigen::MatrixXd& to_numbers);

/// How far a mark lies from where all the others say, in standard deviations of the others' noise.
struct FurthestMark {
  Eigen::Index mark = 0;
  double deviations = 0.0;
  Eigen::Vector2d off = Eigen::Vector2d::Zero();  ///< in units of the mark's standard deviation
};
/// The furthest of them. The fit without each mark follows from the fit with all, as far as it is linear.
FurthestMark furthest_mark(const LeastSquares& fit, Eigen::Index n_marks);

}  // namespace vrda
