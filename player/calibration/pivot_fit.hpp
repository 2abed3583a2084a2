/// The tip of a probe, from turning it about its resting tip.
#pragma once

#include <span>

#include "calibration/estimate.hpp"
#include "core/mesh.hpp"

namespace vrda {

struct PivotFit {
  Eigen::Vector3d tip_probe_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d pivot_tracker_mm = Eigen::Vector3d::Zero();
  double spread_rad = 0.0;  ///< of the turns about the worst determined axis, root mean square
  Estimate estimate;        ///< "probe.tip_x" to "probe.tip_z" (mm); residuals: lengths, mm
};

/// Least squares of R_i tip + t_i = pivot. Throws FitRefusal naming `file`: fewer than 20 poses, a spread
/// below 10 degrees (a static sweep, or turns about one axis only), a residual rms above 2 mm (the tip
/// slipped).
PivotFit fit_pivot(std::span<const Pose> X_tracker_probe, const std::string& file);

}  // namespace vrda
