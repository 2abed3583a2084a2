#include "analysis/least_squares.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <limits>

#include "core/error.hpp"

namespace vrda::analysis {
namespace {

using Decomposition = Eigen::ColPivHouseholderQR<Eigen::MatrixXd>;

/// householderQ() * Identity, one reflection at a time: Eigen applies 48 or more in blocks, whose products
/// depend on the cache sizes.
Eigen::MatrixXd thin_q(const Decomposition& decomposition)
{
  const Eigen::Index m = decomposition.rows(), n = decomposition.cols();
  Eigen::MatrixXd Q = Eigen::MatrixXd::Identity(m, n);
  Eigen::VectorXd workspace(n);
  for (Eigen::Index k = n; k-- > 0;) {
    Q.bottomRightCorner(m - k, n - k)
        .applyHouseholderOnTheLeft(decomposition.matrixQR().col(k).tail(m - k - 1),
                                   decomposition.hCoeffs()(k), workspace.data());
  }
  return Q;
}

}  // namespace

PivotedQr pivoted_qr(const Eigen::MatrixXd& A)
{
  const Eigen::Index m = A.rows(), n = A.cols();
  check(m >= n && n > 0, "least squares needs a column, and at least as many rows as columns");
  Decomposition decomposition(A);
  decomposition.setThreshold(static_cast<double>(m) * std::numeric_limits<double>::epsilon());
  return {thin_q(decomposition), decomposition.matrixR().topRows(n).triangularView<Eigen::Upper>(),
          decomposition.colsPermutation().indices(), decomposition.rank()};
}

Eigen::VectorXd coefficients_of(const PivotedQr& qr, const Eigen::VectorXd& along)
{
  check(qr.rank == qr.R.cols(), "the rank is full");
  check(along.size() == qr.R.cols(), "one value per column");
  const Eigen::VectorXd x = qr.R.triangularView<Eigen::Upper>().solve(along);
  return Eigen::PermutationMatrix<Eigen::Dynamic>(qr.order) * x;
}

Eigen::VectorXd solve(const PivotedQr& qr, const Eigen::VectorXd& data)
{
  check(data.size() == qr.Q.rows(), "one datum per row");
  return coefficients_of(qr, qr.Q.transpose() * data);
}

Eigen::VectorXd leverages(const PivotedQr& qr)
{
  return qr.Q.rowwise().squaredNorm();
}

double condition_number(const PivotedQr& qr)
{
  check(qr.rank == qr.R.cols(), "the rank is full");
  const Eigen::VectorXd singular_values = Eigen::JacobiSVD<Eigen::MatrixXd>(qr.R).singularValues();
  return singular_values(0) / singular_values(singular_values.size() - 1);
}

}  // namespace vrda::analysis
