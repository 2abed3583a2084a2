/// Motion models and a trace of some kilobytes, of every kind.
#pragma once

#include <vector>

#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda::test {

/// Two balls, moved over 3 x 2 attitudes; with all that a run can add; one with free varus; a start file.
std::vector<MotionModel> small_models();
Trace small_trace();

}  // namespace vrda::test
