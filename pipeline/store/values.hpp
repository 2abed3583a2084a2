/// Checks of the values of motion models and traces.
#pragma once

#include <string>
#include <vector>

#include "store/dataset.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda::store {

/// Findings name the datasets of the file, one finding per dataset and rule, with the first wrong entry and
/// the number of wrong entries. All shapes must be consistent, as after reading.
std::vector<Finding> check_values(const MotionModel& model);
std::vector<Finding> check_values(const Trace& trace);

/// Differences between `trace` and its model: job, attitudes, final poses, triangles. Both must be valid.
std::vector<Finding> compare_trace(const Trace& trace, const MotionModel& model);

/// Throws InputError naming `file` for the first finding; does nothing without findings.
void require_no_findings(const std::vector<Finding>& findings, const std::string& file);

}  // namespace vrda::store
