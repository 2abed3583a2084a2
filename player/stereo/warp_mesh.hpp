/// The mesh that pre-distorts an eye's picture.
#pragma once

#include <cstdint>
#include <vector>

#include "stereo/eye.hpp"

namespace vrda {

struct WarpVertex {
  float x_px = 0.0F, y_px = 0.0F;  ///< where it is drawn in the frame buffer
  float u = 0.0F, v = 0.0F;        ///< of the picture, from its top left corner, on [0, 1]
};

struct WarpMesh {
  std::vector<WarpVertex> vertices;
  std::vector<std::uint32_t> triangles;  ///< three indices of `vertices` each
};

/// Covers the eye's visible part with the picture of `box`. Linear between its nodes it is off by at most
/// `error_px`, measured in the middles of all its triangles' edges.
WarpMesh warp_mesh(const Eye& eye, const PixelBox& box, double error_px = 0.01);

/// Where the mesh shows, of the undistorted picture, at a place of the visible part: what linear drawing
/// does.
Eigen::Vector2d looked_up_px(const WarpMesh& mesh, const PixelBox& box, const Eigen::Vector2d& drawn_px);

}  // namespace vrda
