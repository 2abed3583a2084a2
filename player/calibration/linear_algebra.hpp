/// Dense linear algebra of dynamic size, compiled once: each instance of Eigen's templates takes seconds.
#pragma once

#include <Eigen/Core>

namespace vrda::calibration {

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
