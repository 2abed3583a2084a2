/// Balance of the compartments of a step: the rule of the spine by search.
#pragma once

#include "core/step_record.hpp"

namespace vrda::sweep {

/// |gap_medial - gap_lateral|; infinite if the record is not stable or a compartment has no gap.
double imbalance_mm(const StepRecord& record);

/// Whether `a` is the better spine cell: contact of both compartments first, then the smaller imbalance. If
/// both cells have contact on both sides, the one further along Delta, which is where free varus would
/// settle.
bool is_better_balanced(const StepRecord& a, const StepRecord& b);

}  // namespace vrda::sweep
