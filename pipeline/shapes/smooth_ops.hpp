/// Blending of level-set fields (negative inside, about the signed distance in mm).
#pragma once

#include <algorithm>
#include <cmath>

namespace vrda {

/// Union with a fillet: equals the smaller value where the two differ by more than `width_mm`, and lies
/// at most width_mm / 6 below it where they agree. Twice continuously differentiable.
inline double smooth_min(double a, double b, double width_mm)
{
  const double h = std::max(width_mm - std::abs(a - b), 0.0) / width_mm;
  return std::min(a, b) - h * h * h * width_mm / 6.0;
}

/// Intersection with a rounded edge; the mirror image of smooth_min.
inline double smooth_max(double a, double b, double width_mm)
{
  return -smooth_min(-a, -b, width_mm);
}

/// 0 below `from`, 1 above `to`, quintic between: twice continuously differentiable.
inline double smooth_step(double from, double to, double x)
{
  const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
  return t * t * t * (t * (6.0 * t - 15.0) + 10.0);
}

}  // namespace vrda
