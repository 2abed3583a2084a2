/// What the layout of a motion model's file depends on.
#pragma once

#include "store/layout.hpp"
#include "store/motion_model.hpp"

namespace vrda {

/// Of the newest version. Throws InternalError where the model's members do not agree with each other.
FileShape shape_of(const MotionModel& model);

}  // namespace vrda
