/// From dials to a mark's row.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "guide/task.hpp"

namespace vrda {

/// Of a task that takes no samples, as its kind says.
std::vector<double> row_of(const Task& task, std::span<const double> values, const Calibration& calibration);

/// Of a bull's-eye: where its cross is drawn.
Eigen::Vector2d drawn_cross(const Task& task, std::span<const double> values, const Calibration& calibration);

/// Whose place is wanted beside the task's tool.
std::optional<BodyRole> body_beside(CalibrationPart part, const Task& task);

}  // namespace vrda
