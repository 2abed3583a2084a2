#include "solve/rounded_contact.hpp"

#include <Eigen/Geometry>
#include <limits>

#include "geometry/rounded_kernel.hpp"

namespace vrda::solve {
namespace {

using Kind = ContactConstraint::Kind;

// Component of a unit normal along Delta below which a plane counts as parallel to Delta.
constexpr double steepest_normal = 1e-6;

bool is_plane(Kind kind)
{
  return kind == Kind::face_of_reference || kind == Kind::face_of_moving || kind == Kind::edges;
}

// Of a cylinder; zero for a sphere.
Eigen::Vector3d axis_of(const PlacedConstraint& c)
{
  if (c.kind == Kind::reference_edge) return c.reference_direction;
  if (c.kind == Kind::moving_edge) return c.moving_direction;
  return Eigen::Vector3d::Zero();
}

// Against Delta; zero for parallel edges.
Eigen::Vector3d plane_normal(const PlacedConstraint& c, const Eigen::Vector3d& delta)
{
  if (c.kind == Kind::face_of_reference) return c.reference_direction;
  if (c.kind == Kind::face_of_moving) return c.moving_direction;
  const Eigen::Vector3d across = c.reference_direction.cross(c.moving_direction);
  const double length = across.norm();
  if (length < geometry::rounded_rules::parallel_sine) return Eigen::Vector3d::Zero();
  return across / (across.dot(delta) > 0.0 ? -length : length);
}

// The nearest points, for the moving object displaced by `shift_mm`; `normal` and `mm` are known.
void set_points(const PlacedConstraint& c, const Eigen::Vector3d& shift_mm, double distance_mm,
                RoundedContact& out)
{
  out.reference_mm = c.reference_mm;
  out.moving_mm = c.moving_mm;
  const Eigen::Vector3d along = c.moving_mm + shift_mm - c.reference_mm - distance_mm * out.normal;
  switch (c.kind) {
    case Kind::face_of_reference:
      out.reference_mm += along;
      break;
    case Kind::face_of_moving:
      out.moving_mm -= along;
      break;
    case Kind::edges: {
      const Eigen::Vector3d across = c.reference_direction.cross(c.moving_direction);
      const double size_sq = across.squaredNorm();
      out.reference_mm += along.cross(c.moving_direction).dot(across) / size_sq * c.reference_direction;
      out.moving_mm -= c.reference_direction.cross(along).dot(across) / size_sq * c.moving_direction;
      break;
    }
    case Kind::reference_edge:
      out.reference_mm += c.reference_direction.dot(along) * c.reference_direction;
      break;
    case Kind::moving_edge:
      out.moving_mm -= c.moving_direction.dot(along) * c.moving_direction;
      break;
    case Kind::vertices:
      break;
  }
}

}  // namespace

RoundedContact rounded_distance(const PlacedConstraint& c, const Eigen::Vector3d& delta)
{
  RoundedContact out;
  out.mm = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d apart = c.moving_mm - c.reference_mm;
  double distance_mm = 0.0;
  if (is_plane(c.kind)) {
    out.normal = plane_normal(c, delta);
    if (out.normal.isZero(0.0)) return out;
    distance_mm = out.normal.dot(apart);
  } else {
    const Eigen::Vector3d axis = axis_of(c), w = apart - axis.dot(apart) * axis;
    distance_mm = w.norm();
    if (!(distance_mm > 0.0)) return out;
    // Beyond the centre the overlap continues to grow.
    if (w.dot(delta) > 0.0) distance_mm = -distance_mm;
    out.normal = w / distance_mm;
  }
  out.mm = distance_mm - c.offset_mm;
  set_points(c, Eigen::Vector3d::Zero(), distance_mm, out);
  return out;
}

RoundedContact rounded_travel(const PlacedConstraint& c, const Eigen::Vector3d& delta)
{
  RoundedContact out;
  out.mm = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d apart = c.moving_mm - c.reference_mm;
  double travel_mm = 0.0;
  if (is_plane(c.kind)) {
    out.normal = plane_normal(c, delta);
    if (std::abs(out.normal.dot(delta)) < steepest_normal) return out;
    travel_mm = (c.offset_mm - out.normal.dot(apart)) / out.normal.dot(delta);
  } else {
    const Eigen::Vector3d axis = axis_of(c);
    travel_mm = geometry::entry_travel_mm(apart, axis, {c.offset_mm, delta});
    if (!std::isfinite(travel_mm)) return out;
    const Eigen::Vector3d w = apart + travel_mm * delta;
    out.normal = (w - axis.dot(w) * axis) / c.offset_mm;
    if (std::abs(out.normal.dot(delta)) < steepest_normal) return out;
  }
  out.mm = travel_mm;
  set_points(c, travel_mm * delta, c.offset_mm, out);
  return out;
}

}  // namespace vrda::solve
