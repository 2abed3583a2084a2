/// Linear least squares by Eigen's Householder QR with column pivoting.
/// The same bits on every processor: only those functions of Eigen are called that never cut their sums by
/// the sizes of the caches (no product of two matrices, no blocked reflections). The tests set other sizes.
#pragma once

#include <Eigen/Core>

namespace vrda {

/// A = Q R with permuted columns, Q thin.
struct PivotedQr {
  Eigen::MatrixXd Q;      ///< [n_rows, n_columns], orthonormal columns
  Eigen::MatrixXd R;      ///< [n_columns, n_columns], upper triangular
  Eigen::VectorXi order;  ///< column k of Q R is column order(k) of A
  Eigen::Index rank = 0;  ///< |R(k, k)| above n_rows * epsilon * the largest of them
};

/// Of a matrix with at least as many rows as columns, and at least one column.
PivotedQr pivoted_qr(const Eigen::MatrixXd& A);

/// The coefficients whose fitted values are Q * `along`, columns in the order of A. The rank must be full.
Eigen::VectorXd coefficients_of(const PivotedQr& qr, const Eigen::VectorXd& along);

/// The least-squares solution, columns in the order of A. The rank must be full.
Eigen::VectorXd solve(const PivotedQr& qr, const Eigen::VectorXd& data);

/// Diagonal of the hat matrix Q Q^T: how much each row's fitted value follows its own datum, 0 to 1.
Eigen::VectorXd leverages(const PivotedQr& qr);

/// Largest over smallest singular value of A. Full rank only.
double condition_number(const PivotedQr& qr);

}  // namespace vrda
