/// Where both eyes are, from bull's-eyes aligned with a tracked marker (thesis 8.5), and where the fit
/// begins.
#pragma once

#include <array>
#include <span>

#include "calibration/estimate.hpp"
#include "core/mesh.hpp"
#include "optics/eye.hpp"

namespace vrda {

/// A cross was drawn for one eye at `drawn_px` and seen on the marker.
struct BullseyeMark {
  bool is_right = false;
  /// In the frame that carries the eyes: of the table less the stage's shift, or of the display's body.
  Eigen::Vector3d p_carrier_mm = Eigen::Vector3d::Zero();
  /// Standard deviation of each coordinate of it, from the tracker's repeats; weighs the mark down.
  double p_sd_mm = 0.0;
  Eigen::Vector2d drawn_px = Eigen::Vector2d::Zero();
};

/// What earlier steps know of the eyes, and how well.
struct EyesPrior {
  EyePair eyes;
  Eigen::Matrix4d eyepoint_covariance =
      Eigen::Matrix4d::Zero();  ///< left distance, depth, right distance, depth
  /// Slope of an eye's distance and depth by the numbers of its distortion: what both have in common.
  std::array<Eigen::Matrix<double, 2, 5>, 2> eyepoint_by_distortion = {Eigen::Matrix<double, 2, 5>::Zero(),
                                                                       Eigen::Matrix<double, 2, 5>::Zero()};
  double ipd_sd_mm = 0.5;
  double sight_sd_px = 3.0;         ///< of both coordinates of each eye's sight_px
  double height_apart_sd_mm = 1.0;  ///< of one eye above the other
  /// Of k1, k2, centre_x, centre_y, pixel_aspect, left and right; empty: known.
  std::array<Eigen::MatrixXd, 2> distortion_covariance;
};

struct EyesFit {
  Pose X_carrier_eyes = Pose::Identity();
  EyePair eyes;           ///< the prior's, refined: distances, sights, eyepoints, distortion
  double noise_px = 0.0;  ///< of an alignment, from the residuals
  /// Place "eyes" or "head" (`name`); "left.distance", "right.distance" (px), "ipd", "depth_apart" (mm: left
  /// eye's z less the right one's), "height_apart" (mm: left less right), "left.sight_x", "left.sight_y",
  /// "right.sight_x", "right.sight_y" (px), then for each eye k1, k2, centre_x, centre_y, pixel_aspect.
  Estimate estimate;
};

/// Least squares over all marks and what was known before, by NLopt; the marks' noise is found from what they
/// leave. `X_start`: a guess, within half a metre and 20 degrees. Throws FitRefusal naming `file`: fewer than
/// 6 marks of an eye, marker places that lie in a plane facing the eyes or on a line (they must spread by
/// 50 mm across and in depth), a mark more than 6 standard deviations and 4 px off (which: repeat), no
/// convergence.
EyesFit fit_eyes(std::span<const BullseyeMark> marks, const EyesPrior& prior, const Pose& X_start,
                 const std::string& name, const std::string& file);

/// X_carrier_eyes of eyes that are taken as known, from any attitude: orthogonal iteration from the 24
/// attitudes of a cube; the answer of the least distance of the marks from their sights, with all marks in
/// front of the eyes where there is one. Identity for fewer than three marks.
/// Source: Lu, Hager, Mjolsness (2000) IEEE PAMI 22:610-622. Differs: two eyes, so that depth is told, too.
Pose eyes_start(std::span<const BullseyeMark> marks, const EyePair& eyes);

}  // namespace vrda
