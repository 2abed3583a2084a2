/// Where a perfect eye and hand bring what is drawn: the true optics on one side, what the guide draws by the
/// calibration so far on the other.
#pragma once

#include "virtual_bench/truth.hpp"

namespace vrda {

const Eye& eye_of(const EyePair& eyes, bool is_right);

/// The head with its stage `stage_mm` from the stop.
Pose X_tracker_eyes(const Calibration& calibration, double stage_mm);

/// A rectangle's side is a line along the table's Y; x and z of it on the table.
struct RectangleSides {
  double left_table_mm = 0.0, right_table_mm = 0.0, z_table_mm = 0.0;
};
/// Rectangle `index`, in front of the head with its stage at the stop.
RectangleSides rectangle_sides(const BenchFile& bench, const VirtualTruth& truth, std::size_t index);

/// Where a point of the table is seen, shown px, with the stage at its stop.
Eigen::Vector2d seen_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector3d& p_table_mm);

/// The first (left, top) or last (right, bottom) column or row of which at least half is seen, where the
/// border lies at `border_px`.
double scan_reading(double border_px, bool is_last);

/// Where a node of the physical grid has to be drawn, frame buffer.
Eigen::Vector2d drawn_node_px(const VirtualTruth& truth, bool is_right, const Eigen::Vector2d& node);

/// A vertical line is drawn through the pre-distortion of `drawing`: the line x = `value`, y as `row_px`, of
/// shown px.
struct SideLine {
  Eye drawing;
  double row_px = 0.0;  ///< the height of the sight
};
/// The value at which the eye sees the line on the side at x, z of the table, `off_px` of the frame buffer to
/// the right of it.
double side_value(const SideLine& line, const VirtualTruth& truth, bool is_right,
                  const Eigen::Vector2d& side_table_mm, double off_px);

/// The cross's place, shown px of `drawing`, at which the eye sees it on a marker that it sees at `seen_px`,
/// `off_px` of the frame buffer beside it.
Eigen::Vector2d cross_value(const Eye& drawing, const VirtualTruth& truth, bool is_right,
                            const Eigen::Vector2d& seen_px, const Eigen::Vector2d& off_px);

}  // namespace vrda
