/// Exact comparison of motion models.
#pragma once

#include "store/motion_model.hpp"

namespace vrda::test {

/// A failure for each member that differs; NaN equals NaN.
void expect_equal(const store::MotionModel& a, const store::MotionModel& b);

}  // namespace vrda::test
