/// From the solved samples of an uncertain job to bands and shares of the spread.
#pragma once

#include <vector>

#include "core/step_record.hpp"
#include "load/case.hpp"
#include "store/uncertain_motion.hpp"

namespace vrda::model_build {

/// `records`: of kind StepKind::sample, one for each flexion and sample, in any order. Clinical coordinates
/// are about the rotation centre of the job, also where the samples' centres differ.
store::UncertainMotion uncertain_motion_of(const load::Case& job_case, const std::vector<StepRecord>& records);

}  // namespace vrda::model_build
