/// Non-linear least squares by NLopt, degrees of freedom and outlier detection.
#pragma once

#include <Eigen/Core>

#include <functional>

#include "bench/calibration_file.hpp"

namespace vrda::calibration {

struct FitProblem {
  /// Residuals [m] of x [n], in units of standard deviation. May throw; the size must be constant.
  std::function<Eigen::VectorXd(const Eigen::VectorXd&)> residuals;
  /// Their derivatives [m, n]; empty: central differences.
  std::function<Eigen::MatrixXd(const Eigen::VectorXd&)> derivatives = {};
  Eigen::VectorXd start;  ///< [n]
  Eigen::VectorXd scale;  ///< [n] typical magnitude; difference steps are 1e-6 of it
};

enum class LeastSquaresStatus {
  converged,
  iteration_limit,
  undetermined  ///< J^T J is singular: the residuals do not determine all numbers
};
const char* name_of(LeastSquaresStatus status);

struct LeastSquares {
  Eigen::VectorXd x;           ///< [n]
  Eigen::VectorXd residuals;   ///< [m] at x
  Eigen::MatrixXd J;           ///< [m, n] at x
  Eigen::MatrixXd covariance;  ///< [n, n] inverse of J^T J; zero if undetermined
  LeastSquaresStatus status = LeastSquaresStatus::iteration_limit;
};

/// Minimises the sum of squares. Rethrows exceptions of `residuals`.
LeastSquares fit_least_squares(const FitProblem& problem);

/// Initial noise of an alignment by eye.
inline constexpr double initial_noise_px = 0.5;
/// Lower limit of the noise; keeps weights finite if marks fit exactly.
inline constexpr double minimum_noise_px = 1e-4;

/// Degrees of freedom of the noise of the marks: number of coordinates minus the trace of their block of the
/// hat matrix (the prior determines the rest of the parameters).
double noise_dof(const LeastSquares& fit, Eigen::Index n_marks);

/// Common degrees of freedom for the intervals of the numbers `to_numbers` x [k, n]. The prior variance is
/// known exactly, so the result exceeds noise_dof() by the inverse squared mean share of the marks in the
/// variances; infinite if the marks contribute nothing. Source: Satterthwaite (1946) Biometrics Bulletin 2,
/// one variance known.
double interval_dof(const LeastSquares& fit, Eigen::Index n_marks, const Eigen::MatrixXd& to_numbers);

/// Deviation of a mark from the fit to all others, in standard deviations of their noise.
struct OutlierCandidate {
  Eigen::Index mark = 0;
  double deviations = 0.0;
  Eigen::Vector2d off = Eigen::Vector2d::Zero();  ///< offset in units of the mark's standard deviation
};
/// Mark with the largest deviation. The fit without a mark follows from the full fit by linearisation.
OutlierCandidate largest_outlier(const LeastSquares& fit, Eigen::Index n_marks);

/// A fit to marks on the screen, weighted with `sds_px` [n_marks].
struct MarksFit {
  LeastSquares fit;
  Eigen::VectorXd sds_px;

  Eigen::Index n() const { return sds_px.size(); }
  /// Of the marks, weighted off: their lengths, px.
  std::vector<double> residuals_px() const;
};

/// Throws FitError unless the fit, `what`, has converged.
void require_converged(const LeastSquares& fit, const std::string& field, const std::string& what,
                       const std::string& wanted, const bench::FitErrorContext& context);

struct OutlierLimits {
  double deviations, px;  ///< an outlier exceeds both
  const char* again;      ///< what to do with the mark
};
/// Throws FitError for the worst mark if it is an outlier; `field_of` names it.
void refuse_outlier(const MarksFit& marks, const OutlierLimits& limits,
                    const std::function<std::string(std::size_t)>& field_of,
                    const bench::FitErrorContext& context);

// Dense linear algebra of dynamic size, compiled once: each instance of Eigen's templates takes seconds.

/// Eigenvalues of a symmetric positive semi-definite matrix, descending, and unit eigenvectors in columns.
struct PrincipalAxes {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};
PrincipalAxes principal_axes(const Eigen::MatrixXd& semi_definite);

Eigen::MatrixXd product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);
/// A x
Eigen::VectorXd transformed(const Eigen::MatrixXd& A, const Eigen::VectorXd& x);
/// A A^T
Eigen::MatrixXd square(const Eigen::MatrixXd& A);
/// Covariance A C A^T of A x for the covariance C of x.
Eigen::MatrixXd propagated(const Eigen::MatrixXd& A, const Eigen::MatrixXd& C);

/// L with L L^T = `covariance` and one column per non-zero eigenvalue, so that variances may be zero.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance);

/// R with R R^T = N^-1 and one column per eigenvalue of N that is not zero to rounding. N: positive
/// semi-definite; `scale`: typical magnitudes of its unknowns.
Eigen::MatrixXd inverse_root_of(const Eigen::MatrixXd& N, const Eigen::VectorXd& scale);

/// The same with the scale of N's diagonal.
Eigen::MatrixXd inverse_root_of(const Eigen::MatrixXd& N);

}  // namespace vrda::calibration
