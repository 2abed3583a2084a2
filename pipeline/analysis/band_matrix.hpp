/// Symmetric positive definite matrices with few diagonals: Cholesky factor, solution, diagonal of the
/// inverse. Own loops in a fixed order: the same bits on every processor.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace vrda::analysis {

/// Lower triangle of an n x n matrix with `width` diagonals below the main one.
class BandMatrix {
 public:
  BandMatrix(Eigen::Index n, Eigen::Index width);

  Eigen::Index size() const { return n_; }
  /// Element of row i and column j, i - width <= j <= i.
  double& at(Eigen::Index i, Eigen::Index j) { return values_[index(i, j)]; }
  double at(Eigen::Index i, Eigen::Index j) const { return values_[index(i, j)]; }

  /// Replaces the matrix by its factor L, L L^T = matrix.
  void factorise();
  /// The solution of matrix * x = b, after factorise().
  std::vector<double> solve(std::vector<double> b) const;
  /// Diagonal of the inverse, after factorise(). Source: Takahashi, Fagan and Chen (1973); Hutchinson and de
  /// Hoog (1985) Numer Math 47:99-106.
  std::vector<double> inverse_diagonal() const;

 private:
  std::size_t index(Eigen::Index i, Eigen::Index j) const
  {
    return static_cast<std::size_t>(i * (width_ + 1) + i - j);
  }
  Eigen::Index n_, width_;
  std::vector<double> values_;
};

}  // namespace vrda::analysis
