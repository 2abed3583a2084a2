/// Estimated parameters with their uncertainty.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/mesh.hpp"
#include "bench/rigid_body.hpp"

namespace vrda::bench {

/// In the units of files and screen: mm, deg, px. A pose has six numbers "table.shift_x" to "table.turn_z"
/// with the conventions of tracking/screw.hpp; its covariance is that of the translation and of a small
/// rotation vector about the fixed axes: true = rotation(error) * estimated, which has no singularity.
struct Estimate {
  std::vector<std::string> names;  ///< [n] "left.k1"
  std::vector<std::string> units;  ///< [n] "px"; empty: dimensionless
  Eigen::VectorXd values;          ///< [n]
  Eigen::MatrixXd covariance;      ///< [n, n]
  double dof = 0.0;  ///< degrees of freedom of the estimated noise; infinite: the noise was given
  std::vector<double> residuals;  ///< in the order of the marks
  std::string residual_unit;
  double residual_rms = 0.0;
  std::vector<std::string> remarks;  ///< one line each for the operator
};

/// "12.3 mm"
std::string text(double value, int decimals, const char* unit);

/// Throws FitError for an estimate `name`, which may be empty, of a calibration file.
struct FitErrorContext {
  std::string name, file;

  /// `field`: what follows the name.
  [[noreturn]] void fail(const std::string& field, const std::string& found, const std::string& wanted,
                         std::vector<std::size_t> marks = {}) const
  {
    throw FitError({file, name + field, found, wanted}, std::move(marks));
  }
};

/// "name.shift_x" to "name.turn_z"
std::vector<std::string> pose_number_names(const std::string& name);
/// Estimate of a pose, from the covariance of (shift_mm, turn_rad).
Estimate pose_estimate(const std::string& name, const Pose& X,
                       const Eigen::Matrix<double, 6, 6>& covariance_mm_rad);

/// Two-sided 95 % quantile of Student's t; 1.96 for infinite degrees of freedom.
double t_95(double dof);
/// Half the width of the 95 % interval of number `k`.
double half_width_95(const Estimate& estimate, Eigen::Index k);

/// Decimals for two significant digits of `size`.
int decimals_for(double size);
/// "880.2 +- 1.4 px": number `k` with its interval, of which two digits are left.
std::string interval_text(const Estimate& estimate, Eigen::Index k);

/// Appends `part` to `whole` as an independent estimate (block-diagonal covariance, same residual unit). The
/// smaller number of degrees of freedom is kept.
void append(Estimate& whole, const Estimate& part);

/// Stores `residuals` and their root mean square.
void set_residuals(Estimate& estimate, const std::vector<double>& residuals, const std::string& unit);

/// Index of the number `name`, or -1.
Eigen::Index index_of(const Estimate& estimate, const std::string& name);

}  // namespace vrda::bench
