/// Reduces a motion over flexion and varus to one over flexion alone: both condyles bearing (DESIGN.md 5.5).
/// schemas/clinical.md writes every rule and formula out.
#pragma once

#include <string>

#include "store/motion_model.hpp"

namespace vrda {

/// Whether the question has a meaning: the joint has compartments, or varus was free.
bool is_reducible(const MotionModel& model);

/// The flexion-only motion: varus from the raw cells, poses there from the set named, one of
/// set_names(model). Poses of "raw" are linear between the two columns around, or the cell's own; contact
/// points are those of the raw cells whatever the set. The model must be reducible; flexions without an
/// answer have source none, possibly all.
ZeroVarus reduce(const MotionModel& model, const std::string& set);

/// Flexions with a pose.
int n_reduced(const ZeroVarus& zero_varus);

}  // namespace vrda
