/// How much a smoothed surface bends.
#pragma once

#include "store/evaluate_smoothed.hpp"

namespace vrda {

/// Root mean square of the second derivatives over the measured range: the square root of the mean over
/// flexion f and varus w of s_ff^2 + 2 s_fw^2 + s_ww^2 (a thin plate's energy, the same whichever way the two
/// axes are turned). 0 of a plane. An axis with one value adds nothing. Unit: that of the surface over a
/// degree squared, mm/degree^2. Exact: a derivative of a Legendre series is one, and these are orthogonal.
/// Source: Green, Silverman (1994), Nonparametric Regression and Generalized Linear Models, 7.4.
double roughness(const SmoothedSet& set, const SmoothedSurface& surface, const AxisRanges& ranges);

}  // namespace vrda
