/// The player's use of a motion model, up to drawing.
#pragma once

#include "store/motion_model.hpp"

namespace vrda::test {

/// Evaluates poses of every set at, between and beyond the grid, and their derivatives. Aborts if a pose is
/// not finite.
void use_motion(const store::MotionModel& model);

/// Also places the scene with all layers at a pose of every set, and its cameras.
void use_as_player(const store::MotionModel& model);

}  // namespace vrda::test
