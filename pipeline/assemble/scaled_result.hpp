/// What a sweep found, of a joint that is an even factor larger.
#pragma once

#include "sweep/sweep.hpp"

namespace vrda {

/// Each record scaled() (core/step_record.hpp), and what lies between them along. Contact alone has no length
/// of its own: where the poses of one joint balance the forces on it, these balance the same forces on one
/// `factor` times as large, whose point of the push moved along. Gaps are `factor` times as wide.
SweepResult scaled(const SweepResult& result, double factor);

}  // namespace vrda
