/// What an eye can tell apart.
#pragma once

namespace vrda {

/// One arc minute seen from 0.5 m (DESIGN.md 5.5): 500 mm * pi / 10800 = 0.1454 mm.
inline constexpr double perceptible_mm = 0.145;
/// The turn that moves a point 3 cm from the axis that far (DESIGN.md 5.5): 0.2778 degrees of 0.1454 mm.
inline constexpr double perceptible_deg = 0.27;

}  // namespace vrda
