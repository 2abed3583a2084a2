/// Unit conversions for input and output; internal units are mm, rad, s, N.
#pragma once

#include <limits>

namespace vrda::inline core {

inline constexpr double pi = 3.14159265358979323846;
inline constexpr double metres_per_mm = 1e-3;
inline constexpr double s_per_ns = 1e-9, ms_per_ns = 1e-6;
/// Marks a missing number.
inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

constexpr double rad_from_deg(double angle_deg)
{
  return angle_deg * (pi / 180.0);
}
constexpr double deg_from_rad(double angle_rad)
{
  return angle_rad * (180.0 / pi);
}

}  // namespace vrda::inline core
