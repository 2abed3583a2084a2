/// What the values of a trace must satisfy.
#pragma once

#include <vector>

#include "store/finding.hpp"
#include "store/trace.hpp"

namespace vrda {

/// Findings name the datasets of the file. Every shape of `trace` agrees already (as after reading).
std::vector<Finding> check_values(const Trace& trace);

/// Departures of `trace` from the model it should stand beside: job, attitudes, ends of the searches,
/// triangles. Both have been read.
std::vector<Finding> check_beside(const Trace& trace, const MotionModel& model);

}  // namespace vrda
