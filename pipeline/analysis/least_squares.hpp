/// Linear least squares by Eigen's Householder QR with column pivoting.
/// Bitwise equal on every processor: uses only Eigen functions whose sums do not depend on the cache sizes
/// (no product of two matrices, no blocked reflections). The tests set other sizes.
#pragma once

#include <Eigen/Core>

namespace vrda::analysis {

/// A = Q R with permuted columns, Q thin.
struct PivotedQr {
  Eigen::MatrixXd Q;      ///< [n_rows, n_columns], orthonormal columns
  Eigen::MatrixXd R;      ///< [n_columns, n_columns], upper triangular
  Eigen::VectorXi order;  ///< column k of Q R is column order(k) of A
  Eigen::Index rank = 0;  ///< |R(k, k)| above n_rows * epsilon * the largest of them
};

/// A must have at least one column and at least as many rows as columns.
PivotedQr pivoted_qr(const Eigen::MatrixXd& A);

/// Coefficients whose fitted values are Q * `along`, in the column order of A. The rank must be full.
Eigen::VectorXd coefficients_of(const PivotedQr& qr, const Eigen::VectorXd& along);

/// Least-squares solution, in the column order of A. The rank must be full.
Eigen::VectorXd solve(const PivotedQr& qr, const Eigen::VectorXd& data);

/// Diagonal of the hat matrix Q Q^T: derivative of each row's fitted value by its datum, 0 to 1.
Eigen::VectorXd leverages(const PivotedQr& qr);

/// Largest over smallest singular value of A. The rank must be full.
double condition_number(const PivotedQr& qr);

}  // namespace vrda::analysis
