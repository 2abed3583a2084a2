#include "optics/distortion.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vrda {
namespace {

double shown_radius(const Distortion& d, double r)
{
  return r * (1.0 + r * r * (d.k1 + d.k2 * r * r));
}

double slope(const Distortion& d, double r)
{
  return 1.0 + r * r * (3.0 * d.k1 + 5.0 * d.k2 * r * r);
}

/// Smallest r > 0 at which 1 + 3 k1 r^2 + 5 k2 r^4 is 0; infinite where it stays positive.
double fold_radius(const Distortion& d)
{
  constexpr double never = std::numeric_limits<double>::infinity();
  const double a = 5.0 * d.k2, b = 3.0 * d.k1;  // of a s^2 + b s + 1, s = r^2
  const double discriminant = b * b - 4.0 * a;
  if (discriminant < 0.0) return never;
  // 2 / (-b + root) is the root of smallest size where it is positive, without cancellation.
  const double root = std::sqrt(discriminant);
  double smallest = never;
  for (const double denominator : {-b + root, -b - root}) {
    if (denominator > 0.0) smallest = std::min(smallest, 2.0 / denominator);
  }
  return std::sqrt(smallest);
}

/// From pixels to units and back, both about the centre.
Eigen::Vector2d in_units(const Distortion& d, const Eigen::Vector2d& px)
{
  const Eigen::Vector2d from_centre = px - d.centre_px;
  return Eigen::Vector2d(from_centre.x(), from_centre.y() * d.pixel_aspect) / d.unit_px;
}

Eigen::Vector2d in_pixels(const Distortion& d, const Eigen::Vector2d& units)
{
  return d.centre_px + d.unit_px * Eigen::Vector2d(units.x(), units.y() / d.pixel_aspect);
}

/// The r at which shown_radius is `shown`, or the fold where none is.
double drawn_radius(const Distortion& d, double shown)
{
  double low = 0.0, high = std::max(1.0, shown);
  const double fold = fold_radius(d);
  while (high < fold && shown_radius(d, high) < shown) high *= 2.0;
  high = std::min(high, fold);
  if (shown_radius(d, high) <= shown) return high;
  double r = std::min(shown, high);
  constexpr int most_steps = 100;
  constexpr double resolution = 1e-15;
  for (int step = 0; step < most_steps && high - low > resolution * high; ++step) {
    const double ahead = shown_radius(d, r) - shown;
    if (ahead == 0.0) break;
    (ahead < 0.0 ? low : high) = r;
    const double next = r - ahead / slope(d, r);
    if (std::abs(next - r) <= resolution * r) break;  // the bracket need not close around it
    r = next > low && next < high ? next : 0.5 * (low + high);
  }
  return r;
}

}  // namespace

Eigen::Vector2d shown_px(const Distortion& distortion, const Eigen::Vector2d& drawn_px)
{
  const Eigen::Vector2d p = in_units(distortion, drawn_px);
  const double s = p.squaredNorm();
  return in_pixels(distortion, p * (1.0 + s * (distortion.k1 + distortion.k2 * s)));
}

Eigen::Vector2d drawn_px(const Distortion& distortion, const Eigen::Vector2d& shown_px)
{
  const Eigen::Vector2d p = in_units(distortion, shown_px);
  const double r = p.norm();
  if (r == 0.0) return shown_px;
  return in_pixels(distortion, p * (drawn_radius(distortion, r) / r));
}

double fold_radius_px(const Distortion& distortion)
{
  return distortion.unit_px * fold_radius(distortion);
}

}  // namespace vrda
