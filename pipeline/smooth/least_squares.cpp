#include "smooth/least_squares.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.hpp"
#include "smooth/column_sums.hpp"
#include "smooth/singular_values.hpp"

namespace vrda {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
/// A norm taken from its column by subtraction is summed again once less than this of its square is left:
/// by then half its digits have gone.
constexpr double least_kept = 1e-8;

double column_sq(const Eigen::MatrixXd& A, Eigen::Index column, Eigen::Index from)
{
  const double* x = A.col(column).data() + from;
  return sum_of_products(x, x, A.rows() - from);
}

/// What is left below row `from` of each column, as squares: subtracted row by row (cheap), summed again
/// where that has lost its digits.
struct RemainingNorms {
  std::vector<double> sq, summed_sq;  ///< now; when last summed

  explicit RemainingNorms(const Eigen::MatrixXd& A)
  {
    for (Eigen::Index k = 0; k < A.cols(); ++k) sq.push_back(column_sq(A, k, 0));
    summed_sq = sq;
  }
  void leave_row(const Eigen::MatrixXd& A, Eigen::Index row)
  {
    for (Eigen::Index c = row + 1; c < A.cols(); ++c) {
      const auto k = static_cast<std::size_t>(c);
      sq[k] -= A(row, c) * A(row, c);
      if (sq[k] > least_kept * summed_sq[k]) continue;
      sq[k] = summed_sq[k] = column_sq(A, c, row + 1);
    }
  }
  void swap(Eigen::Index a, Eigen::Index b)
  {
    std::swap(sq[static_cast<std::size_t>(a)], sq[static_cast<std::size_t>(b)]);
    std::swap(summed_sq[static_cast<std::size_t>(a)], summed_sq[static_cast<std::size_t>(b)]);
  }
  /// Column of [from, end) with the largest remaining norm, the first one among equals.
  Eigen::Index largest(Eigen::Index from) const
  {
    return std::max_element(sq.begin() + from, sq.end()) - sq.begin();
  }
};

/// Applies I - 2 v v^T / (v^T v), v in column `k` of V below row k, to column `c` of A.
void reflect(const Eigen::MatrixXd& V, Eigen::Index k, double v_sq, Eigen::MatrixXd& A, Eigen::Index c)
{
  const Eigen::Index n = A.rows() - k;
  const double* v = V.col(k).data() + k;
  double* column = A.col(c).data() + k;
  add_scaled(column, -2.0 * sum_of_products(v, column, n) / v_sq, v, n);
}

}  // namespace

PivotedQr pivoted_qr(const Eigen::MatrixXd& A)
{
  const Eigen::Index m = A.rows(), n = A.cols();
  check(m >= n && n > 0, "least squares needs a column, and as many rows as columns");
  Eigen::MatrixXd work = A;
  Eigen::MatrixXd V = Eigen::MatrixXd::Zero(m, n);
  std::vector<double> v_sq(static_cast<std::size_t>(n), 0.0);
  RemainingNorms norms(work);
  PivotedQr qr;
  qr.R = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) qr.order.push_back(k);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index chosen = norms.largest(k);
    work.col(k).swap(work.col(chosen));
    norms.swap(k, chosen);
    std::swap(qr.order[static_cast<std::size_t>(k)], qr.order[static_cast<std::size_t>(chosen)]);
    const double norm = std::sqrt(column_sq(work, k, k));
    for (Eigen::Index i = k; i < m; ++i) V(i, k) = work(i, k);
    // Away from zero, so that no digits cancel.
    V(k, k) += work(k, k) >= 0.0 ? norm : -norm;
    const double length_sq = column_sq(V, k, k);
    v_sq[static_cast<std::size_t>(k)] = length_sq;
    if (length_sq == 0.0) break;  // the rest is zero: rank found
    for (Eigen::Index c = k; c < n; ++c) reflect(V, k, length_sq, work, c);
    if (std::abs(work(k, k)) > static_cast<double>(m) * epsilon * std::abs(work(0, 0))) qr.rank = k + 1;
    norms.leave_row(work, k);
  }
  for (Eigen::Index c = 0; c < n; ++c) {
    for (Eigen::Index r = 0; r <= c; ++r) qr.R(r, c) = work(r, c);
  }
  qr.Q = Eigen::MatrixXd::Identity(m, n);
  for (Eigen::Index k = n; k-- > 0;) {
    const double length_sq = v_sq[static_cast<std::size_t>(k)];
    if (length_sq == 0.0) continue;
    for (Eigen::Index c = k; c < n; ++c) reflect(V, k, length_sq, qr.Q, c);
  }
  return qr;
}

std::vector<double> projection(const PivotedQr& qr, const std::vector<double>& data)
{
  check(static_cast<Eigen::Index>(data.size()) == qr.Q.rows(), "one datum a row");
  std::vector<double> along;
  for (Eigen::Index k = 0; k < qr.Q.cols(); ++k)
    along.push_back(sum_of_products(qr.Q.col(k).data(), data.data(), qr.Q.rows()));
  return along;
}

std::vector<double> coefficients_of(const PivotedQr& qr, std::vector<double> along)
{
  const Eigen::Index n = qr.R.cols();
  check(qr.rank == n, "least squares of full rank only");
  check(static_cast<Eigen::Index>(along.size()) == n, "one number a column");
  std::vector<double> x(along.size(), 0.0);
  for (Eigen::Index k = n; k-- > 0;) {
    double& value = along[static_cast<std::size_t>(k)];
    for (Eigen::Index c = k + 1; c < n; ++c) value -= qr.R(k, c) * along[static_cast<std::size_t>(c)];
    value /= qr.R(k, k);
    x[static_cast<std::size_t>(qr.order[static_cast<std::size_t>(k)])] = value;
  }
  return x;
}

std::vector<double> solve(const PivotedQr& qr, const std::vector<double>& right_side)
{
  return coefficients_of(qr, projection(qr, right_side));
}

std::vector<double> leverages(const PivotedQr& qr)
{
  std::vector<double> diagonal(static_cast<std::size_t>(qr.Q.rows()), 0.0);
  for (Eigen::Index k = 0; k < qr.Q.cols(); ++k) {
    for (Eigen::Index i = 0; i < qr.Q.rows(); ++i)
      diagonal[static_cast<std::size_t>(i)] += qr.Q(i, k) * qr.Q(i, k);
  }
  return diagonal;
}

double condition_number(const PivotedQr& qr)
{
  check(qr.rank == qr.R.cols(), "a condition number of full rank only");
  const SingularRange range = singular_range(qr.R);
  return range.largest / range.smallest;
}

}  // namespace vrda
