/// Transfer of solved steps to the cells of a motion model.
#pragma once

#include <cstdint>
#include <vector>

#include "model/step_record.hpp"
#include "store/motion_model.hpp"

namespace vrda::store {

/// The solver's frame at a flexion index of the grid; Delta may depend on flexion.
SolverFrame solver_frame(const MotionModel& model, std::int32_t flexion);

/// Sets the surfaces of the record's cell: status and counts always, the other values if it is stable. The
/// record must be at the model's scale (core's scaled()); `model` must have axes, push and surfaces.
void set_cell(MotionModel& model, const StepRecord& record);

/// `/clinical` as continuous curves (ContinuousCoordinates): over the rows at the spine's cells, from these
/// along varus. Every use of the surfaces as a curve or a range has them from here; the file keeps the
/// numbers of clinical_coordinates(), which are the same but for whole turns and gimbal lock.
struct ClinicalCurves {
  ClinicalSurfaces surfaces;
  int n_locked = 0;  ///< cells at gimbal lock or beyond
};
ClinicalCurves clinical_curves(const MotionModel& model);

/// The contacts of all cells; `cells` is in grid order.
ContactRows contact_rows(const MotionModel& model, const std::vector<StepRecord>& cells);

}  // namespace vrda::store
