#include "smooth/singular_values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.hpp"
#include "smooth/column_sums.hpp"

namespace vrda {
namespace {

/// Turns x into v of the reflection I - 2 v v^T / (v^T v) that leaves of x its first entry alone; returns
/// that entry. v is 0 where x is.
double reflection_of(std::vector<double>& x)
{
  const double norm = std::sqrt(sum_of_products(x.data(), x.data(), static_cast<Eigen::Index>(x.size())));
  // Away from zero, so that no digits cancel.
  const double left = x[0] >= 0.0 ? -norm : norm;
  x[0] -= left;
  return left;
}

double length_sq(const std::vector<double>& v)
{
  return sum_of_products(v.data(), v.data(), static_cast<Eigen::Index>(v.size()));
}

/// Reflects rows [k, n) of columns [k + 1, n) so that column k is zero below row k; returns entry (k, k).
double clear_column(Eigen::MatrixXd& A, Eigen::Index k)
{
  const Eigen::Index n = A.rows();
  std::vector<double> v(A.col(k).data() + k, A.col(k).data() + n);
  const double left = reflection_of(v);
  const double v_sq = length_sq(v);
  if (v_sq == 0.0) return left;
  for (Eigen::Index c = k + 1; c < n; ++c) {
    double* column = A.col(c).data() + k;
    add_scaled(column, -2.0 * sum_of_products(v.data(), column, n - k) / v_sq, v.data(), n - k);
  }
  return left;
}

/// Reflects columns [k + 1, n) of rows [k + 1, n) so that row k is zero beyond column k + 1; returns entry
/// (k, k + 1).
double clear_row(Eigen::MatrixXd& A, Eigen::Index k)
{
  const Eigen::Index n = A.rows(), from = k + 1;
  std::vector<double> v;
  for (Eigen::Index c = from; c < n; ++c) v.push_back(A(k, c));
  const double left = reflection_of(v);
  const double v_sq = length_sq(v);
  if (v_sq == 0.0) return left;
  std::vector<double> product(static_cast<std::size_t>(n - from), 0.0);
  for (Eigen::Index c = from; c < n; ++c)
    add_scaled(product.data(), v[static_cast<std::size_t>(c - from)], A.col(c).data() + from, n - from);
  for (Eigen::Index c = from; c < n; ++c) {
    add_scaled(A.col(c).data() + from, -2.0 * v[static_cast<std::size_t>(c - from)] / v_sq, product.data(),
               n - from);
  }
  return left;
}

/// Squares of d_0, e_0, d_1, e_1, ..., d_{n-1}: off the zero diagonal of a symmetric tridiagonal matrix whose
/// eigenvalues are the singular values of the bidiagonal matrix (d on, e above the diagonal) and their
/// opposites.
std::vector<double> off_diagonal_sq(Eigen::MatrixXd A)
{
  std::vector<double> squares;
  for (Eigen::Index k = 0; k < A.rows(); ++k) {
    const double d = clear_column(A, k);
    squares.push_back(d * d);
    if (k + 1 == A.rows()) break;
    const double e = clear_row(A, k);
    squares.push_back(e * e);
  }
  return squares;
}

/// Eigenvalues of the tridiagonal matrix below x: the signs of its pivots.
std::size_t count_below(const std::vector<double>& off_sq, double x)
{
  double pivot = -x;
  std::size_t n_below = pivot < 0.0 ? 1 : 0;
  for (const double square : off_sq) {
    if (pivot == 0.0) pivot = std::numeric_limits<double>::min();
    pivot = -x - square / pivot;
    if (pivot < 0.0) ++n_below;
  }
  return n_below;
}

/// Where the count of eigenvalues below x reaches `n_wanted`: halved until no number lies between.
double eigenvalue(const std::vector<double>& off_sq, std::size_t n_wanted, double bound)
{
  double low = 0.0, high = bound;
  while (true) {
    const double middle = 0.5 * (low + high);
    if (middle <= low || middle >= high) return middle;
    (count_below(off_sq, middle) >= n_wanted ? high : low) = middle;
  }
}

}  // namespace

SingularRange singular_range(const Eigen::MatrixXd& square)
{
  check(square.rows() == square.cols() && square.cols() > 0, "singular values of a square matrix");
  const std::vector<double> off_sq = off_diagonal_sq(square);
  // Gershgorin: no eigenvalue beyond the largest sum of two neighbours.
  const double bound = 2.0 * std::sqrt(*std::max_element(off_sq.begin(), off_sq.end())) *
                       (1.0 + 4.0 * std::numeric_limits<double>::epsilon());
  const std::size_t n = (off_sq.size() + 1) / 2;
  return {eigenvalue(off_sq, 2 * n, bound), eigenvalue(off_sq, n + 1, bound)};
}

}  // namespace vrda
