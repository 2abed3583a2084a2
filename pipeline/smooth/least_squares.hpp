/// Linear least squares by Householder QR with column pivoting, in plain loops: sums run in one order
/// whatever the processor's caches (Eigen's blocked products choose their blocks by them).
#pragma once

#include <Eigen/Core>
#include <vector>

namespace vrda {

/// A = Q R with permuted columns, Q thin.
struct PivotedQr {
  Eigen::MatrixXd Q;                ///< [n_rows, n_columns], orthonormal columns
  Eigen::MatrixXd R;                ///< [n_columns, n_columns], upper triangular
  std::vector<Eigen::Index> order;  ///< column k of Q R is column order[k] of A
  Eigen::Index rank = 0;            ///< |R(k, k)| above n_rows * epsilon * |R(0, 0)|
};

/// Of a matrix with at least as many rows as columns, and at least one column.
PivotedQr pivoted_qr(const Eigen::MatrixXd& A);

/// Q^T data: the fitted values are Q times it.
std::vector<double> projection(const PivotedQr& qr, const std::vector<double>& data);

/// The coefficients whose fitted values are Q * `along`, columns in the order of A. The rank must be full.
std::vector<double> coefficients_of(const PivotedQr& qr, std::vector<double> along);

/// The least-squares solution, columns in the order of A. The rank must be full.
std::vector<double> solve(const PivotedQr& qr, const std::vector<double>& right_side);

/// Diagonal of the hat matrix Q Q^T: how much each row's fitted value follows its own datum, 0 to 1.
std::vector<double> leverages(const PivotedQr& qr);

/// Largest over smallest singular value of A. Full rank only.
double condition_number(const PivotedQr& qr);

}  // namespace vrda
