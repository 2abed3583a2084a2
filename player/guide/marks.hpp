/// Marks of a part, and what a task's rows say.
#pragma once

#include <span>

#include "guide/task.hpp"

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

}  // namespace vrda
