/// The smallest errors of a displayed pose that can be seen.
#pragma once

#include "core/units.hpp"

namespace vrda::inline core {

/// One arc minute from 0.5 m: 500 mm * pi / 10800 = 0.1454 mm.
inline constexpr double perceptible_mm = 0.145;
/// Rotation that moves a point 3 cm from the axis as far: 0.2778 degrees for 0.1454 mm.
inline constexpr double perceptible_rad = rad_from_deg(0.27);

}  // namespace vrda::inline core
