/// The value rules of the zero-varus motion (values.hpp).
#pragma once

#include "store/motion_model.hpp"
#include "store/value_findings.hpp"

namespace vrda {

/// Appends a finding for every broken rule. Shapes agree already.
void check_zero_varus(const ZeroVarus& motion, const MotionModel& model, ValueFindings& findings);

}  // namespace vrda
