/// What the player does with a motion model up to drawing it.
#pragma once

#include "store/motion_model.hpp"

namespace vrda::test {

/// Poses of every set at, between and beyond the attitudes of the grid, and their derivatives. Ends the
/// program where a pose is not a number.
void use_motion(const MotionModel& model);

/// Then the scene with all of its layers placed at a pose of every set, and cameras that see it.
void use_as_player(const MotionModel& model);

}  // namespace vrda::test
