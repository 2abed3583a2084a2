/// What a motion model says in short.
#pragma once

#include <map>
#include <string>

#include "store/motion_model.hpp"

namespace vrda {

/// Cells by the name of their status; every status that occurs.
std::map<std::string, int> cells_by_status(const MotionModel& model);

/// Share of cells that are not stable.
double unsolved_fraction(const MotionModel& model);

/// "1911 attitudes: 1900 stable, 11 no_contact".
std::string status_line(const MotionModel& model);

}  // namespace vrda
