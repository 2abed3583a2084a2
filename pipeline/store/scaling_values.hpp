/// The value rules of how a joint was scaled.
#pragma once

#include "core/scaling.hpp"
#include "store/value_findings.hpp"

namespace vrda {

/// Adds what is wrong to `findings`. The columns have one entry a pair.
void check_scaling(const Scaling& scaling, ValueFindings& findings);

}  // namespace vrda
