/// Conversions at the border: inside there are only mm, rad, N.
#pragma once

namespace vrda {

inline constexpr double pi = 3.14159265358979323846;

constexpr double rad_from_deg(double angle_deg)
{
  return angle_deg * (pi / 180.0);
}
constexpr double deg_from_rad(double angle_rad)
{
  return angle_rad * (180.0 / pi);
}

}  // namespace vrda
