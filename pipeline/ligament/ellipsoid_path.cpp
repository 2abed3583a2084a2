#include <algorithm>
#include <array>
#include <cmath>

#include "core/units.hpp"
#include "ligament/wrap_path.hpp"

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

namespace {

// Plane ways tried, all round the straight line.
constexpr std::size_t n_planes = 16;
// Steps of the integration far from the solution, and near it: the second leaves 1e-8 mm at most.
constexpr double coarse_step_rad = 0.06, fine_step_rad = 0.014;
// Within this part of the largest half-axis the fine steps begin, and it is solved. Newton's last step leaves
// the square of a miss.
constexpr double near_miss = 1e-4, no_miss = 1e-10;
constexpr int max_shots = 30;

// On the surface within rounding counts as a hair outside, where tangents are still told apart.
Eigen::Vector3d lifted(const Eigen::Vector3d& q)
{
  constexpr double least_square = 1.0 + 1e-12;
  const double square = q.squaredNorm();
  return square < least_square ? Eigen::Vector3d(q * std::sqrt(least_square / square)) : q;
}

// The start's tangent points lie on a circle of the sphere; an angle goes round it from a first one.
struct Horizon {
  Eigen::Vector3d start, centre, first, second;  // scaled; the last two as long as the circle's radius
};

Horizon horizon_of(const Eigen::Vector3d& start, const Eigen::Vector3d& touch)
{
  const double square = start.squaredNorm();
  const Eigen::Vector3d axis = start / std::sqrt(square);
  const Eigen::Vector3d spoke = touch - touch.dot(axis) * axis;
  const Eigen::Vector3d unit =
      spoke.squaredNorm() > 0.0 ? Eigen::Vector3d(spoke.normalized()) : any_across(axis);
  const double radius = std::sqrt(1.0 - 1.0 / square);
  return {start, start / square, radius * unit, radius * axis.cross(unit)};
}

// The tangent point at an angle.
Eigen::Vector3d on_horizon(const Horizon& horizon, double angle_rad)
{
  const SinCos turn = sin_cos(angle_rad);
  return horizon.centre + turn.cos * horizon.first + turn.sin * horizon.second;
}

struct Aim {
  double angle_rad = 0.0;  // round the horizon
  double arc_mm = 0.0;     // on the surface
  double step_rad = coarse_step_rad;
};

// The way that an aim gives, and how far its last segment misses the end.
struct Shot {
  double first_mm = 0.0;
  double ahead_mm = 0.0;   // how fast the tangent point moves along the way with the angle
  GeodesicState at_leave;  // the width is that between neighbouring angles, below 0 as it starts
  Eigen::Vector3d end_mm;  // from where the surface is left
  Eigen::Vector3d direction, normal, across;
  double last_mm = 0.0;  // the end's distance along the direction
  double miss_normal_mm = 0.0, miss_across_mm = 0.0;
};

Shot shoot(const WrapScene& scene, const Horizon& horizon, const Aim& aim)
{
  const Eigen::Vector3d& a = scene.half_axes_mm;
  const SinCos turn = sin_cos(aim.angle_rad);
  GeodesicState state;
  state.q = horizon.centre + turn.cos * horizon.first + turn.sin * horizon.second;
  const Eigen::Vector3d pace_mm = scene.mm(turn.cos * horizon.second - turn.sin * horizon.first);
  const Eigen::Vector3d free_mm = scene.mm(state.q - horizon.start);
  Shot shot;
  shot.first_mm = free_mm.norm();
  const Eigen::Vector3d v = free_mm / shot.first_mm;
  state.q_slope = v.cwiseQuotient(a);
  state.width = v.cross(state.q.cwiseQuotient(a).normalized()).dot(pace_mm);
  state.width_slope = state.width / shot.first_mm;
  shot.ahead_mm = v.dot(pace_mm);
  shot.at_leave = advance(state, aim.arc_mm, a, aim.step_rad);
  shot.end_mm = scene.mm(scene.end - shot.at_leave.q);
  shot.direction = scene.mm(shot.at_leave.q_slope).normalized();
  shot.normal = shot.at_leave.q.cwiseQuotient(a).normalized();
  shot.across = shot.direction.cross(shot.normal);
  shot.last_mm = shot.end_mm.dot(shot.direction);
  shot.miss_normal_mm = shot.end_mm.dot(shot.normal);
  shot.miss_across_mm = shot.end_mm.dot(shot.across);
  return shot;
}

// Newton's step for no miss. Along the way and to its side the frame of direction, normal and across turns by
// the surface's curvatures (Darboux).
Aim corrected(const WrapScene& scene, const Aim& aim, const Shot& shot)
{
  const Eigen::Vector3d& a = scene.half_axes_mm;
  const Eigen::Vector3d v = shot.direction.cwiseQuotient(a), b = shot.across.cwiseQuotient(a);
  const double scale = shot.at_leave.q.cwiseQuotient(a).norm();
  const double along = v.dot(v) / scale, side = b.dot(b) / scale, twist = v.dot(b) / scale;
  const double j = shot.at_leave.width, j_slope = shot.at_leave.width_slope;
  // Of the misses along normal and across, over the arc and the angle.
  const double n_arc = along * shot.last_mm + twist * shot.miss_across_mm;
  const double n_angle = j * (twist * shot.last_mm + side * shot.miss_across_mm);
  const double b_arc = -twist * shot.miss_normal_mm;
  const double b_angle = -j - j_slope * shot.last_mm - side * j * shot.miss_normal_mm;
  const double determinant = n_arc * b_angle - n_angle * b_arc;
  const double angle_rad = (b_arc * shot.miss_normal_mm - n_arc * shot.miss_across_mm) / determinant;
  const double arc_mm = (n_angle * shot.miss_across_mm - b_angle * shot.miss_normal_mm) / determinant -
                        shot.ahead_mm * angle_rad;
  // Far from the solution a step must not leave the surroundings of its plane.
  const double longest = 0.3;
  const double damping =
      std::min({1.0, longest / std::abs(angle_rad), longest * a.maxCoeff() / std::abs(arc_mm)});
  Aim next = aim;
  next.angle_rad += damping * angle_rad;
  next.arc_mm += damping * arc_mm;
  return next;
}

struct Geodesic {
  double length_mm = std::numeric_limits<double>::infinity();  // infinite: not found
  Horizon horizon;
  Aim aim;
  Shot shot;
};

// No neighbouring way crosses it up to the end: a shortest one nearby, not a saddle.
bool is_locally_shortest(const Geodesic& geodesic)
{
  const Shot& shot = geodesic.shot;
  return geodesic.aim.arc_mm >= 0.0 && shot.at_leave.width < 0.0 &&
         shot.at_leave.width + shot.last_mm * shot.at_leave.width_slope < 0.0;
}

// From an aim nearby, until the miss is below a part of the largest half-axis.
Geodesic solved(const WrapScene& scene, const Horizon& horizon, Aim aim, double largest_miss)
{
  const double largest_miss_mm = largest_miss * scene.half_axes_mm.maxCoeff();
  for (int i = 0; i < max_shots; ++i) {
    const Shot shot = shoot(scene, horizon, aim);
    if (shot.last_mm < 0.0) {
      // The surface was left beyond the end's own tangent: the right place is as far before the end.
      aim.arc_mm = std::max(0.0, aim.arc_mm + 2.0 * shot.last_mm);
      continue;
    }
    if (std::abs(shot.miss_normal_mm) + std::abs(shot.miss_across_mm) < largest_miss_mm) {
      // The end is met by a bend, which lengthens the way by the square of the miss only.
      const Geodesic found{shot.first_mm + aim.arc_mm + shot.end_mm.norm(), horizon, aim, shot};
      return is_locally_shortest(found) ? found : Geodesic{};
    }
    aim = corrected(scene, aim, shot);
  }
  return {};
}

using PlaneWays = std::array<PlaneWay, n_planes>;

// From the plane ways that are shorter than both neighbours, or from all. Those much longer than the shortest
// cannot lead to the shortest geodesic.
Geodesic shortest_geodesic(const WrapScene& scene, const PlaneWays& ways, double shortest_mm, bool from_all)
{
  constexpr double worth_trying = 1.1;
  Geodesic best;
  for (std::size_t i = 0; i < n_planes; ++i) {
    if (ways[i].length_mm > worth_trying * shortest_mm) continue;
    const bool is_shorter = ways[i].length_mm <= ways[(i + 1) % n_planes].length_mm &&
                            ways[i].length_mm < ways[(i + n_planes - 1) % n_planes].length_mm;
    if (!is_shorter && !from_all) continue;
    const Geodesic geodesic = solved(scene, horizon_of(scene.start, ways[i].touch),
                                     {0.0, ways[i].arc_mm, coarse_step_rad}, near_miss);
    if (geodesic.length_mm < best.length_mm) best = geodesic;
  }
  if (std::isinf(best.length_mm)) return best;
  return solved(scene, best.horizon, {best.aim.angle_rad, best.aim.arc_mm, fine_step_rad}, no_miss);
}

// Where a way comes to the surface, and how it goes on.
void set_touch(WrapPath& path, const WrapScene& scene, const Eigen::Vector3d& touch, double arc_mm)
{
  path.touch_mm = scene.mm(touch);
  path.departure = scene.mm(touch - scene.start).normalized();
  path.arc_mm = arc_mm;
}

WrapPath path_of(const WrapScene& scene, const Geodesic& geodesic)
{
  const Shot& shot = geodesic.shot;
  WrapPath path;
  path.is_wrapped = true;
  path.length_mm = geodesic.length_mm;
  path.arrival = shot.direction;
  // Of an end on the surface the free segment vanishes, and the bend is the surface's own.
  const double free_mm = std::max(shot.last_mm, 1e-9 * geodesic.length_mm);
  const double parting =
      shot.at_leave.width_slope / (shot.at_leave.width + shot.last_mm * shot.at_leave.width_slope);
  path.bending =
      shot.normal * shot.normal.transpose() / free_mm + parting * shot.across * shot.across.transpose();
  set_touch(path, scene, on_horizon(geodesic.horizon, geodesic.aim.angle_rad), geodesic.aim.arc_mm);
  return path;
}

// The plane way itself, where no geodesic was found.
WrapPath path_of(const WrapScene& scene, const PlaneWay& way)
{
  WrapPath path;
  path.is_wrapped = true;
  path.length_mm = way.length_mm;
  path.arrival = scene.mm(scene.end - way.leave).normalized();
  path.bending = (Eigen::Matrix3d::Identity() - path.arrival * path.arrival.transpose()) / path.length_mm;
  set_touch(path, scene, way.touch, way.arc_mm);
  return path;
}

}  // namespace

WrapPath ellipsoid_path(const Eigen::Vector3d& start_mm, const Eigen::Vector3d& end_mm,
                        const Eigen::Vector3d& half_axes_mm)
{
  WrapScene scene;
  scene.half_axes_mm = half_axes_mm;
  scene.start = start_mm.cwiseQuotient(half_axes_mm);
  scene.end = end_mm.cwiseQuotient(half_axes_mm);
  if (scene.start.squaredNorm() < 1.0 || scene.end.squaredNorm() < 1.0) return {};
  scene.start = lifted(scene.start);
  scene.end = lifted(scene.end);
  if (!set_line(scene)) return {};
  PlaneWays ways;
  const PlaneWay* shortest = &ways[0];
  for (std::size_t i = 0; i < n_planes; ++i) {
    ways[i] = way_in_plane(scene, sin_cos(static_cast<double>(i) * (2.0 * pi / n_planes)));
    if (ways[i].length_mm < shortest->length_mm) shortest = &ways[i];
  }
  Geodesic best = shortest_geodesic(scene, ways, shortest->length_mm, false);
  if (std::isinf(best.length_mm)) best = shortest_geodesic(scene, ways, shortest->length_mm, true);
  return std::isinf(best.length_mm) ? path_of(scene, *shortest) : path_of(scene, best);
}

Eigen::Vector3d ellipsoid_point_mm(const WrapPath& path, double along_mm, const Eigen::Vector3d& half_axes_mm)
{
  GeodesicState state;
  state.q = path.touch_mm.cwiseQuotient(half_axes_mm);
  state.q_slope = path.departure.cwiseQuotient(half_axes_mm);
  return half_axes_mm.cwiseProduct(advance(state, along_mm, half_axes_mm, fine_step_rad).q);
}

}  // namespace vrda
