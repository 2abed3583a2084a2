#include "model/linear_algebra.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace vrda::inline model {

EigenSystem12 eigen_system(const Eigen::Matrix<double, 12, 12>& symmetric)
{
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric)
{
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric).eigenvalues();
}

Eigen::MatrixXd inverse_of_definite(const Eigen::MatrixXd& matrix)
{
  return matrix.ldlt().solve(Eigen::MatrixXd::Identity(matrix.rows(), matrix.cols()));
}

Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix)
{
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

Eigen::Isometry3d nearest_transform(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to)
{
  return Eigen::Isometry3d(Eigen::umeyama(from, to, false));
}

}  // namespace vrda::inline model
