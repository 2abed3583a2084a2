/// Fits to positions of the tracker: the tip of a probe, the table's rails, touched points of a model, the
/// scale of a subject (thesis 8.5).
#pragma once

#include "bench/calibration_file.hpp"

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

// Touched points of a model, and the subject's scale.

struct LandmarkDistance {
  std::string name;
  double model_mm = 0.0, subject_mm = 0.0;
};

struct ScaleFit {
  double scale = 1.0;
  /// The distances require different scales: more than 5 % apart, with a residual rms above 2 mm, the
  /// accuracy of landmarks palpated through skin. The noise is unknown, so there is no statistical test.
  bool is_nonuniform = false;
  bench::Estimate estimate;  ///< "subject.scale"; residuals: subject minus scaled model, mm
};

/// Least squares through the origin. Throws FitError with `file`: fewer than three distances, a distance
/// not above 0, a scale outside 0.5 to 2.
ScaleFit fit_scale(std::span<const LandmarkDistance> distances, const std::string& file);

struct Fiducial {
  std::string name;
  Eigen::Vector3d p_model_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_body_mm = Eigen::Vector3d::Zero();  ///< as touched
  bool is_target = false;  ///< excluded from the fit; measures the target registration error
};

struct FiducialFit {
  Pose X_body_model = Pose::Identity();
  double fiducial_rms_mm = 0.0;         ///< fiducial registration error (does not predict the target error)
  double target_rms_mm = 0.0;           ///< target registration error at the targets; 0 without targets
  double expected_target_rms_mm = 0.0;  ///< expected target registration error for the estimated noise
  double leave_one_out_rms_mm = 0.0;    ///< error of each fiducial in a fit to the others
  /// Pose `name`; residuals: lengths at each fiducial, then at each target, mm.
  bench::Estimate estimate;
};

struct FiducialOptions {
  /// If false, residuals explained by a common scale of the points do not count as noise.
  bool is_size_known = true;
};

/// Closed form (Umeyama, proper rotation, no scale). Throws FitError with `file` and the point: fewer than
/// four fiducials, collinear (second singular value below 5 mm) or coplanar ones (third below 5 mm: a
/// mirrored leg would fit as well), a mirror image that fits as well (within a factor of 1.5) or better, an
/// outlier (5 standard deviations and 5 mm; index given).
FiducialFit fit_fiducials(std::span<const Fiducial> points, const std::string& name, const std::string& file,
                          const FiducialOptions& options = {});

/// Mean of two or more poses adjusted by an operator, with the covariance from their spread; residuals:
/// distances of the translations from the mean, mm. Throws FitError: fewer than two.
FiducialFit mean_adjusted_pose(std::span<const Pose> adjusted, const std::string& name,
                               const std::string& file);

}  // namespace vrda::calibration
