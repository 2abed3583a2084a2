/// From solved steps to the motion model and its trace.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "model/step_record.hpp"
#include "job/case.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"
#include "store/uncertain_motion.hpp"
#include "solve/sweep.hpp"

namespace vrda::solve {

/// The model without smoothed surfaces, at the subject's size (of_subject()). Cells that are not stable
/// contain NaN and their status.
store::MotionModel motion_model_of(const job::Case& job_case, const solve::SweepResult& result);

/// The model of the start file: plan and meshes at the subject's size, every cell pending.
store::MotionModel pending_model_of(const job::Case& job_case);

/// Fibres and wraps in the layout of the file, without cells.
store::LigamentRows ligament_rows(const model::Ligaments& canonical);

/// Fills contact_paths, equilibrium and ligaments of `model` where present. Poses and contacts must be
/// filled.
void add_balance(store::MotionModel& model, const job::Case& job_case, const solve::SweepResult& result);

/// `spine_column` as in SweepResult: identifies the probes that became spine cells.
store::Trace trace_of(const job::Case& job_case, const std::string& job_key,
                      const std::map<StepKey, SearchTrace>& searches,
                      const std::vector<std::int32_t>& spine_column);

/// Bands and shares of the spread from the solved samples of an uncertain job. `records`: of kind
/// StepKind::sample, one for each flexion and sample, in any order. Clinical coordinates are about the
/// rotation centre of the job, also where the samples' centres differ.
store::UncertainMotion uncertain_motion_of(const job::Case& job_case,
                                           const std::vector<StepRecord>& records);

}  // namespace vrda::solve
