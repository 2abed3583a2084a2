/// Visible part of an eye's window from scanned lines (thesis 8.1).
#pragma once

#include <array>

#include "bench/estimate.hpp"
#include "view/eye.hpp"

namespace vrda::calibration {

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

/// bench::Estimate of the edges and of a pixel's height divided by its width: "NAME.edge_left", ".edge_right",
/// ".edge_top", ".edge_bottom" (px), ".pixel_aspect". The noise of a reading is pooled over the four edges;
/// without repeats it is the rounding. The aspect's variance is scaled so that half_width_95 is correct with
/// the dof of the readings.
/// `name`: "left" or "right". Throws FitError with `file` and the edge: no readings, crossed edges, an edge
/// outside the window, opposite edges less than 16 px apart, a reading more than 5 px from the others of its
/// edge, an invalid size. Mark indices count the readings from the left to the bottom edge, then screen width
/// and height.
bench::Estimate fit_viewport(const ViewportMarks& marks, const view::Viewport& window, const std::string& name,
                      const std::string& file);

}  // namespace vrda::calibration
