/// What the player does with a motion model up to drawing it.
#pragma once

#include "store/motion_model.hpp"

namespace vrda::test {

/// Poses of every set at, between and beyond the attitudes of the grid, their derivatives, the scene placed
/// at them with all of its layers, and cameras that see it. Ends the program where a pose is not a number.
void use_as_player(const MotionModel& model);

}  // namespace vrda::test
