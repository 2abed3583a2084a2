/// The five coordinates of the equilibrium, in the solver frame S (core/frames.hpp): translation of the
/// moving object (mm), its rotation about Delta = +Y, and the varus of the attitude (rad). Energies are in
/// N mm, so gradients hold forces in N and moments in N mm; second derivatives are in N/mm, N and N mm.
#pragma once

#include <Eigen/Core>

#include "model/frames.hpp"

namespace vrda::inline model {

enum Coordinate : Eigen::Index { along_x = 0, along_y = 1, along_z = 2, about_y = 3, about_varus = 4 };
inline constexpr Eigen::Index n_coordinates = 5;

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

/// Derivative of the position of the moving object's point `p_mm` (S) relative to the reference: one column a
/// coordinate. Varus rotates the reference by -X about the origin of S, which is equivalent to rotating the
/// moving object by +X.
inline Eigen::Matrix<double, 3, 5> point_jacobian(const Eigen::Vector3d& p_mm, const MovingPose& pose)
{
  Eigen::Matrix<double, 3, 5> J;
  J.leftCols<3>().setIdentity();
  J.col(about_y) = Eigen::Vector3d::UnitY().cross(p_mm - pose.translation_mm);
  J.col(about_varus) = Eigen::Vector3d::UnitX().cross(p_mm);
  return J;
}

/// An energy as a function of the coordinates, with its derivatives.
struct Potential {
  double energy_nmm = 0.0;
  Vector5d gradient = Vector5d::Zero();
  Matrix5d hessian = Matrix5d::Zero();  ///< symmetric
};

}  // namespace vrda::inline model
