/// Motion of a knee for tests of functional registration.
#pragma once

#include "calibration/functional_fit.hpp"

namespace vrda::test {

/// A knee that rolls back by 12 mm, turns inwards by 15 degrees and tilts by 3 while it bends by 90.
calibration::JointCurve knee_curve();

}  // namespace vrda::test
