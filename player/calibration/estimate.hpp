/// Numbers that a fit found, and how far they can be trusted.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/mesh.hpp"

namespace vrda {

/// In the units of files and screens: mm, deg, px. Of a place (six names "table.shift_x" to "table.turn_z")
/// the values are those of SixNumbers (tracking/screw.hpp); its covariance is that of the shift and of
/// a small turn about the fixed axes, as a rotation vector: true = turned(error) * found, which has no angle
/// at which it fails.
struct Estimate {
  std::vector<std::string> names;  ///< [n] "left.k1"
  std::vector<std::string> units;  ///< [n] "px"; empty: a plain number
  Eigen::VectorXd values;          ///< [n]
  Eigen::MatrixXd covariance;      ///< [n, n]
  double dof = 0.0;  ///< degrees of freedom of the noise that was measured; infinite: the noise was given
  std::vector<double> residuals;  ///< what the fit leaves, in the order of the marks
  std::string residual_unit;
  double residual_rms = 0.0;
  std::vector<std::string> remarks;  ///< for the operator, a line each: "the rails are 89.95 deg apart"
};

/// "name.shift_x" to "name.turn_z"
std::vector<std::string> names_of_place(const std::string& name);
/// Of a place: names, units, values, and the covariance in mm and deg from that of (shift_mm, turn_rad).
Estimate estimate_of_place(const std::string& name, const Pose& X,
                           const Eigen::Matrix<double, 6, 6>& covariance_mm_rad);

/// Student's t, two-sided: 1.96 for infinitely many degrees of freedom.
double t_95(double dof);
/// Half the width of the 95 % interval of number `k`.
double half_width_95(const Estimate& estimate, Eigen::Index k);

/// Adds `part` behind `whole`: names, values, blocks of covariance, residuals (of one unit), remarks. The
/// degrees of freedom are the smaller ones.
void append(Estimate& whole, const Estimate& part);

/// Stores `residuals` and their root mean square.
void set_residuals(Estimate& estimate, const std::vector<double>& residuals, const std::string& unit);

/// Number `name`, or -1.
Eigen::Index index_of(const Estimate& estimate, const std::string& name);

}  // namespace vrda
