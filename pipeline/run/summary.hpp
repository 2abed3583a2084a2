/// What a motion model says in short.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "store/motion_model.hpp"

namespace vrda {

/// Cells by the name of their status; every status that occurs.
std::map<std::string, int> cells_by_status(const MotionModel& model);

/// Share of cells that are not stable.
double unsolved_fraction(const MotionModel& model);

/// "1911 attitudes: 1900 stable, 11 no_contact".
std::string status_line(const MotionModel& model);

/// Stable cells of which something is found against the pose, in attitude order.
struct DoubtfulCell {
  double flexion_deg = 0.0, varus_deg = 0.0;
  Plausibility plausibility = Plausibility::nothing_found;
};
std::vector<DoubtfulCell> doubtful_cells(const MotionModel& model);

/// "2 nothing_ahead, 1 unstable_balance"; empty without any.
std::string plausibility_line(const MotionModel& model);

}  // namespace vrda
