/// From the searches of a run to its trace.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/search_move.hpp"
#include "load/case.hpp"
#include "store/trace.hpp"

namespace vrda {

/// `spine_column` as in SweepResult: tells the probe that became the spine's cell from the others.
Trace trace_of(const Case& job_case, const std::string& job_key,
               const std::map<StepKey, SearchTrace>& searches, const std::vector<std::int32_t>& spine_column);

}  // namespace vrda
