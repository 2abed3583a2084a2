/// Checks of readings before they become marks: not touched, implausible, at the place of another one. The
/// texts are for the screen and say what to do; empty: nothing to object.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "calibration/marks.hpp"
#include "calibration/task.hpp"

namespace vrda::calibration {

/// `touched`: whether each dial was changed since the task began. Both lines of a rectangle must be.
std::string untouched_text(const Task& task, const std::vector<bool>& touched);

/// A value outside the plausible range of its dial.
std::string implausible_text(const Task& task, std::span<const double> values);

/// Samples of a touched point or a marker position that are where those of another one were, within 1 mm: the
/// tool was not moved.
std::string same_place_text(const std::vector<Task>& tasks, const CalibrationRecord& record, const Task& task,
                            const CalibrationMark& mark);

/// Why the readings of a part, which agree with each other, must be measured again: its estimate, or
/// readings of `tasks` that were confirmed although implausible, are far from what the tasks start from.
std::string unexpected_text(const std::vector<Task>& tasks, const CalibrationRecord& record,
                            const bench::Estimate& estimate, const Calibration& nominal);

}  // namespace vrda::calibration
