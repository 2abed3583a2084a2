/// Radial distortion of the optics from the nodes of a physical grid (thesis 8.2).
#pragma once

#include "bench/calibration_file.hpp"

namespace vrda::calibration {

/// A cross drawn at `drawn_px` coincided with a node of a grid perpendicular to the optical axis.
struct GridMark {
  Eigen::Vector2d node = Eigen::Vector2d::Zero();  ///< columns right and rows up from the grid centre
  Eigen::Vector2d drawn_px = Eigen::Vector2d::Zero();
};

/// Nodes of a grid, row by row from the lowest.
std::vector<Eigen::Vector2d> grid_nodes(int columns, int rows);

/// Image of a grid: a node appears at origin_px + spacing_px * R(turn) node; y down, heights in pixel widths.
struct GridPose {
  Eigen::Vector2d origin_px = Eigen::Vector2d::Zero();
  double spacing_px = 0.0;
  double turn_rad = 0.0;  ///< counter-clockwise
};
Eigen::Vector2d shown_px(const GridPose& grid, double pixel_aspect, const Eigen::Vector2d& node);

struct AspectPrior {
  double value = 1.0, sd = 0.0;
};

/// The eight parameters of an adjusted or fitted grid: k1, k2, centre x, y of the distortion, then position
/// x, y, spacing and turn (rad) of the grid.
using GridValues = Eigen::Matrix<double, 8, 1>;
/// Of the first and the last four.
view::Distortion distortion_of(const view::Eye& eye, const Eigen::Vector4d& values, double aspect);
GridPose grid_of(const Eigen::Vector4d& values);

/// Grids of columns x rows nodes that an operator adjusted to cover the physical grid.
struct AdjustedGrids {
  std::vector<GridValues> values;
  int columns = 0, rows = 0;
};

struct DistortionFit {
  view::Distortion distortion;
  GridPose grid;
  double noise_px = 0.0;  ///< standard deviation of a coordinate of a mark; of a node for adjusted grids
  /// The distortion is too small to determine its centre (standard deviation above 20 px), so the centre has
  /// the prior `centre_prior_sd_px` about the centre of the visible part.
  bool has_centre_prior = false;
  /// Largest position error in the visible part after pre-distortion mesh (view/eye.hpp) and optics.
  double inverse_error_px = 0.0;
  /// "NAME.k1", ".k2", ".centre_x", ".centre_y" (px), ".pixel_aspect".
  bench::Estimate estimate;
};

inline constexpr double centre_prior_sd_px = 5.0;

/// Least squares with the prior `aspect`. `eye` gives window and visible part; unit_px is half the window
/// width. Throws FitError with `file` and `name`: fewer than 12 marks, collinear marks, an outlier (6
/// standard deviations and 3 px; index given), no convergence, a fold within the visible part.
DistortionFit fit_distortion(std::span<const GridMark> marks, const view::Eye& eye, const AspectPrior& aspect,
                             const std::string& name, const std::string& file);

/// Mean of two or more adjusted grids. The shape of the covariance is that of a fit to marks at all nodes;
/// its size is from the spread of the grids, with 8 (n - 1) dof. An aspect error is common to all.
DistortionFit mean_distortion(const AdjustedGrids& adjusted, const view::Eye& eye, const AspectPrior& aspect,
                              const std::string& name, const std::string& file);

}  // namespace vrda::calibration
