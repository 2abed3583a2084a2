/// What a task shows, as lines in the frame buffer.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "guide/task.hpp"

namespace vrda {

class GuideSession;

struct GuideLine {
  bool is_right = false;                   ///< whose window it is drawn in
  std::vector<Eigen::Vector2d> points_px;  ///< of the frame buffer, pre-distorted; two or more
  double width_px = 1.0;
  bool is_smooth = true;  ///< anti-aliased; else whole pixels
  std::array<float, 3> colour = {1.0F, 1.0F, 1.0F};
};

/// Of `task` with its dials at `values`. Curved lines have a point at least every 8 px. Nothing for tasks
/// that show no lines (number, sweep, hold, stop, place); the test object of a look is for both eyes: a frame
/// of `look_size_mm` at the image distance.
std::vector<GuideLine> drawing_of(const Task& task, std::span<const double> values,
                                  const Calibration& calibration);

/// Of the session's task at hand, by what the session draws it by; nothing where there is none.
std::vector<GuideLine> drawing_of(const GuideSession& session);

inline constexpr double look_size_mm = 100.0;

}  // namespace vrda
