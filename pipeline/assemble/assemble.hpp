/// From solved steps to the motion model.
#pragma once

#include "load/case.hpp"
#include "store/motion_model.hpp"
#include "sweep/sweep.hpp"

namespace vrda {

/// Everything but the smoothed surfaces, at the size of the subject (of_subject()). Cells that are not stable
/// hold NaN next to their status.
MotionModel motion_model_of(const Case& job_case, const SweepResult& result);

/// The start file's model: the plan and the meshes of the subject's size, every cell pending.
MotionModel pending_model_of(const Case& job_case);

}  // namespace vrda
