/// Small motion models and a trace, and the player's use of a model.
#pragma once

#include <vector>

#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda::test {

/// Two balls over 3 x 2 attitudes: plain, with all derived data, with free varus, and a start file.
std::vector<store::MotionModel> small_models();
store::Trace small_trace();

/// Evaluates poses of every set at, between and beyond the grid, and their derivatives. Aborts if a pose is
/// not finite.
void use_motion(const store::MotionModel& model);

/// Also places the scene with all layers at a pose of every set, and its cameras.
void use_as_player(const store::MotionModel& model);

}  // namespace vrda::test
