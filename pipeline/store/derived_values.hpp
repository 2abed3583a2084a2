/// The value rules of what is made of the raw surfaces (values.hpp).
#pragma once

#include "store/motion_model.hpp"
#include "store/value_findings.hpp"

namespace vrda {

/// Appends a finding for every broken rule of the smoothed sets, the zero-varus motion and the audits.
void check_derived(const MotionModel& model, ValueFindings& findings);

}  // namespace vrda
