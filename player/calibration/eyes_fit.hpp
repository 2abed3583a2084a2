/// Pose of the eyes from bull's-eyes aligned with a tracked marker (thesis 8.5), and its start value.
#pragma once

#include <array>

#include "bench/calibration_file.hpp"

namespace vrda::calibration {

/// A cross drawn for one eye at `drawn_px` coincided with the marker.
struct BullseyeMark {
  bool is_right = false;
  /// In the carrier frame: the table without the stage's displacement, or the display's body.
  Eigen::Vector3d p_carrier_mm = Eigen::Vector3d::Zero();
  /// Standard deviation of each coordinate from repeated tracker samples; reduces the weight.
  double p_sd_mm = 0.0;
  Eigen::Vector2d drawn_px = Eigen::Vector2d::Zero();
};

/// Prior of the eyes from earlier steps.
struct EyesPrior {
  view::EyePair eyes;
  Eigen::Matrix4d eyepoint_covariance =
      Eigen::Matrix4d::Zero();  ///< left distance, depth, right distance, depth
  /// Jacobian of an eye's distance and depth with respect to its distortion (EyepointFit).
  std::array<Eigen::Matrix<double, 2, 5>, 2> eyepoint_distortion_jacobian = {
      Eigen::Matrix<double, 2, 5>::Zero(), Eigen::Matrix<double, 2, 5>::Zero()};
  double ipd_sd_mm = 0.5;
  double sight_sd_px = 3.0;              ///< of both coordinates of each eye's sight_px
  double height_difference_sd_mm = 1.0;  ///< of the height difference of the eyes
  /// Covariance of k1, k2, centre_x, centre_y, pixel_aspect, left and right; empty: known exactly.
  std::array<Eigen::MatrixXd, 2> distortion_covariance;
};

struct EyesFit {
  Pose X_carrier_eyes = Pose::Identity();
  view::EyePair eyes;     ///< posterior: distances, optical axes, eyepoints, distortion
  double noise_px = 0.0;  ///< standard deviation of an alignment, from the residuals
  /// Pose `name` ("eyes" or "head"); "left.distance", "right.distance" (px), "ipd", "depth_apart" (mm: z of
  /// the left minus the right eye), "height_apart" (mm: y of left minus right), "left.sight_x",
  /// "left.sight_y", "right.sight_x", "right.sight_y" (px), then for each eye k1, k2, centre_x, centre_y,
  /// pixel_aspect.
  bench::Estimate estimate;
};

/// Least squares over marks and prior; the noise of the marks is estimated. `X_start`: within 0.5 m and 20
/// degrees. Throws FitError with `file`: fewer than 6 marks of an eye, marker positions within 50 mm of one
/// depth, one direction or one line, an outlier (6 standard deviations and 4 px; index given), no
/// convergence.
EyesFit fit_eyes(std::span<const BullseyeMark> marks, const EyesPrior& prior, const Pose& X_start,
                 const std::string& name, const std::string& file);

/// Start value of X_carrier_eyes for known eyes, without an initial guess: orthogonal iteration from the 24
/// rotations of a cube. Returns the solution with the smallest distance of the marks from their lines of
/// sight, preferably with all marks in front of the eyes; identity for fewer than three marks. Source: Lu,
/// Hager, Mjolsness (2000) IEEE PAMI 22:610-622. Differs: two eyes, which also determine depth.
Pose initial_eye_pose(std::span<const BullseyeMark> marks, const view::EyePair& eyes);

}  // namespace vrda::calibration
