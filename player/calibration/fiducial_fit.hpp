/// Where a model is on a body, from points of it touched with a probe (thesis 8.5: M_FK), and its size.
#pragma once

#include <span>

#include "calibration/estimate.hpp"
#include "core/mesh.hpp"

namespace vrda {

struct LandmarkDistance {
  std::string name;
  double model_mm = 0.0, subject_mm = 0.0;
};

struct ScaleFit {
  double scale = 1.0;
  /// The distances ask for different scales: more than 5 % apart, and by more than the 2 mm (residuals' rms)
  /// that finding landmarks through skin leaves anyway. No known noise of them could decide it by a test.
  bool is_uneven = false;
  Estimate estimate;  ///< "subject.scale"; residuals: subject's less scaled model's, mm
};

/// Least squares through the origin. Throws FitRefusal naming `file`: fewer than three distances, one that is
/// not above 0, a scale outside 0.5 to 2.
ScaleFit fit_scale(std::span<const LandmarkDistance> distances, const std::string& file);

struct Fiducial {
  std::string name;
  Eigen::Vector3d p_model_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d p_body_mm = Eigen::Vector3d::Zero();  ///< as touched
  bool is_target = false;  ///< held out: it takes no part in the fit and tells the error at places like it
};

struct FiducialFit {
  Pose X_body_model = Pose::Identity();
  double fiducial_rms_mm = 0.0;         ///< what the fit leaves: says nothing about targets
  double target_rms_mm = 0.0;           ///< at the points held out; 0 without any
  double expected_target_rms_mm = 0.0;  ///< of the same, by the noise that the fit found
  double leave_one_out_rms_mm = 0.0;    ///< each fiducial by a fit to the others
  /// Place `name`; residuals: length left at each fiducial, then at each target, mm.
  Estimate estimate;
};

struct FiducialOptions {
  /// Else the points may all be too far from each other by one factor: what that leaves is not taken for
  /// noise.
  bool is_size_known = true;
};

/// Closed form (Umeyama, proper rotations, no scale). Throws FitRefusal naming `file` and the point: fewer
/// than four fiducials, collinear ones (second singular value below 5 mm), coplanar ones (third below 5 mm: a
/// mirrored leg would fit as well, so nothing would show a wrong side; says to add one off the plane), a set
/// that fits its mirror image as well as itself (to a factor of 1.5) or better (the other side), a point more
/// than 5 standard deviations and 5 mm off (which: touch it again).
FiducialFit fit_fiducials(std::span<const Fiducial> points, const std::string& name, const std::string& file,
                          const FiducialOptions& options = {});

/// The mean of places that an operator adjusted (six numbers each, two or more attitudes), and its covariance
/// by their spread; residuals: distances of their shifts from the mean, mm. Throws FitRefusal: fewer than
/// two.
FiducialFit mean_place(std::span<const Pose> adjusted, const std::string& name, const std::string& file);

}  // namespace vrda
