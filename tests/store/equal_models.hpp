/// Motion models compared to the last bit.
#pragma once

#include "store/motion_model.hpp"

namespace vrda::test {

/// A failure for each member that differs; NaN equals NaN.
void expect_equal(const MotionModel& a, const MotionModel& b);

}  // namespace vrda::test
