// Shortest path around a cylinder along Z, its tangent points and points on it; lengths in mm.
#include <algorithm>
#include <cmath>

#include "core/trig.hpp"
#include "model/wrap_path.hpp"

namespace vrda::inline model {
namespace {

// Tangent point on the unit circle of the line from `p`, on the side of increasing (turn = 1) or decreasing
// (turn = -1) angle from p's own.
Eigen::Vector2d tangent_point(const Eigen::Vector2d& p, double turn)
{
  const double square = p.squaredNorm();
  const double root = std::sqrt(std::max(0.0, square - 1.0));
  return (p + turn * root * Eigen::Vector2d(-p.y(), p.x())) / square;
}

}  // namespace

WrapPath cylinder_path(const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm, double radius_mm,
                       double half_length_mm)
{
  const Eigen::Vector2d start = start_mm.head<2>() / radius_mm, end = end_mm.head<2>() / radius_mm;
  const double start_sq = start.squaredNorm(), end_sq = end.squaredNorm();
  if (start_sq < 1.0 || end_sq < 1.0) return {};
  const double turn = start.x() * end.y() - start.y() * end.x() >= 0.0 ? 1.0 : -1.0;
  const double between_rad =
      arc_tangent2(std::abs(start.x() * end.y() - start.y() * end.x()), start.dot(end));
  const double arc_rad =
      between_rad - arc_cosine(1.0 / std::sqrt(start_sq)) - arc_cosine(1.0 / std::sqrt(end_sq));
  if (!(arc_rad > 0.0)) return {};
  // In the unrolled surface the path is one straight line over tangent, arc and tangent.
  const double first_mm = radius_mm * std::sqrt(start_sq - 1.0),
               last_mm = radius_mm * std::sqrt(end_sq - 1.0);
  const double across_mm = first_mm + radius_mm * arc_rad + last_mm;
  const double rise_mm = end_mm.z() - start_mm.z();
  const double touch_z_mm = start_mm.z() + rise_mm * (first_mm / across_mm);
  const double leave_z_mm = end_mm.z() - rise_mm * (last_mm / across_mm);
  const bool is_above = std::min(touch_z_mm, leave_z_mm) > half_length_mm;
  const bool is_below = std::max(touch_z_mm, leave_z_mm) < -half_length_mm;
  if (is_above || is_below) return {};
  WrapPath path;
  path.is_wrapped = true;
  path.length_mm = std::sqrt(across_mm * across_mm + rise_mm * rise_mm);
  const Eigen::Vector2d normal = tangent_point(end, -turn);
  const double cosine_rise = across_mm / path.length_mm, sine_rise = rise_mm / path.length_mm;
  path.end_direction << -turn * cosine_rise * normal.y(), turn * cosine_rise * normal.x(), sine_rise;
  const Eigen::Vector3d n(normal.x(), normal.y(), 0.0);
  const Eigen::Vector3d b = path.end_direction.cross(n);
  const double free_mm = std::max(last_mm / cosine_rise, 1e-9 * radius_mm);
  path.bending = n * n.transpose() / free_mm + b * b.transpose() / path.length_mm;
  const Eigen::Vector2d touch = tangent_point(start, turn);
  path.touch_mm << radius_mm * touch, touch_z_mm;
  path.start_direction << -turn * cosine_rise * touch.y(), turn * cosine_rise * touch.x(), sine_rise;
  path.arc_mm = radius_mm * arc_rad / cosine_rise;
  return path;
}

Eigen::Vector3d cylinder_point_mm(const WrapPath& path, double along_mm, double radius_mm)
{
  const Eigen::Vector2d touch_mm = path.touch_mm.head<2>();
  const Eigen::Vector2d left_mm(-touch_mm.y(), touch_mm.x());
  const SinCos turn =
      sin_cos(along_mm * path.start_direction.head<2>().dot(left_mm) / (radius_mm * radius_mm));
  Eigen::Vector3d point_mm;
  point_mm << turn.cos * touch_mm + turn.sin * left_mm,
      path.touch_mm.z() + along_mm * path.start_direction.z();
  return point_mm;
}

}  // namespace vrda::inline model
