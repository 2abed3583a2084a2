/// The raw cells of a motion model as four continuous surfaces: x, y, z, theta over (flexion, varus).
#pragma once

#include <array>
#include <vector>

#include "core/frames.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// x, y, z of the moving object in world W (mm), and theta (rad, right-knee sign).
using PoseNumbers = std::array<double, 4>;

/// One cell with its slopes; all zero where the cell is not solved.
struct RawNode {
  PoseNumbers value{};       ///< mm, rad
  PoseNumbers by_flexion{};  ///< derivative by flexion, a radian
  PoseNumbers by_varus{};    ///< derivative by varus, a radian
  PoseNumbers by_both{};     ///< mixed derivative, a radian squared
  bool is_solved = false;
};

struct RawSurfaces {
  std::vector<double> flexion_rad;  ///< [n_flexion] ascending
  std::vector<double> varus_rad;    ///< [n_varus] ascending
  std::vector<RawNode> nodes;       ///< [n_flexion * n_varus], varus runs fastest
};

/// Slopes at each node come from the parabola through it and its solved neighbours: central where both
/// stand, one-sided beside a hole or an end, the chord where only one is left.
RawSurfaces raw_surfaces(const MotionModel& model);

struct RawSample {
  PoseNumbers numbers{};
  bool is_solved = false;  ///< false where a corner of the patch is unsolved; numbers mean nothing then
};

/// Bicubic Hermite interpolation; `attitude` must lie within the axes. Allocates nothing.
RawSample sample(const RawSurfaces& surfaces, const Attitude& attitude);

}  // namespace vrda
