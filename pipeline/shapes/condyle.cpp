#include "shapes/condyle.hpp"

#include <algorithm>
#include <cmath>

#include "core/trig.hpp"

namespace vrda {
namespace {

struct Spiral {
  double value = 0.0;  // q(a)
  double slope = 0.0;  // q'(a)
};

Spiral spiral(double angle_rad, double end_rad)
{
  const double e2 = end_rad * end_rad;
  const double amplitude = 24.0 / (e2 * e2);
  if (angle_rad >= end_rad) {
    const SinCos beyond = sin_cos(angle_rad - end_rad);
    return {amplitude * beyond.cos, -amplitude * beyond.sin};
  }
  const double u = 1.0 - angle_rad / end_rad;
  return {u * u * u * u - 12.0 / e2 * u * u + amplitude, -(4.0 * u * u * u - 24.0 / e2 * u) / end_rad};
}

}  // namespace

Support support(const Condyle& condyle, double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  const Spiral q = spiral(angle_rad, condyle.spiral_end_rad);
  const Eigen::Vector2d& shift = condyle.shift_mm;
  return {condyle.posterior_radius_mm + condyle.extra_radius_mm * q.value -
              (shift.x() * a.sin + shift.y() * a.cos),
          condyle.extra_radius_mm * q.slope - (shift.x() * a.cos - shift.y() * a.sin)};
}

double radius_mm(const Condyle& condyle, double angle_rad)
{
  const double u = std::max(0.0, 1.0 - angle_rad / condyle.spiral_end_rad);
  return condyle.posterior_radius_mm + condyle.extra_radius_mm * u * u * u * u;
}

Eigen::Vector3d ball_centre_mm(const Condyle& condyle, double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  const Support p = support(condyle, angle_rad);
  const double reach_mm = p.value_mm - condyle.coronal_radius_mm;
  return {-reach_mm * a.sin - p.slope_mm * a.cos, -reach_mm * a.cos + p.slope_mm * a.sin, condyle.z_mm};
}

double signed_distance_mm(const Condyle& condyle, const Eigen::Vector3d& p_femur_mm)
{
  const Eigen::Vector2d q = p_femur_mm.head<2>();
  double low = condyle.first_rad, high = condyle.last_rad;
  // Newton inside a shrinking bracket. The lead's slope is -(height above the curve + radius of the curve).
  double angle_rad = 0.5 * (low + high);
  constexpr int most_steps = 40;
  constexpr double resolution_rad = 1e-13;  // 1e-11 mm along the curve
  for (int step = 0; step < most_steps && high - low > resolution_rad; ++step) {
    const SinCos a = sin_cos(angle_rad);
    const Support p = support(condyle, angle_rad);
    const double lead = -a.cos * q.x() + a.sin * q.y() - p.slope_mm;
    (lead > 0.0 ? low : high) = angle_rad;
    const double slope = a.sin * q.x() + a.cos * q.y() + p.value_mm - radius_mm(condyle, angle_rad);
    const double next = angle_rad - lead / slope;
    const bool is_inside = slope < 0.0 && next > low && next < high;
    const double previous = angle_rad;
    angle_rad = is_inside ? next : 0.5 * (low + high);
    if (std::abs(angle_rad - previous) < resolution_rad) break;
  }
  return (p_femur_mm - ball_centre_mm(condyle, angle_rad)).norm() - condyle.coronal_radius_mm;
}

double underside_mm(const Condyle& condyle, double x_mm, double z_mm)
{
  // The underside is where the distance vanishes; above the equator's height it is not met from below, so
  // bisect between well below the condyle and the ball centres' height.
  double above = ball_centre_mm(condyle, 0.0).y(), below = above - 2.0 * condyle.coronal_radius_mm;
  const double at_equator = signed_distance_mm(condyle, {x_mm, above, z_mm});
  if (at_equator >= 0.0) return above + at_equator;
  constexpr int n_halvings = 50;  // 80 mm to below a rounding error
  for (int step = 0; step < n_halvings; ++step) {
    const double middle = 0.5 * (above + below);
    (signed_distance_mm(condyle, {x_mm, middle, z_mm}) < 0.0 ? above : below) = middle;
  }
  return below;
}

}  // namespace vrda
