/// Motion models and a trace of some kilobytes, of every kind.
#pragma once

#include <vector>

#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda::test {

/// Two balls over 3 x 2 attitudes: plain, with all derived data, with free varus, and a start file.
std::vector<store::MotionModel> small_models();
store::Trace small_trace();

}  // namespace vrda::test
