/// Pose of a model on a body from points touched with a probe (thesis 8.5: M_FK), and scale of the model.
#pragma once

#include <span>

#include "bench/calibration_file.hpp"
#include "model/mesh.hpp"

namespace vrda::calibration {

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
