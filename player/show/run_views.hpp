/// Tiled views of one joint.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "view/job_views.hpp"
#include "view/renderer.hpp"
#include "view/camera.hpp"

namespace vrda::show {

using view::CameraView;

/// Divides `area` into `n` tiles, row by row, as large as possible at an aspect near 4:3.
std::vector<view::Viewport> tiles(std::size_t n, const view::Viewport& area);

/// One camera per tile, fitted to the points, with the field of view divided by `zoom`.
std::vector<view::Shot> fitted_shots(const std::vector<CameraView>& views,
                                       const std::vector<view::Viewport>& areas,
                                       const std::vector<Eigen::Vector3d>& points_world_mm, double zoom);

}  // namespace vrda::show
