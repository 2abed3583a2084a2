/// What the values of a motion model or trace must satisfy, whatever file they came from.
#pragma once

#include <string>
#include <vector>

#include "store/finding.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda {

/// Findings name the datasets of the file. Every shape agrees already (as after reading).
/// One finding a dataset and rule: the first place, and how many there are.
std::vector<Finding> check_values(const MotionModel& model);
std::vector<Finding> check_values(const Trace& trace);

/// Departures of `trace` from the model it belongs to: job, attitudes, ends of the searches, triangles. Both
/// have been read.
std::vector<Finding> check_beside(const Trace& trace, const MotionModel& model);

/// Throws InputError naming `file` for the first of the findings; empty: nothing.
void require_none(const std::vector<Finding>& findings, const std::string& file);

}  // namespace vrda
