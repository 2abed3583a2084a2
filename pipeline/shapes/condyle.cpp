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

// How far p leads the point at angle a along the curve of ball centres, and the slope of that over a:
// -(height above the curve + the curve's radius).
struct Lead {
  double value_mm = 0.0;
  double slope_mm = 0.0;
};

Lead lead(const Condyle& condyle, const Eigen::Vector3d& p, double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  const Support s = support(condyle, angle_rad);
  return {-a.cos * p.x() + a.sin * p.y() - s.slope_mm,
          a.sin * p.x() + a.cos * p.y() + s.value_mm - radius_mm(condyle, angle_rad)};
}

// Angle of the foot of the perpendicular from p on the curve of ball centres, by Newton inside a shrinking
// bracket: the lead falls where p is outside the curve.
double foot_rad(const Condyle& condyle, const Eigen::Vector3d& p)
{
  double low = condyle.first_rad, high = condyle.last_rad;
  if (lead(condyle, p, low).value_mm <= 0.0) return low;
  if (lead(condyle, p, high).value_mm >= 0.0) return high;
  double angle_rad = std::clamp(arc_tangent2(-p.x(), -p.y()), low, high);
  constexpr int most_steps = 60;
  constexpr double resolution_mm = 1e-12;
  for (int step = 0; step < most_steps; ++step) {
    const Lead at = lead(condyle, p, angle_rad);
    if (std::abs(at.value_mm) < resolution_mm) break;
    (at.value_mm > 0.0 ? low : high) = angle_rad;
    const double next = angle_rad - at.value_mm / at.slope_mm;
    const bool is_usable = at.slope_mm < 0.0 && next > low && next < high;
    angle_rad = is_usable ? next : 0.5 * (low + high);
  }
  return angle_rad;
}

Eigen::Vector3d nearest_ball_centre_mm(const Condyle& condyle, const Eigen::Vector3d& p)
{
  Eigen::Vector3d nearest = ball_centre_mm(condyle, foot_rad(condyle, p));
  for (const double end_rad : {condyle.first_rad, condyle.last_rad}) {
    const Eigen::Vector3d end = ball_centre_mm(condyle, end_rad);
    if ((p - end).squaredNorm() < (p - nearest).squaredNorm()) nearest = end;
  }
  return nearest;
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
  return (p_femur_mm - nearest_ball_centre_mm(condyle, p_femur_mm)).norm() - condyle.coronal_radius_mm;
}

double underside_mm(const Condyle& condyle, double x_mm, double z_mm)
{
  // Newton from below, where the distance falls and is convex: it approaches the surface without passing it.
  Eigen::Vector3d p(x_mm, ball_centre_mm(condyle, 0.0).y() - 2.0 * condyle.coronal_radius_mm, z_mm);
  constexpr int most_steps = 60;
  constexpr double resolution_mm = 1e-12;
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::Vector3d from_centre = p - nearest_ball_centre_mm(condyle, p);
    const double distance_mm = from_centre.norm() - condyle.coronal_radius_mm;
    // Beside the condyle: no point above (x, z) touches it from below.
    if (from_centre.y() >= 0.0) return p.y() + distance_mm;
    if (distance_mm < resolution_mm) break;
    p.y() -= distance_mm * from_centre.norm() / from_centre.y();
  }
  return p.y();
}

}  // namespace vrda
