/// Lines that a task draws in the frame buffer.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "calibration/task.hpp"

namespace vrda::calibration {

class CalibrationSession;

struct DrawnLine {
  bool is_right = false;                   ///< window of the right eye
  std::vector<Eigen::Vector2d> points_px;  ///< frame buffer, pre-distorted; two or more
  double width_px = 1.0;
  bool is_smooth = true;  ///< anti-aliased; false: whole pixels
  std::array<float, 3> colour = {1.0F, 1.0F, 1.0F};
};

/// The parts of a line inside a box. Source: Liang, Barsky (1984) ACM Trans Graph 3:1-22.
std::vector<std::vector<Eigen::Vector2d>> pieces_within(const std::vector<Eigen::Vector2d>& line,
                                                        const view::ShownBox& box);

/// Lines of `task` with its dials at `values`. Curves have a point at least every 8 px. Empty for the kinds
/// number, sweep, bend, hold, stop, model_pose. depth_check: a frame of `test_frame_size_mm` at image
/// distance.
std::vector<DrawnLine> task_lines(const Task& task, std::span<const double> values,
                                  const Calibration& calibration);

/// Lines of the session's current task, drawn with its calibration; empty without a task.
std::vector<DrawnLine> task_lines(const CalibrationSession& session);

inline constexpr double test_frame_size_mm = 100.0;

}  // namespace vrda::calibration
