/// From solved steps to the cells of a motion model.
#pragma once

#include <cstdint>
#include <vector>

#include "core/step_record.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// The frame of the solver at a flexion of the grid: Delta may differ from one to the next.
SolverFrame solver_frame(const MotionModel& model, std::int32_t flexion);

/// Fills in the surfaces of the record's cell, at the size of the model (core's scaled()). Its status and
/// counts always; the rest of a stable one only. `model` has axes and push, and surfaces of their size.
void set_cell(MotionModel& model, const StepRecord& record);

/// The contacts of all cells, given in the order of the grid.
ContactRows contact_rows(const MotionModel& model, const std::vector<StepRecord>& cells);

}  // namespace vrda
