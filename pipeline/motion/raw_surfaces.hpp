/// The raw cells of a motion model as four continuous surfaces: x, y, z, theta over (flexion, varus).
#pragma once

#include <array>

#include "motion/hermite_grid.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// x, y, z of the moving object in world W (mm), and theta (rad, right-knee sign).
using PoseNumbers = std::array<double, 4>;
/// The same, then the varus it stands at (rad).
using PoseAndVarus = std::array<double, 5>;

using RawNode = HermiteNode<4>;
using RawSurfaces = HermiteGrid<4>;
using RawSample = HermiteSample<4>;

RawSurfaces raw_surfaces(const MotionModel& model);

}  // namespace vrda
