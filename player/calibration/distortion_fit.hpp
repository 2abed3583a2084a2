/// The optics' distortion, from the nodes of a physical grid (thesis 8.2).
#pragma once

#include <span>
#include <vector>

#include "calibration/estimate.hpp"
#include "optics/eye.hpp"

namespace vrda {

/// A cross was drawn at `drawn_px` and seen on a node of a grid that stands perpendicular to the sight.
struct GridMark {
  Eigen::Vector2d node = Eigen::Vector2d::Zero();  ///< columns to the right, rows upwards, from the middle
  Eigen::Vector2d drawn_px = Eigen::Vector2d::Zero();
};

/// Where a node is shown: at_px + spacing_px * R(turn) node, heights in widths of a pixel, y downwards.
struct GridPlace {
  Eigen::Vector2d at_px = Eigen::Vector2d::Zero();
  double spacing_px = 0.0;
  double turn_rad = 0.0;  ///< counter-clockwise
};
Eigen::Vector2d shown_px(const GridPlace& grid, double pixel_aspect, const Eigen::Vector2d& node);

struct AspectPrior {
  double value = 1.0, sd = 0.0;
};

/// The eight numbers of an adjusted grid, and of what a fit finds, in this order.
struct GridValues {
  double k1 = 0.0, k2 = 0.0;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  GridPlace grid;
};

/// Grids that an operator adjusted until they covered the physical one, of so many nodes.
struct AdjustedGrids {
  std::vector<GridValues> values;
  int columns = 0, rows = 0;
};

struct DistortionFit {
  Distortion distortion;
  GridPlace grid;
  double noise_px = 0.0;  ///< of a coordinate of a mark; of adjusted grids, of one at every node
  /// Too little distortion to tell where its centre is (a standard deviation above 20 px): it is held by
  /// the middle of the visible part, from which it is known to differ by `held_centre_sd_px`.
  bool is_centre_held = false;
  /// The mesh that pre-distorts (optics/eye.hpp) and these optics one after the other: how far at most
  /// they put a place of the visible part from itself.
  double inverse_error_px = 0.0;
  /// "k1", "k2", "centre_x", "centre_y" (px), "pixel_aspect", each after `name` and a point.
  Estimate estimate;
};

inline constexpr double held_centre_sd_px = 5.0;

/// By NLopt; the aspect is known from before to `aspect`, and better afterwards. `eye` gives window and
/// visible part; unit_px is half the window's width. Throws FitRefusal naming `file` and `name`: fewer than
/// 12 marks, marks on a line, a mark more than 6 standard deviations and 3 px off (which: repeat it), no
/// convergence, a distortion that folds within the visible part.
DistortionFit fit_distortion(std::span<const GridMark> marks, const Eye& eye, const AspectPrior& aspect,
                             const std::string& name, const std::string& file);

/// The same from grids that were adjusted, at least two of them: their mean. They are taken to scatter as
/// fits to marks of all their nodes do, which gives the covariance its shape; their spread gives its size,
/// with eight degrees of freedom for each grid but one. An aspect that is off turns up in all of them alike.
DistortionFit mean_distortion(const AdjustedGrids& adjusted, const Eye& eye, const AspectPrior& aspect,
                              const std::string& name, const std::string& file);

}  // namespace vrda
