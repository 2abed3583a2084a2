/// Tables with a header line and commas between, for whatever reads CSV (schemas/exports.md).
#pragma once

#include <string>
#include <vector>

#include "exports/flexion_motion.hpp"

namespace vrda {

/// One row a flexion: the six numbers of data/kinematics first, then the attitude, the surfaces of world W
/// and the clinical translations. mm and degrees.
std::string flexion_csv(const FlexionMotion& motion);

/// The names of its columns, in their order.
std::vector<std::string> flexion_csv_columns();

/// One row a cell of the grid, flexion-major: every number that a cell has, the smoothed ones too. Nothing
/// stands where a cell has no answer; the status goes by its name.
std::string cells_csv(const MotionModel& model);

}  // namespace vrda
