/// The value rules of what pushes and holds the joint: push, contact paths, equilibrium and ligaments.
#pragma once

#include "store/motion_model.hpp"
#include "store/value_findings.hpp"

namespace vrda {

/// Adds what is wrong to `findings`. The members have the sizes of the axes; the status codes are known.
void check_mechanics(const MotionModel& model, ValueFindings& findings);

}  // namespace vrda
