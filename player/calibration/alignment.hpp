/// Positions at which a simulated operator sees things aligned: true optics on one side, the
/// drawing by the calibration found so far on the other.
#pragma once

#include "calibration/truth.hpp"

namespace vrda::calibration {

/// Pose of the head with its stage `stage_mm` from the stop.
Pose X_tracker_eyes(const Calibration& calibration, double stage_mm);

/// Vertical sides of a rectangle, parallel to the table's Y: x and z on the table.
struct RectangleSides {
  double left_table_mm = 0.0, right_table_mm = 0.0, z_table_mm = 0.0;
};
/// Sides of rectangle `index`, in front of the head with its stage at the stop.
RectangleSides rectangle_sides(const BenchFile& bench, const VirtualTruth& truth, std::size_t index);

/// Where a point of the table is seen with the stage at its stop; undistorted px.
Eigen::Vector2d seen_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector3d& p_table_mm);

/// The first (left, top) or last (right, bottom) column or row at least half of which is visible, for a
/// border at `border_px`.
double scan_reading(double border_px, bool is_last);

/// Position in the frame buffer at which a node of the physical grid must be drawn.
Eigen::Vector2d drawn_node_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector2d& node);

/// Vertical line x = `value` in undistorted px, drawn through the pre-distortion of `drawing`.
struct SideLine {
  view::Eye drawing;
  double row_px = 0.0;  ///< y of the principal point
};
/// The value at which the eye sees the line on the side at x, z of the table, plus an offset of `off_px` in
/// the frame buffer.
double side_value(const SideLine& line, const VirtualTruth& truth, bool is_right,
                  const Eigen::Vector2d& side_table_mm, double off_px);

/// The cross's position (undistorted px of `drawing`) at which the eye sees it on a marker seen at
/// `seen_px`, plus an offset of `off_px` in the frame buffer.
Eigen::Vector2d cross_value(const view::Eye& drawing, const VirtualTruth& truth, bool is_right,
                            const Eigen::Vector2d& seen_px, const Eigen::Vector2d& off_px);

}  // namespace vrda::calibration
