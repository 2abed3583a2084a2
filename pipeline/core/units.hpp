/// Unit conversions for input and output, internal units are mm, rad, s, N; and the smallest visible errors.
#pragma once

#include <limits>
#include <vector>

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

/// Of each angle.
std::vector<double> radians(const std::vector<double>& angles_deg);
std::vector<double> degrees(const std::vector<double>& angles_rad);

/// The smallest error of a displayed pose that can be seen: one arc minute from 0.5 m: 500 mm * pi / 10800 =
/// 0.1454 mm.
inline constexpr double perceptible_mm = 0.145;
/// Rotation that moves a point 3 cm from the axis as far: 0.2778 degrees for 0.1454 mm.
inline constexpr double perceptible_rad = rad_from_deg(0.27);

// Sine, cosine and arc functions with the same bits on every x86-64 processor. The C library selects
// variants with fused multiply-adds by processor, so no room may call std::sin or similar functions
// (core/README.md). Error below one unit in the last place for |x| < 1e5 rad.
// Source: polynomials of fdlibm (Sun Microsystems, 1993), k_sin.c, k_cos.c, s_atan.c.

struct SinCos {
  double sin = 0.0;
  double cos = 1.0;
};

SinCos sin_cos(double angle_rad);
double sine(double angle_rad);
double cosine(double angle_rad);
/// Angle of the point (x, y) in (-pi, pi]; 0 for the origin.
double arc_tangent2(double y, double x);
/// Arguments outside [-1, 1] are clamped.
double arc_sine(double x);
double arc_cosine(double x);

}  // namespace vrda::inline core
