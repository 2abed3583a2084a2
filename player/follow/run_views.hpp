/// Tiled views of one joint.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "navigation/job_views.hpp"
#include "render/renderer.hpp"
#include "scene/camera.hpp"

namespace vrda::follow {

using navigation::CameraView;

/// Divides `area` into `n` tiles, row by row, as large as possible at an aspect near 4:3.
std::vector<optics::Viewport> tiles(std::size_t n, const optics::Viewport& area);

/// One camera per tile, fitted to the points, with the field of view divided by `zoom`.
std::vector<render::Shot> fitted_shots(const std::vector<CameraView>& views,
                                       const std::vector<optics::Viewport>& areas,
                                       const std::vector<Eigen::Vector3d>& points_world_mm, double zoom);

}  // namespace vrda::follow
