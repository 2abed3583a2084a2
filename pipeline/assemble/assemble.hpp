/// From solved steps to the motion model and its trace.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/step_record.hpp"
#include "load/case.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"
#include "sweep/sweep.hpp"

namespace vrda {

/// Everything but the smoothed surfaces, at the size of the subject (of_subject()). Cells that are not stable
/// hold NaN next to their status.
MotionModel motion_model_of(const Case& job_case, const SweepResult& result);

/// The start file's model: the plan and the meshes of the subject's size, every cell pending.
MotionModel pending_model_of(const Case& job_case);

/// Fibres and wraps as the file keeps them, without any cell.
LigamentRows ligament_rows(const Ligaments& canonical);

/// Fills those members of `model` that it has: contact_paths, equilibrium, ligaments. Poses and contacts are
/// there already.
void add_balance(MotionModel& model, const Case& job_case, const SweepResult& result);

/// `spine_column` as in SweepResult: tells the probe that became the spine's cell from the others.
Trace trace_of(const Case& job_case, const std::string& job_key,
               const std::map<StepKey, SearchTrace>& searches, const std::vector<std::int32_t>& spine_column);

}  // namespace vrda
