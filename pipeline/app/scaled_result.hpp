/// What a sweep found, of a joint that is an even factor larger.
#pragma once

#include "sweep/sweep.hpp"

namespace vrda {

/// Every length, energy and moment times `factor`; angles, forces, counts and flags as they are. Contact
/// alone has no length of its own: where the poses of one joint balance the forces on it, these balance the
/// same forces on one `factor` times as large, whose point of the push moved along. Gaps are `factor` times
/// as wide.
SweepResult scaled(const SweepResult& result, double factor);

StepRecord scaled(const StepRecord& record, double factor);

}  // namespace vrda
