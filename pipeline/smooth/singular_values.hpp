/// The ends of the spectrum of a small square matrix.
#pragma once

#include <Eigen/Core>

namespace vrda {

struct SingularRange {
  double largest = 0.0;
  double smallest = 0.0;
};

/// Largest and smallest singular value of a square matrix of at least one column: Householder steps from both
/// sides to two diagonals, then bisection on the count of eigenvalues below a number (Sturm sequence).
/// Error: a few rounding errors of the largest one. Cost: 8/3 n^3.
/// Source: Golub, Van Loan (2013), Matrix Computations, 5.4.8 and 8.4.
SingularRange singular_range(const Eigen::MatrixXd& square);

}  // namespace vrda
