#include "geometry/condyle.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/trig.hpp"

namespace vrda::geometry {
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

// Tangential offset of p from the ball centre at angle a, and its derivative over a:
// -(height above the curve + the curve's radius).
struct Lead {
  double value_mm = 0.0;
  double slope_mm = 0.0;
};

Support support_at(const Condyle& condyle, double angle_rad, const SinCos& a)
{
  const Spiral q = spiral(angle_rad, condyle.spiral_end_rad);
  const Eigen::Vector2d& shift = condyle.shift_mm;
  return {condyle.posterior_radius_mm + condyle.extra_radius_mm * q.value -
              (shift.x() * a.sin + shift.y() * a.cos),
          condyle.extra_radius_mm * q.slope - (shift.x() * a.cos - shift.y() * a.sin)};
}

Lead lead(const Condyle& condyle, const Eigen::Vector3d& p, double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  const Support s = support_at(condyle, angle_rad, a);
  return {-a.cos * p.x() + a.sin * p.y() - s.slope_mm,
          a.sin * p.x() + a.cos * p.y() + s.value_mm - radius_mm(condyle, angle_rad)};
}

}  // namespace

Support support(const Condyle& condyle, double angle_rad)
{
  return support_at(condyle, angle_rad, sin_cos(angle_rad));
}

double radius_mm(const Condyle& condyle, double angle_rad)
{
  const double u = std::max(0.0, 1.0 - angle_rad / condyle.spiral_end_rad);
  return condyle.posterior_radius_mm + condyle.extra_radius_mm * u * u * u * u;
}

Eigen::Vector3d ball_centre_mm(const Condyle& condyle, double angle_rad)
{
  const SinCos a = sin_cos(angle_rad);
  const Support p = support_at(condyle, angle_rad, a);
  const double reach_mm = p.value_mm - condyle.coronal_radius_mm;
  return {-reach_mm * a.sin - p.slope_mm * a.cos, -reach_mm * a.cos + p.slope_mm * a.sin, condyle.z_mm};
}

CondyleSurface::CondyleSurface(const Condyle& condyle) : condyle_(condyle)
{
  const double last = static_cast<double>(n_samples - 1);
  std::array<Eigen::Vector3d, n_samples> centre_mm;
  for (std::size_t k = 0; k < n_samples; ++k) {
    const double t = static_cast<double>(k) / last;
    angle_rad_[k] = (1.0 - t) * condyle.first_rad + t * condyle.last_rad;
    centre_mm[k] = ball_centre_mm(condyle, angle_rad_[k]);
    centre_x_mm_[k] = centre_mm[k].x();
    centre_y_mm_[k] = centre_mm[k].y();
  }
  middle_mm_ = 0.5 * (centre_mm.front() + centre_mm.back());
  for (const Eigen::Vector3d& centre : centre_mm) {
    reach_mm_ = std::max(reach_mm_, (centre - middle_mm_).norm());
  }
  constexpr double between_samples_mm = 0.5;  // upper bound of the sagitta of a step
  reach_mm_ += condyle.coronal_radius_mm + between_samples_mm;
}

Eigen::Vector3d CondyleSurface::nearest_ball_centre_mm(const Eigen::Vector3d& p) const
{
  std::array<double, n_samples> distance_sq_mm2{};
  const double dz = p.z() - condyle_.z_mm;
  for (std::size_t k = 0; k < n_samples; ++k) {
    const double dx = p.x() - centre_x_mm_[k], dy = p.y() - centre_y_mm_[k];
    distance_sq_mm2[k] = dx * dx + (dy * dy + dz * dz);
  }
  const auto nearest = std::min_element(distance_sq_mm2.begin(), distance_sq_mm2.end());
  const auto at = static_cast<std::size_t>(nearest - distance_sq_mm2.begin());
  double low = angle_rad_[at == 0 ? 0 : at - 1];
  double high = angle_rad_[at + 1 == angle_rad_.size() ? at : at + 1];
  double angle_rad = angle_rad_[at];
  // Newton with bisection as fallback; the foot may be an end of the outline.
  constexpr int most_steps = 60;
  constexpr double resolution_mm = 1e-12, resolution_rad = 1e-14;
  for (int step = 0; step < most_steps && high - low > resolution_rad; ++step) {
    const Lead ahead = lead(condyle_, p, angle_rad);
    if (std::abs(ahead.value_mm) < resolution_mm) break;
    (ahead.value_mm > 0.0 ? low : high) = angle_rad;
    const double next = angle_rad - ahead.value_mm / ahead.slope_mm;
    const bool is_usable = ahead.slope_mm < 0.0 && next > low && next < high;
    angle_rad = is_usable ? next : 0.5 * (low + high);
  }
  return ball_centre_mm(condyle_, angle_rad);
}

double CondyleSurface::signed_distance_mm(const Eigen::Vector3d& p) const
{
  constexpr double far_mm = 12.0;  // more than the width of every fillet
  const double bound_mm = (p - middle_mm_).norm() - reach_mm_;
  if (bound_mm > far_mm) return bound_mm;
  return (p - nearest_ball_centre_mm(p)).norm() - condyle_.coronal_radius_mm;
}

double CondyleSurface::underside_mm(double x_mm, double z_mm) const
{
  // Newton from below, where the distance is decreasing and convex: iterates stay below the surface.
  Eigen::Vector3d p(x_mm, middle_mm_.y() - reach_mm_, z_mm);
  constexpr int most_steps = 60;
  constexpr double resolution_mm = 1e-12;
  for (int step = 0; step < most_steps; ++step) {
    const Eigen::Vector3d from_centre = p - nearest_ball_centre_mm(p);
    const double distance_mm = from_centre.norm() - condyle_.coronal_radius_mm;
    if (from_centre.y() >= 0.0) return p.y() + distance_mm;
    if (distance_mm < resolution_mm) break;
    p.y() -= distance_mm * from_centre.norm() / from_centre.y();
  }
  return p.y();
}

}  // namespace vrda::geometry
