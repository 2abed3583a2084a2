/// Decompositions of Eigen, which are slow to compile: once here, not in each file that needs one.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace vrda::inline model {

/// cross_matrix(v) * w = v x w.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v)
{
  Eigen::Matrix3d W;
  W << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return W;
}

/// Eigenvalues, ascending, and unit eigenvectors (columns) of a symmetric matrix.
struct EigenSystem12 {
  Eigen::Matrix<double, 12, 1> values;
  Eigen::Matrix<double, 12, 12> vectors;
};
EigenSystem12 eigen_system(const Eigen::Matrix<double, 12, 12>& symmetric);

/// Ascending.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric);

/// Of a symmetric positive definite matrix.
Eigen::MatrixXd inverse_of_definite(const Eigen::MatrixXd& matrix);

/// U V^T of the singular value decomposition: the rotation nearest to a matrix that does not mirror.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& matrix);

/// The rigid transform that brings `from` nearest to `to`, column by column. Source: Umeyama (1991) IEEE
/// PAMI 13:376-380, without scale.
Eigen::Isometry3d nearest_transform(const Eigen::Matrix3Xd& from, const Eigen::Matrix3Xd& to);

}  // namespace vrda::inline model
