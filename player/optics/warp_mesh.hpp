/// The mesh that pre-distorts an eye's picture.
#pragma once

#include "optics/eye.hpp"

namespace vrda {

/// Covers the eye's visible part with the picture of `box`. Linear between its nodes it is off by at most
/// `error_px`, measured in the middles of all its triangles' edges, or by what the finest mesh (512 cells
/// across) leaves: of optics far stronger than a display's some hundredths of a pixel.
WarpMesh warp_mesh(const Eye& eye, const ShownBox& box, double error_px = 0.01);

/// Where the mesh shows, of the undistorted picture, at a place of the visible part: what linear drawing
/// does.
Eigen::Vector2d looked_up_px(const WarpMesh& mesh, const ShownBox& box, const Eigen::Vector2d& drawn_px);

}  // namespace vrda
