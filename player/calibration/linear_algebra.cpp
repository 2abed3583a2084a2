#include "calibration/linear_algebra.hpp"

#include <Eigen/SVD>

namespace vrda::calibration {

// Lazy products are loops of scalar products: fast enough for these sizes, and quick to compile.

// Of a square positive semi-definite matrix the singular values are the eigenvalues. Jacobi rotations compile
// faster than the Householder reflections of the other decompositions.
PrincipalAxes principal_axes(const Eigen::MatrixXd& semi_definite)
{
  const Eigen::JacobiSVD<Eigen::MatrixXd, Eigen::NoQRPreconditioner> svd(semi_definite, Eigen::ComputeFullV);
  return {svd.singularValues(), svd.matrixV()};
}

Eigen::MatrixXd product(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B)
{
  if (A.cols() == 0) return Eigen::MatrixXd::Zero(A.rows(), B.cols());  // Eigen would offset a null pointer
  return A.lazyProduct(B);
}

Eigen::VectorXd transformed(const Eigen::MatrixXd& A, const Eigen::VectorXd& x)
{
  if (A.cols() == 0) return Eigen::VectorXd::Zero(A.rows());
  return A.lazyProduct(x);
}

Eigen::MatrixXd square(const Eigen::MatrixXd& A)
{
  return product(A, A.transpose());
}

Eigen::MatrixXd propagated(const Eigen::MatrixXd& A, const Eigen::MatrixXd& C)
{
  return product(product(A, C), A.transpose());
}

Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance)
{
  constexpr double least_share = 1e-12;  // rounding error of a correlation
  const Eigen::VectorXd sd = covariance.diagonal().cwiseSqrt();
  const Eigen::VectorXd per_sd = (sd.array() > 0.0).select(sd.cwiseInverse(), 0.0);
  const PrincipalAxes axes = principal_axes(per_sd.asDiagonal() * covariance * per_sd.asDiagonal());
  const Eigen::Index rank = (axes.values.array() > least_share).count();
  return sd.asDiagonal() * axes.vectors.leftCols(rank) * axes.values.head(rank).cwiseSqrt().asDiagonal();
}

Eigen::MatrixXd inverse_root_of(const Eigen::MatrixXd& N, const Eigen::VectorXd& scale)
{
  constexpr double least_share = 1e-13;  // rounding error of the eigenvalues of some twenty unknowns
  const PrincipalAxes axes = principal_axes(scale.asDiagonal() * N * scale.asDiagonal());
  const Eigen::Index rank = (axes.values.array() > least_share * axes.values[0]).count();
  return scale.asDiagonal() * axes.vectors.leftCols(rank) *
         axes.values.head(rank).cwiseSqrt().cwiseInverse().asDiagonal();
}

Eigen::MatrixXd inverse_root_of(const Eigen::MatrixXd& N)
{
  return inverse_root_of(N, N.diagonal().cwiseSqrt().cwiseInverse());
}

}  // namespace vrda::calibration
