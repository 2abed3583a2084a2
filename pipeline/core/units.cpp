#include "core/units.hpp"

#include <algorithm>
#include <cmath>

namespace vrda::inline core {

std::vector<double> radians(const std::vector<double>& angles_deg)
{
  std::vector<double> angles_rad;
  for (const double angle_deg : angles_deg) angles_rad.push_back(rad_from_deg(angle_deg));
  return angles_rad;
}

std::vector<double> degrees(const std::vector<double>& angles_rad)
{
  std::vector<double> angles_deg;
  for (const double angle_rad : angles_rad) angles_deg.push_back(deg_from_rad(angle_rad));
  return angles_deg;
}
namespace {

// pi/2 in three parts of 33 bits each (fdlibm e_rem_pio2.c): k * part is exact for |k| < 2^20.
constexpr double half_pi_1 = 1.57079632673412561417e+00;
constexpr double half_pi_2 = 6.07710050630396597660e-11;
constexpr double half_pi_3 = 2.02226624879595063154e-21;

double sin_kernel(double x)
{
  const double z = x * x;
  const double p = 8.33333333332248946124e-03 +
                   z * (-1.98412698298579493134e-04 +
                        z * (2.75573137070700676789e-06 +
                             z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10)));
  return x + z * x * (-1.66666666666666324348e-01 + z * p);
}

double cos_kernel(double x)
{
  const double z = x * x;
  const double p = 4.16666666666666019037e-02 +
                   z * (-1.38888888888741095749e-03 +
                        z * (2.48015872894767294178e-05 +
                             z * (-2.75573143513906633035e-07 +
                                  z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))));
  const double half = 0.5 * z;
  const double w = 1.0 - half;
  return w + (((1.0 - w) - half) + z * z * p);
}

// arc tangent of x in [0, tan(pi/8)]: the polynomial of s_atan.c, valid on [0, 7/16].
double atan_kernel(double x)
{
  const double z = x * x;
  const double w = z * z;
  const double s1 = z * (3.33333333333329318027e-01 +
                         w * (1.42857142725034663711e-01 +
                              w * (9.09088713343650656196e-02 +
                                   w * (6.66107313738753120669e-02 +
                                        w * (4.97687799461593236017e-02 + w * 1.62858201153657823623e-02)))));
  const double s2 = w * (-1.99999999998764832476e-01 +
                         w * (-1.11111104054623557880e-01 +
                              w * (-7.69187620504482999495e-02 +
                                   w * (-5.83357013379057348645e-02 + w * -3.65315727442169155270e-02))));
  return x - x * (s1 + s2);
}

// arc tangent of y / x for 0 <= y <= x, x > 0.
double atan_first_octant(double y, double x)
{
  const double ratio = y / x;
  // The polynomial is valid up to 7/16 (fdlibm); above it, reduce by pi/4.
  if (ratio <= 0.4375) return atan_kernel(ratio);
  return pi / 4.0 + (y >= x ? 0.0 : -atan_kernel((x - y) / (x + y)));
}

}  // namespace

SinCos sin_cos(double angle_rad)
{
  const double turns = std::nearbyint(angle_rad * (2.0 / pi));
  const double reduced = ((angle_rad - turns * half_pi_1) - turns * half_pi_2) - turns * half_pi_3;
  const double s = sin_kernel(reduced);
  const double c = cos_kernel(reduced);
  constexpr double most_turns = 9e18;  // of a long long; NaN and larger angles have no quadrant
  const int quadrant = std::abs(turns) < most_turns ? static_cast<int>(static_cast<long long>(turns) & 3) : 0;
  switch (quadrant) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

double sine(double angle_rad)
{
  return sin_cos(angle_rad).sin;
}
double cosine(double angle_rad)
{
  return sin_cos(angle_rad).cos;
}

double arc_tangent2(double y, double x)
{
  const double ax = std::abs(x);
  const double ay = std::abs(y);
  if (ax == 0.0 && ay == 0.0) return 0.0;
  const double octant = ay <= ax ? atan_first_octant(ay, ax) : pi / 2.0 - atan_first_octant(ax, ay);
  const double half_plane = std::signbit(x) ? pi - octant : octant;
  return std::signbit(y) && half_plane != pi ? -half_plane : half_plane;
}

double arc_sine(double x)
{
  const double clamped = std::clamp(x, -1.0, 1.0);
  return arc_tangent2(clamped, std::sqrt((1.0 - clamped) * (1.0 + clamped)));
}

double arc_cosine(double x)
{
  const double clamped = std::clamp(x, -1.0, 1.0);
  return arc_tangent2(std::sqrt((1.0 - clamped) * (1.0 + clamped)), clamped);
}

}  // namespace vrda::inline core
