/// What the values of a motion model must satisfy, whatever file they came from.
#pragma once

#include <string>
#include <vector>

#include "store/finding.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// Findings name the datasets of the file. Every shape of `model` agrees already (as after reading).
/// One finding a dataset and rule: the first place, and how many there are.
std::vector<Finding> check_values(const MotionModel& model);

/// Throws InputError naming `file` for the first of the findings; empty: nothing.
void require_none(const std::vector<Finding>& findings, const std::string& file);

}  // namespace vrda
