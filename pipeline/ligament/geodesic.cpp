#include "ligament/geodesic.hpp"

#include <cmath>

namespace vrda {
namespace {

constexpr int max_steps = 2000;

using Eigen::Vector4d;

// Scaled place and width together: both are pulled back in proportion, y'' = -w^-2 rate y.
struct Course {
  Vector4d y, slope;
};

struct Ellipsoid {
  Eigen::Vector3d inverse_sq;  // 1 / a^2
  Vector4d rate;               // C / a^2, and 1 / (a b c)^2 for the width

  double w(const Vector4d& y) const
  {
    return inverse_sq.x() * y.x() * y.x() + inverse_sq.y() * y.y() * y.y() + inverse_sq.z() * y.z() * y.z();
  }

  Vector4d pull(const Vector4d& y) const
  {
    const double w_now = w(y);
    return (-1.0 / (w_now * w_now)) * rate.cwiseProduct(y);
  }
};

// One step of Nystroem's method of fifth order for y'' = f(y). Source: Hairer, Noersett, Wanner (1993),
// II.14.
Course step(const Course& at, double h, const Ellipsoid& surface)
{
  const double h2 = h * h;
  const Vector4d k1 = surface.pull(at.y);
  const Vector4d k2 = surface.pull(at.y + (h / 5.0) * at.slope + (h2 / 50.0) * k1);
  const Vector4d k3 = surface.pull(at.y + (h * 2.0 / 3.0) * at.slope + (h2 / 27.0) * (7.0 * k2 - k1));
  const Vector4d k4 = surface.pull(at.y + h * at.slope + (h2 / 70.0) * (21.0 * k1 - 4.0 * k2 + 18.0 * k3));
  return {at.y + h * at.slope + (h2 / 336.0) * (14.0 * k1 + 100.0 * k2 + 54.0 * k3),
          at.slope + (h / 336.0) * (14.0 * k1 + 125.0 * k2 + 162.0 * k3 + 35.0 * k4)};
}

}  // namespace

GeodesicState advance(const GeodesicState& from, double length_mm, const Eigen::Vector3d& half_axes_mm,
                      double step_rad)
{
  Ellipsoid surface;
  surface.inverse_sq = half_axes_mm.cwiseProduct(half_axes_mm).cwiseInverse();
  Course course;
  course.y << from.q, from.width;
  course.slope << from.q_slope, from.width_slope;
  const double invariant = surface.w(course.y) * from.q_slope.squaredNorm();
  surface.rate << invariant * surface.inverse_sq, surface.inverse_sq.prod();
  // The fastest angle by length is sqrt(C) / (smallest half-axis * w): steps are short where w is small.
  const double pace = step_rad / std::sqrt(invariant * surface.inverse_sq.maxCoeff());
  double left_mm = length_mm;
  for (int i = 0; i < max_steps && left_mm != 0.0; ++i) {
    const double longest_mm = pace * surface.w(course.y);
    const bool is_last = std::abs(left_mm) <= longest_mm;
    const double h_mm = is_last ? left_mm : std::copysign(longest_mm, left_mm);
    course = step(course, h_mm, surface);
    left_mm = is_last ? 0.0 : left_mm - h_mm;
  }
  return {course.y.head<3>(), course.slope.head<3>(), course.y.w(), course.slope.w()};
}

}  // namespace vrda
