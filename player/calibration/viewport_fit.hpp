/// The visible part of an eye's window, from lines scanned over it (thesis 8.1).
#pragma once

#include <array>

#include "calibration/estimate.hpp"
#include "optics/eye.hpp"

namespace vrda {

enum class Edge { left, right, top, bottom };
inline constexpr std::size_t n_edges = 4;
const char* name_of(Edge edge);

/// Repeated readings: the first column (row) of which at least half is seen, for the left (top) edge, the
/// last for the right (bottom) one; columns and rows of the frame buffer, from 0.
struct ViewportMarks {
  std::array<std::vector<double>, n_edges> line_px;
  Eigen::Vector2d screen_mm = Eigen::Vector2d::Zero();  ///< width and height of what is seen, by a ruler
  double screen_sd_mm = 0.1;                            ///< of both
};

struct ViewportFit {
  Viewport visible;  ///< whole pixels nearest to the edges
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double pixel_aspect = 1.0;     ///< height of a pixel by its width
  double pixel_aspect_sd = 0.0;  ///< of readings and ruler: what a later fit knows from before
  /// "edge_left", "edge_right", "edge_top", "edge_bottom" (px: the borders themselves), "pixel_aspect",
  /// each after `name` and a point. The noise of a reading is pooled over the four edges; without any
  /// repeated it is that of rounding. The aspect's variance is one that makes half_width_95 right with the
  /// readings' degrees of freedom, though most of it is the ruler's: less than pixel_aspect_sd squared.
  Estimate estimate;
};

/// `name`: "left". Throws FitRefusal naming `file` and the edge: no readings, crossed edges (left beyond
/// right), a part beyond the window, fewer than 16 pixels between two, a reading more than 5 px from the
/// others of its edge, a size that is none. A refusal counts marks from the left edge's readings to the
/// bottom edge's, then the screen's width and height.
ViewportFit fit_viewport(const ViewportMarks& marks, const Viewport& window, const std::string& name,
                         const std::string& file);

}  // namespace vrda
