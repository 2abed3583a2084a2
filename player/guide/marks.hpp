/// Marks of a part, what a task's rows say, and the eyes as earlier parts found them.
#pragma once

#include <span>

#include "guide/task.hpp"
#include "setup/calibration.hpp"

namespace vrda {

/// Of a record's marks that of `task`; nothing where it has none.
const CalibrationMark* mark_of(const CalibrationRecord& record, const std::string& task);

/// The first task without a mark, or as many as there are.
std::size_t next_task(const std::vector<Task>& tasks, const CalibrationRecord& record);

/// Puts `mark` where its task stands among `tasks`, in place of an earlier one.
void put_mark(CalibrationRecord& record, const std::vector<Task>& tasks, CalibrationMark mark);

/// Throws InputError naming `path` and `place`, the record's, when a mark belongs to no task, or its rows are
/// not such as the task makes.
void require_of_tasks(const CalibrationRecord& record, const std::vector<Task>& tasks,
                      const std::string& place, const std::string& path);

/// Seven numbers of a row from `at` on.
Pose sampled_pose(std::span<const double> row, std::size_t at = 0);
/// Three numbers of a row.
Eigen::Vector3d sampled_position(std::span<const double> row);

/// Puts what `part` (viewport, distortion, eyepoints or ipd) found into `eyes`.
void put_found(EyePair& eyes, CalibrationPart part, const Estimate& found);

/// Of nominal eyes and the estimates of all those parts before `part`.
EyePair eyes_before(CalibrationPart part, const BenchFile& bench, const Calibration& calibration);

/// The part's estimate. Throws InputError naming `path` where it has none.
const Estimate& estimate_of(CalibrationPart part, const Calibration& calibration, const std::string& path);

/// Block of an estimate's covariance that belongs to `names`, as whoever uses it as known has to take it: of
/// the normal distribution with the same 95 % intervals.
Eigen::MatrixXd known_covariance(const Estimate& estimate, const std::vector<std::string>& names);

double value_in(const Estimate& estimate, const std::string& name);
/// Of the six numbers "name.shift_x" to "name.turn_z".
Pose place_in(const Estimate& estimate, const std::string& name);
/// "left", "right"
const char* side_text(bool is_right);
/// Names of one eye's distortion: "left.k1", ...
std::vector<std::string> distortion_names(bool is_right);

}  // namespace vrda
