#include "ligament/plane_way.hpp"

#include <algorithm>
#include <cmath>

namespace vrda {
namespace {

// The circle that a plane cuts from the unit sphere; `up` leads from its centre to the straight line.
struct Circle {
  Eigen::Vector3d centre, up;
  double radius = 0.0;
  double height = 0.0;  // of the line over the centre
};

Circle circle_in(const WrapScene& scene, const SinCos& tilt)
{
  Circle circle;
  circle.up = tilt.cos * scene.outward + tilt.sin * scene.sideways;
  circle.height = scene.depth * tilt.cos;
  circle.centre = scene.depth * scene.outward - circle.height * circle.up;
  circle.radius = std::sqrt(std::max(0.0, 1.0 - circle.centre.squaredNorm()));
  return circle;
}

// Where the line from `point` touches the circle on the side of `up`; `turn` is -1 before the top, +1 after.
Eigen::Vector3d tangent_point(const WrapScene& scene, const Circle& circle, const Eigen::Vector3d& point,
                              double turn)
{
  const double x = point.dot(scene.along), y = circle.height, r = circle.radius;
  const double square = x * x + y * y;
  const double root = turn * r * std::sqrt(std::max(0.0, square - r * r));
  return circle.centre + ((r * r * x - root * y) / square) * scene.along +
         ((r * r * y + root * x) / square) * circle.up;
}

// Length of the shorter arc between two points of the circle, by halvings into chords.
double arc_length_mm(const WrapScene& scene, const Circle& circle, const Eigen::Vector3d& from,
                     const Eigen::Vector3d& to, int halvings)
{
  if (halvings == 0) return scene.mm(to - from).norm();
  const Eigen::Vector3d middle = 0.5 * (from + to) - circle.centre;
  // Opposite points have no middle; that takes a line through the very centre.
  const Eigen::Vector3d half =
      circle.centre + middle * (circle.radius / std::max(middle.norm(), 1e-12 * circle.radius));
  return arc_length_mm(scene, circle, from, half, halvings - 1) +
         arc_length_mm(scene, circle, half, to, halvings - 1);
}

}  // namespace

Eigen::Vector3d any_across(const Eigen::Vector3d& unit)
{
  const Eigen::Vector3d trial =
      std::abs(unit.x()) < 0.6 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  return (trial - trial.dot(unit) * unit).normalized();
}

bool set_line(WrapScene& scene)
{
  const Eigen::Vector3d span = scene.end - scene.start;
  const double length = span.norm();
  if (length == 0.0) return false;
  scene.along = span / length;
  const double before = -scene.start.dot(scene.along), after = scene.end.dot(scene.along);
  const Eigen::Vector3d nearest = scene.start + before * scene.along;
  scene.depth = nearest.norm();
  if (!(before > 0.0 && after > 0.0 && scene.depth < 1.0)) return false;
  // Through the very centre every plane is as good.
  scene.outward = scene.depth > 1e-12 ? Eigen::Vector3d(nearest / scene.depth) : any_across(scene.along);
  scene.sideways = scene.outward.cross(scene.along);
  return true;
}

PlaneWay way_in_plane(const WrapScene& scene, const SinCos& tilt)
{
  constexpr int halvings = 2;
  const Circle circle = circle_in(scene, tilt);
  const Eigen::Vector3d top = circle.centre + circle.radius * circle.up;
  PlaneWay way;
  way.touch = tangent_point(scene, circle, scene.start, -1.0);
  way.leave = tangent_point(scene, circle, scene.end, 1.0);
  way.arc_mm = arc_length_mm(scene, circle, way.touch, top, halvings) +
               arc_length_mm(scene, circle, top, way.leave, halvings);
  way.length_mm =
      scene.mm(way.touch - scene.start).norm() + way.arc_mm + scene.mm(scene.end - way.leave).norm();
  return way;
}

}  // namespace vrda
