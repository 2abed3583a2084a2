#include "smooth/least_squares.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/error.hpp"

namespace vrda {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
/// One-sided Jacobi converges quadratically; matrices of 231 columns took fewer than 15 sweeps.
constexpr int most_sweeps = 60;

/// Sum over rows [from, rows) of the product of two columns: in four sums, added in an order of our own,
/// since one sum waits for itself and a library's order depends on the processor.
double column_product(const Eigen::MatrixXd& A, Eigen::Index a, const Eigen::MatrixXd& B, Eigen::Index b,
                      Eigen::Index from)
{
  const Eigen::Index n = A.rows() - from;
  const double* x = A.data() + a * A.rows() + from;
  const double* y = B.data() + b * B.rows() + from;
  std::array<double, 4> sum{};
  Eigen::Index i = 0;
  for (; i + 4 <= n; i += 4) {
    for (Eigen::Index k = 0; k < 4; ++k) sum[static_cast<std::size_t>(k)] += x[i + k] * y[i + k];
  }
  for (; i < n; ++i) sum[0] += x[i] * y[i];
  return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

/// Column of [from, end) with the largest remaining norm, the first one among equals.
Eigen::Index pivot(const Eigen::MatrixXd& A, Eigen::Index from)
{
  Eigen::Index best = from;
  double best_sq = -1.0;
  for (Eigen::Index k = from; k < A.cols(); ++k) {
    const double norm_sq = column_product(A, k, A, k, from);
    if (norm_sq > best_sq) {
      best_sq = norm_sq;
      best = k;
    }
  }
  return best;
}

/// Applies I - 2 v v^T / (v^T v), v in column `k` of V below row k, to column `c` of A.
void reflect(const Eigen::MatrixXd& V, Eigen::Index k, double v_sq, Eigen::MatrixXd& A, Eigen::Index c)
{
  const double scale = 2.0 * column_product(V, k, A, c, k) / v_sq;
  for (Eigen::Index i = k; i < A.rows(); ++i) A(i, c) -= scale * V(i, k);
}

/// Turns columns p and q of A so that they become orthogonal; true if they were not before.
bool orthogonalise(Eigen::MatrixXd& A, Eigen::Index p, Eigen::Index q)
{
  const double app = column_product(A, p, A, p, 0);
  const double aqq = column_product(A, q, A, q, 0);
  const double apq = column_product(A, p, A, q, 0);
  if (std::abs(apq) <= epsilon * std::sqrt(app * aqq)) return false;
  const double zeta = (aqq - app) / (2.0 * apq);
  const double t = (zeta >= 0.0 ? 1.0 : -1.0) / (std::abs(zeta) + std::sqrt(1.0 + zeta * zeta));
  const double c = 1.0 / std::sqrt(1.0 + t * t);
  const double s = c * t;
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const double a = A(i, p), b = A(i, q);
    A(i, p) = c * a - s * b;
    A(i, q) = s * a + c * b;
  }
  return true;
}

}  // namespace

PivotedQr pivoted_qr(const Eigen::MatrixXd& A)
{
  const Eigen::Index m = A.rows(), n = A.cols();
  check(m >= n && n > 0, "least squares needs a column, and as many rows as columns");
  Eigen::MatrixXd work = A;
  Eigen::MatrixXd V = Eigen::MatrixXd::Zero(m, n);
  std::vector<double> v_sq(static_cast<std::size_t>(n), 0.0);
  PivotedQr qr;
  qr.R = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k) qr.order.push_back(k);
  for (Eigen::Index k = 0; k < n; ++k) {
    const Eigen::Index chosen = pivot(work, k);
    work.col(k).swap(work.col(chosen));
    std::swap(qr.order[static_cast<std::size_t>(k)], qr.order[static_cast<std::size_t>(chosen)]);
    const double norm = std::sqrt(column_product(work, k, work, k, k));
    for (Eigen::Index i = k; i < m; ++i) V(i, k) = work(i, k);
    // Away from zero, so that no digits cancel.
    V(k, k) += work(k, k) >= 0.0 ? norm : -norm;
    const double length_sq = column_product(V, k, V, k, k);
    v_sq[static_cast<std::size_t>(k)] = length_sq;
    if (length_sq == 0.0) break;  // the rest is zero: rank found
    for (Eigen::Index c = k; c < n; ++c) reflect(V, k, length_sq, work, c);
    if (std::abs(work(k, k)) > static_cast<double>(m) * epsilon * std::abs(work(0, 0))) qr.rank = k + 1;
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

std::vector<double> solve(const PivotedQr& qr, const std::vector<double>& right_side)
{
  const Eigen::Index n = qr.R.cols();
  check(qr.rank == n, "least squares of full rank only");
  check(static_cast<Eigen::Index>(right_side.size()) == qr.Q.rows(), "one datum a row");
  std::vector<double> x(static_cast<std::size_t>(n), 0.0);
  std::vector<double> y(static_cast<std::size_t>(n), 0.0);
  for (Eigen::Index k = n; k-- > 0;) {
    double sum = 0.0;
    for (Eigen::Index i = 0; i < qr.Q.rows(); ++i)
      sum += qr.Q(i, k) * right_side[static_cast<std::size_t>(i)];
    for (Eigen::Index c = k + 1; c < n; ++c) sum -= qr.R(k, c) * y[static_cast<std::size_t>(c)];
    y[static_cast<std::size_t>(k)] = sum / qr.R(k, k);
    x[static_cast<std::size_t>(qr.order[static_cast<std::size_t>(k)])] = y[static_cast<std::size_t>(k)];
  }
  return x;
}

std::vector<double> leverages(const PivotedQr& qr)
{
  std::vector<double> diagonal(static_cast<std::size_t>(qr.Q.rows()), 0.0);
  for (Eigen::Index i = 0; i < qr.Q.rows(); ++i) {
    double sum = 0.0;
    for (Eigen::Index k = 0; k < qr.Q.cols(); ++k) sum += qr.Q(i, k) * qr.Q(i, k);
    diagonal[static_cast<std::size_t>(i)] = sum;
  }
  return diagonal;
}

double condition_number(const PivotedQr& qr)
{
  const Eigen::Index n = qr.R.cols();
  check(qr.rank == n, "a condition number of full rank only");
  // The columns of R^T converge faster: R is graded by the pivoting.
  Eigen::MatrixXd A = qr.R.transpose();
  bool is_done = false;
  for (int sweep = 0; sweep < most_sweeps && !is_done; ++sweep) {
    is_done = true;
    for (Eigen::Index p = 0; p < n; ++p) {
      for (Eigen::Index q = p + 1; q < n; ++q) {
        if (orthogonalise(A, p, q)) is_done = false;
      }
    }
  }
  double largest_sq = 0.0, smallest_sq = std::numeric_limits<double>::infinity();
  for (Eigen::Index k = 0; k < n; ++k) {
    const double norm_sq = column_product(A, k, A, k, 0);
    largest_sq = std::max(largest_sq, norm_sq);
    smallest_sq = std::min(smallest_sq, norm_sq);
  }
  return std::sqrt(largest_sq / smallest_sq);
}

}  // namespace vrda
