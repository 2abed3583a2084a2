/// Field of view and eyepoint, from rectangles of known widths at known depths (thesis 8.3, figure 24), and
/// the distance between the eyes (8.4).
#pragma once

#include <span>

#include "calibration/estimate.hpp"
#include "optics/eye.hpp"

namespace vrda {

/// Two lines were drawn through the pre-distortion and seen on the sides of a rectangle.
struct RectangleMark {
  double width_mm = 0.0;
  double depth_mm = 0.0;                                    ///< behind the reference plane, away from the eye
  Eigen::Vector2d left_drawn_px = Eigen::Vector2d::Zero();  ///< a point of each line, as drawn
  Eigen::Vector2d right_drawn_px = Eigen::Vector2d::Zero();
};

/// X_i = d L_i / (E + Z_i): d in px, E the eye's distance from the reference plane.
struct Eyepoint {
  double distance_px = 0.0, depth_mm = 0.0;
};
/// Closed form of two rectangles; figure 24's last line prints X1 for X2.
Eyepoint eyepoint_of_two(const RectangleMark& first, double first_px, const RectangleMark& second,
                         double second_px);

struct EyepointOptions {
  /// Standard deviation of the sight's direction about the table's Z: off-centre rectangles look narrower by
  /// it, which no mark of this step shows.
  double alignment_sd_rad = 0.0;
  /// Of k1, k2, centre_x, centre_y, pixel_aspect of the eye, as DistortionFit has them; empty: known.
  Eigen::MatrixXd distortion_covariance;
  double most_depth_sd_mm = 15.0;  ///< more is refused
};

struct EyepointFit {
  Eyepoint eyepoint;
  double noise_px = 0.0;  ///< of a side, from the residuals
  /// Slope of distance and depth by k1, k2, centre_x, centre_y, pixel_aspect; zero where those are known.
  /// With it the errors of both are told to go together.
  Eigen::Matrix<double, 2, 5> by_distortion = Eigen::Matrix<double, 2, 5>::Zero();
  /// "distance" (px), "depth" (mm), each after `name` and a point. Noise of the marks, alignment and
  /// distortion together.
  Estimate estimate;
};

/// Weighted least squares over all rectangles. `eye`: distortion, aspect, sight. Throws FitRefusal naming
/// `file` and `name`: fewer than three marks, equal depths or a spread too small for `most_depth_sd_mm` (with
/// what to add), sides crossed or equal, a mark more than 5 standard deviations (more of few marks) and 3 px
/// from where the others put it (which: repeat).
EyepointFit fit_eyepoint(std::span<const RectangleMark> marks, const Eye& eye, const EyepointOptions& options,
                         const std::string& name, const std::string& file);

/// What is to be expected of rectangles before anybody aligns them: standard deviations of distance (px) and
/// depth (mm), for noise of `noise_px` a side.
Eigen::Vector2d expected_eyepoint_sd(std::span<const RectangleMark> rectangles, const Eyepoint& about,
                                     double noise_px);

/// What was marked with one eye, and found of it.
struct EyeRectangles {
  std::vector<RectangleMark> marks;
  Eye eye;  ///< with distortion
  EyepointFit fit;
};

struct PupilDistance {
  double ipd_mm = 0.0, sd_mm = 0.0;
};
/// The distance between the eyes: both marked the same rectangles in the same order, and the sight of each is
/// known to `sight_sd_px`. sd in mm, from noise, eyepoints and sights: 1.96 of it are the 95 % interval.
PupilDistance pupil_distance(const EyeRectangles& left, const EyeRectangles& right, double sight_sd_px);

/// How far behind its place (mm) something at `depth_mm` is perceived, drawn for eyes `drawn_ipd_mm` apart
/// and seen by eyes `true_ipd_mm` apart.
double depth_error_mm(double depth_mm, double drawn_ipd_mm, double true_ipd_mm);

}  // namespace vrda
