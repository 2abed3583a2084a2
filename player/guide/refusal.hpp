/// Which marks a refusal doubts.
#pragma once

#include "core/error.hpp"
#include "guide/tasks.hpp"

namespace vrda {

/// Tasks that a fit's error names, to be done again; where it names none, all of `round`.
std::vector<std::size_t> doubted_marks(const InputError& error, CalibrationPart part,
                                       const std::vector<Task>& tasks, const TaskRound& round);

/// Scans of an eye that cannot all be right, after the one of task `done`: of its edge and the one opposite,
/// where they are crossed.
std::vector<std::size_t> crossed_edges(const std::vector<Task>& tasks, const CalibrationRecord& record,
                                       std::size_t done);
/// "crossed edges of the left eye: left and right"
std::string crossed_text(const Task& task);

/// For the screen: what was found and what is wanted, without the file's name.
std::string words_of(const InputError& error);

}  // namespace vrda
