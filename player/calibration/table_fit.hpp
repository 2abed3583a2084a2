/// Pivot calibration of a probe, and the table frame from marker sweeps along two rails (thesis 8.5).
#pragma once

#include <span>

#include "bench/calibration_file.hpp"
#include "model/mesh.hpp"

namespace vrda::calibration {

struct PivotFit {
  Eigen::Vector3d tip_probe_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d pivot_tracker_mm = Eigen::Vector3d::Zero();
  double spread_rad = 0.0;   ///< rms rotation about the axis with the least rotation
  bench::Estimate estimate;  ///< "probe.tip_x" to "probe.tip_z" (mm); residuals: lengths, mm
};

/// Least squares of R_i tip + t_i = pivot. Throws FitError with `file`: fewer than 20 poses, a spread below
/// 10 degrees (no rotation, or about one axis only), a residual rms above 2 mm (the tip slipped).
PivotFit fit_pivot(std::span<const Pose> X_tracker_probe, const std::string& file);

/// Marker positions along a rail.
struct RailSweep {
  std::vector<Eigen::Vector3d> p_tracker_mm;
  std::vector<double> stage_mm;  ///< encoder value of each position; empty: unknown
};

struct TableFit {
  /// X along the first rail (viewer's right), Z along the second (towards the viewer), orthogonalised to X;
  /// Y = Z x X (up). Origin: the point of the first rail nearest to the second.
  Pose X_tracker_table = Pose::Identity();
  double rails_angle_rad = 0.0, rails_angle_sd_rad = 0.0;
  double stage_scale = 0.0;  ///< marker displacement per encoder displacement; 0: unknown
  /// "table.shift_x" (mm) to "table.turn_z" (deg); residuals: distances of the positions from their rail, mm.
  /// The noise is pooled over both rails.
  bench::Estimate estimate;
};

/// Rails in the order of the marks.
enum class Rail { x, z };

/// Checks one sweep as fit_table() does, including the encoder on the x rail. Throws FitError with `file`
/// and the rail.
void require_valid_rail(const RailSweep& sweep, Rail rail, const std::string& file);

/// `x_rail`: swept from left to right, `z_rail`: towards the viewer. Directions by total least squares.
/// Throws FitError with `file`: fewer than 10 positions, a sweep shorter than 50 mm or not straight (rms
/// above 2 mm), rails less than 45 degrees apart, an encoder with the wrong sign or a scale error above 2 %
/// (bench file's stage_mm_per_count), an outlier (6 standard deviations and 1 mm).
TableFit fit_table(const RailSweep& x_rail, const RailSweep& z_rail, const std::string& file);

}  // namespace vrda::calibration
