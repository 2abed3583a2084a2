/// What the commands that work on a finished motion model begin with.
#pragma once

#include <string>

#include "store/motion_model.hpp"

namespace vrda {

/// Reads a motion model with at least one stable attitude. Throws InputError of a file that is none, is
/// damaged or newer than this version, and of one whose every attitude failed or is pending.
MotionModel read_solved_model(const std::string& file);

/// `asked`, or one a processor where that is 0.
int threads_or_all(int asked);

}  // namespace vrda
