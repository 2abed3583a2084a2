#include "igtl/rotation.hpp"

#include <Eigen/LU>
#include <cmath>

namespace vrda {

std::optional<Eigen::Matrix3d> nearest_rotation(const Eigen::Matrix3d& matrix)
{
  const Eigen::Matrix3d error = matrix.transpose() * matrix - Eigen::Matrix3d::Identity();
  // allFinite first: a maximum may pass over NaN.
  if (!error.allFinite() || error.cwiseAbs().maxCoeff() > most_rotation_error) return std::nullopt;
  if (matrix.determinant() <= 0.0) return std::nullopt;
  // Newton's iteration to the orthogonal factor squares the error each time: 1e-3, 1e-6, 1e-12, rounding.
  Eigen::Matrix3d R = matrix;
  for (int n = 0; n < 3; ++n) {
    const Eigen::Matrix3d inverse = R.inverse();
    R = 0.5 * (R + inverse.transpose()).eval();
  }
  return R;
}

std::optional<Eigen::Quaterniond> unit_quaternion(const Eigen::Vector4d& wxyz)
{
  const double length_sq = wxyz.squaredNorm();
  if (!(std::abs(length_sq - 1.0) <= most_rotation_error)) return std::nullopt;
  const Eigen::Vector4d unit = wxyz / std::sqrt(length_sq);
  return Eigen::Quaterniond(unit(0), unit(1), unit(2), unit(3));
}

}  // namespace vrda
