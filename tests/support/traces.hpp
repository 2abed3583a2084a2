/// A trace made by code to stand beside any motion model.
#pragma once

#include "store/trace.hpp"

namespace vrda::test {

/// Moves of each solved cell, by kind: approach, approach (in contact), bisect (blocked), bisect, translate,
/// approach (in contact), rotate, approach (in contact, a cycle). They start 3 mm beneath the cell's pose and
/// end in it.
inline constexpr int n_moves_of_a_cell = 8;
inline constexpr int n_touches_of_a_cell = 3;

/// One search a cell, without moves where the cell is not solved, and one losing probe, without moves either,
/// at the first flexion and the last varus.
Trace trace_beside(const MotionModel& model);

}  // namespace vrda::test
