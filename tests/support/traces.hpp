/// A generated trace for any motion model.
#pragma once

#include "store/trace.hpp"

namespace vrda::test {

/// Moves of each solved cell, by kind: approach, approach (in contact), bisect (blocked), bisect,
/// translate, approach (in contact), rotate, approach (in contact, a cycle). They start 3 mm below the
/// cell's pose and end at it.
inline constexpr int n_moves_of_a_cell = 8;
inline constexpr int n_touches_of_a_cell = 3;

/// One search per cell, without moves if the cell is not solved, and one unused probe, also without moves,
/// at the first flexion and the last varus.
store::Trace trace_beside(const store::MotionModel& model);

}  // namespace vrda::test
