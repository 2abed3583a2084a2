/// Field of view and eyepoint from rectangles of known widths at known depths (thesis 8.3, figure 24), and
/// the inter-pupillary distance (8.4).
#pragma once

#include "bench/calibration_file.hpp"

namespace vrda::calibration {

/// Two lines, drawn with pre-distortion, coincided with the sides of a rectangle.
struct RectangleMark {
  double width_mm = 0.0;
  double depth_mm = 0.0;                                    ///< behind the reference plane, away from the eye
  Eigen::Vector2d left_drawn_px = Eigen::Vector2d::Zero();  ///< a drawn point of each line
  Eigen::Vector2d right_drawn_px = Eigen::Vector2d::Zero();
};

/// X_i = d L_i / (E + Z_i): d distance in px, E distance of the eye from the reference plane.
struct Eyepoint {
  double distance_px = 0.0, depth_mm = 0.0;
};
struct EyepointOptions {
  /// Standard deviation of the optical axis direction about the table's Z. It changes the apparent width of
  /// off-centre rectangles, and the marks of this step do not determine it.
  double alignment_sd_rad = 0.0;
  /// Covariance of k1, k2, centre_x, centre_y, pixel_aspect (DistortionFit); empty: known exactly.
  Eigen::MatrixXd distortion_covariance;
  double max_depth_sd_mm = 15.0;  ///< a larger standard deviation is an error
};

struct EyepointFit {
  Eyepoint eyepoint;
  double noise_px = 0.0;  ///< standard deviation of a side, from the residuals
  /// Jacobian of distance and depth with respect to k1, k2, centre_x, centre_y, pixel_aspect; zero if those
  /// are known. It gives the covariance of eyepoint and distortion.
  Eigen::Matrix<double, 2, 5> distortion_jacobian = Eigen::Matrix<double, 2, 5>::Zero();
  /// "NAME.distance" (px), "NAME.depth" (mm); the covariance includes marks, alignment and distortion.
  bench::Estimate estimate;
};

/// Weighted least squares over all rectangles. `eye`: distortion, aspect, optical axis. Throws FitError
/// with `file` and `name`: fewer than three marks, equal depths, a depth range too small for
/// `max_depth_sd_mm` (with a rectangle to add), crossed or equal sides, an outlier (5 standard deviations,
/// more for few marks, and 3 px; index given).
EyepointFit fit_eyepoint(std::span<const RectangleMark> marks, const view::Eye& eye,
                         const EyepointOptions& options, const std::string& name, const std::string& file);

/// Expected standard deviations of distance (px) and depth (mm) for a set of rectangles, before measuring,
/// with noise `noise_px` a side.
Eigen::Vector2d expected_eyepoint_sd(std::span<const RectangleMark> rectangles, const Eyepoint& about,
                                     double noise_px);

/// Marks and fit of one eye.
struct EyeRectangles {
  std::vector<RectangleMark> marks;
  view::Eye eye;  ///< with distortion
  EyepointFit fit;
};

struct PupilDistance {
  double ipd_mm = 0.0, sd_mm = 0.0;
};
/// Inter-pupillary distance from the same rectangles marked in the same order with both eyes. `sight_sd_px`:
/// standard deviation of each optical axis. The 95 % interval is 1.96 sd_mm (noise, eyepoints and axes).
PupilDistance pupil_distance(const EyeRectangles& left, const EyeRectangles& right, double sight_sd_px);

/// Error (mm, positive: behind) of the perceived depth of an object at `depth_mm`, drawn for eyes
/// `drawn_ipd_mm` apart and seen by eyes `true_ipd_mm` apart.
double depth_error_mm(double depth_mm, double drawn_ipd_mm, double true_ipd_mm);

// Visible part of an eye's window from scanned lines (thesis 8.1).

enum class Edge { left, right, top, bottom };
inline constexpr std::size_t n_edges = 4;
const char* name_of(Edge edge);

/// Repeated readings of each edge: the first (left, top) or last (right, bottom) column or row of the frame
/// buffer, counted from 0, of which at least half is visible.
struct ViewportMarks {
  std::array<std::vector<double>, n_edges> line_px;
  Eigen::Vector2d screen_mm = Eigen::Vector2d::Zero();  ///< width and height of the visible part, by a ruler
  double screen_sd_mm = 0.1;                            ///< of both
};

/// Estimate of the edges and of a pixel's height divided by its width: "NAME.edge_left", ".edge_right",
/// ".edge_top", ".edge_bottom" (px), ".pixel_aspect". The noise of a reading is pooled over the four edges;
/// without repeats it is the rounding. The aspect's variance is scaled so that half_width_95 is correct with
/// the dof of the readings.
/// `name`: "left" or "right". Throws FitError with `file` and the edge: no readings, crossed edges, an edge
/// outside the window, opposite edges less than 16 px apart, a reading more than 5 px from the others of its
/// edge, an invalid size. Mark indices count the readings from the left to the bottom edge, then screen width
/// and height.
bench::Estimate fit_viewport(const ViewportMarks& marks, const view::Viewport& window,
                             const std::string& name, const std::string& file);

}  // namespace vrda::calibration
