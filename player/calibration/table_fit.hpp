/// The tip of a probe, from turning it about its resting tip, and the table's frame, from a marker's sweeps
/// along two rails (thesis 8.5, figure 25).
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

/// The table's frame, from a marker's sweeps along two rails (thesis 8.5, figure 25).
struct RailSweep {
  std::vector<Eigen::Vector3d> p_tracker_mm;
  std::vector<double> stage_mm;  ///< what the encoder said, one a place; empty: not known
};

struct TableFit {
  /// X along the first rail, Z along the second, made square to X; Y = Z x X, up when X goes to the viewer's
  /// right and Z towards the viewer. Origin: the point of the first rail nearest to the second.
  Pose X_tracker_table = Pose::Identity();
  double rails_apart_rad = 0.0, rails_apart_sd_rad = 0.0;
  double stage_scale = 0.0;  ///< way of the marker by that of the encoder; 0: not known
  /// "table.shift_x" (mm) to "table.turn_z" (deg); residuals: distances of the places from their rail, mm.
  /// The noise is pooled over both rails.
  Estimate estimate;
};

/// The marks of a table, in order.
enum class Rail { x, z };

/// What fit_table() wants of one sweep alone, and of the encoder's way along the x rail. Throws FitRefusal
/// naming `file` and the rail.
void require_rail(const RailSweep& sweep, Rail rail, const std::string& file);

/// `x_rail` swept from left to right, `z_rail` towards the viewer. Directions by total least squares.
/// Throws FitRefusal naming `file`: fewer than 10 places, a sweep shorter than 50 mm, one that is no line
/// (rms above 2 mm), rails less than 45 degrees apart, an encoder that counts the other way or differs by
/// more than 2 % (bench file's stage_mm_per_count), a place more than 6 standard deviations and 1 mm off.
TableFit fit_table(const RailSweep& x_rail, const RailSweep& z_rail, const std::string& file);

}  // namespace vrda
