#include "solve/contact_constraint.hpp"

#include <Eigen/Geometry>

#include <limits>

#include "geometry/rounded_kernel.hpp"

namespace vrda::solve {
namespace {

// Sine of the angle below which a normal is that of a face; thin triangles have rounding errors of 1e-10.
constexpr double same_direction = 1e-7;
// Rounding of one point transformed by both objects' rotations.
constexpr double same_point_mm = 1e-9;
// Component of a unit normal along Delta below which a face counts as parallel to Delta.
constexpr double parallel_to_delta = 1e-6;

Eigen::Vector3d about_x(const Eigen::Vector3d& v)
{
  return {0.0, -v.z(), v.y()};
}

Eigen::Vector3d about_delta(const Eigen::Vector3d& v)
{
  return {v.z(), 0.0, -v.x()};
}

// Row of the triangle's corner at `p`, or -1.
std::int32_t corner_at(const Mesh& mesh, std::int32_t triangle, const Eigen::Vector3d& p)
{
  for (Eigen::Index k = 0; k < 3; ++k) {
    const std::int32_t v = mesh.triangles(triangle, k);
    if ((mesh.vertices_mm.row(v).transpose() - p).cwiseAbs().maxCoeff() <= same_point_mm) return v;
  }
  return -1;
}

// Stores the pair of unit edges whose cross product is most nearly parallel to `normal`.
void set_edges(const geometry::Corners& reference, const geometry::Corners& moving,
               const Eigen::Vector3d& normal, ContactConstraint& out)
{
  double best = -1.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d u = (reference[(i + 1) % 3] - reference[i]).normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d v = (moving[(k + 1) % 3] - moving[k]).normalized();
      const double share = std::abs(u.cross(v).normalized().dot(normal));
      if (share <= best) continue;
      best = share;
      out.reference_direction = u;
      out.moving_direction = v;
    }
  }
}

// The common normal, not of unit length, and its derivatives over theta and varus.
struct Normal {
  Eigen::Vector3d n, over_theta, over_varus;
};

Normal common_normal(const ContactConstraint& constraint, const Rotations& at)
{
  switch (constraint.kind) {
    case ContactConstraint::Kind::face_of_reference: {
      const Eigen::Vector3d n = at.of_reference * constraint.reference_direction;
      return {n, Eigen::Vector3d::Zero(), -about_x(n)};
    }
    case ContactConstraint::Kind::face_of_moving: {
      const Eigen::Vector3d n = at.of_moving * constraint.moving_direction;
      return {n, about_delta(n), Eigen::Vector3d::Zero()};
    }
    default:
      break;
  }
  const Eigen::Vector3d u = at.of_reference * constraint.reference_direction,
                        v = at.of_moving * constraint.moving_direction;
  return {u.cross(v), u.cross(about_delta(v)), -about_x(u).cross(v)};
}

// Derivative of n / n.y.
Eigen::Vector3d slope_change(const Normal& n, const Eigen::Vector3d& change)
{
  return (change - n.n * (change.y() / n.n.y())) / n.n.y();
}

// Jacobian of reference point minus moving point, the latter relative to the pivot.
Eigen::Matrix<double, 3, 5> distance_jacobian(const Eigen::Vector3d& reference_mm,
                                              const Eigen::Vector3d& moving_mm)
{
  Eigen::Matrix<double, 3, 5> J;
  J.leftCols<3>() = -Eigen::Matrix3d::Identity();
  J.col(about_y) = -about_delta(moving_mm);
  J.col(about_varus) = -about_x(reference_mm);
  return J;
}

Eigen::Matrix<double, 3, 5> distance_jacobian(const ContactConstraint& constraint, const Rotations& at)
{
  return distance_jacobian(at.of_reference * constraint.reference_mm, at.of_moving * constraint.moving_mm);
}

RoundedContact rounded_travel_of(const ContactConstraint& c, const Configuration& configuration,
                                 const Rotations& at)
{
  return rounded_travel({c.kind, c.offset_mm, at.of_reference * c.reference_mm,
                         configuration.pivot_mm + at.of_moving * c.moving_mm,
                         at.of_reference * c.reference_direction, at.of_moving * c.moving_direction},
                        Eigen::Vector3d::UnitY());
}

Clearance rounded_clearance(const ContactConstraint& constraint, const Configuration& configuration,
                            const Rotations& at)
{
  const RoundedContact touch = rounded_travel_of(constraint, configuration, at);
  Clearance result;
  result.travel_mm = touch.mm;
  if (!std::isfinite(touch.mm)) return result;
  result.gradient =
      distance_jacobian(touch.reference_mm, touch.moving_mm - configuration.pivot_mm).transpose() *
      (touch.normal / touch.normal.y());
  return result;
}

// Central differences of the exact gradient.
Matrix5d rounded_hessian(const ContactConstraint& constraint, const Configuration& configuration,
                         const Rotations& at)
{
  constexpr double step = 1e-5;  // mm and rad: errors of 1e-10 / offset^2 by curvature, 1e-8 by rounding
  const auto gradient = [&](Eigen::Index k, double change) {
    Configuration other = configuration;
    Rotations turned = at;
    if (k < 3) other.pivot_mm(k) += change;
    if (k == about_y) turned.of_moving = rotation_y(change) * at.of_moving;
    if (k == about_varus) turned.of_reference = rotation_x(-change) * at.of_reference;
    return rounded_clearance(constraint, other, turned).gradient;
  };
  Matrix5d hessian;
  for (Eigen::Index k = 0; k < hessian.cols(); ++k)
    hessian.col(k) = (gradient(k, step) - gradient(k, -step)) / (2.0 * step);
  return 0.5 * (hessian + hessian.transpose());
}

// The bare features of a feature found with an offset, whose kind is known but for flat contacts.
bool set_rounded(const geometry::GapFeature& feature, const Rotations& rotations, ContactConstraint& out)
{
  switch (feature.kind) {
    case geometry::ContactKind::reference_edge:
      out.kind = ContactConstraint::Kind::reference_edge;
      break;
    case geometry::ContactKind::moving_edge:
      out.kind = ContactConstraint::Kind::moving_edge;
      break;
    case geometry::ContactKind::vertices:
      out.kind = ContactConstraint::Kind::vertices;
      break;
    default:
      return false;
  }
  out.reference_direction = rotations.of_reference.transpose() * feature.edge;
  out.moving_direction = rotations.of_moving.transpose() * feature.edge;
  return true;
}

}  // namespace

Rotations::Rotations(const Attitude& attitude, double theta_rad)
    : of_reference(reference_rotation(attitude)), of_moving(rotation_y(theta_rad))
{
}

ContactConstraint contact_constraint_of(const geometry::GapFeature& feature, const ConstraintMeshes& meshes,
                                        const Configuration& configuration, const Rotations& rotations)
{
  ContactConstraint out;
  out.triangles = feature.triangles;
  out.reference_mm =
      rotations.of_reference.transpose() * (feature.point_mm + feature.travel_mm * Eigen::Vector3d::UnitY());
  out.moving_mm = rotations.of_moving.transpose() * (feature.point_mm - configuration.pivot_mm);
  if (feature.offset_mm > 0.0) {
    out.offset_mm = feature.offset_mm;
    out.reference_offset_mm = offset_mm(meshes.reference, feature.triangles.reference);
    out.reference_mm -= rotations.of_reference.transpose() * (feature.offset_mm * feature.normal);
    if (set_rounded(feature, rotations, out)) return out;
  }
  const Eigen::Vector3d in_reference = rotations.of_reference.transpose() * feature.normal;
  const Eigen::Vector3d in_moving = rotations.of_moving.transpose() * feature.normal;
  const Eigen::Vector3d n_reference = face_normal(meshes.reference, feature.triangles.reference);
  const Eigen::Vector3d n_moving = face_normal(meshes.moving, feature.triangles.moving);
  out.reference_direction = in_reference;
  out.moving_direction = in_moving;
  out.vertex = corner_at(meshes.moving, feature.triangles.moving, out.moving_mm + meshes.scale.pivot_mm);
  if (out.vertex >= 0 && n_reference.cross(in_reference).norm() < same_direction) return out;
  out.vertex = corner_at(meshes.reference, feature.triangles.reference, out.reference_mm);
  if (out.vertex >= 0 && n_moving.cross(in_moving).norm() < same_direction) {
    out.kind = ContactConstraint::Kind::face_of_moving;
    return out;
  }
  out.vertex = -1;
  geometry::Corners r = corners(meshes.reference, feature.triangles.reference);
  geometry::Corners m = corners(meshes.moving, feature.triangles.moving);
  for (Eigen::Vector3d& p : r) p = rotations.of_reference * p;
  for (Eigen::Vector3d& p : m) p = rotations.of_moving * p;
  out.kind = ContactConstraint::Kind::edges;
  set_edges(r, m, feature.normal, out);
  out.reference_direction = rotations.of_reference.transpose() * out.reference_direction;
  out.moving_direction = rotations.of_moving.transpose() * out.moving_direction;
  return out;
}

Clearance clearance(const ContactConstraint& constraint, const Configuration& configuration,
                    const Rotations& at)
{
  if (constraint.offset_mm > 0.0) return rounded_clearance(constraint, configuration, at);
  const Normal n = common_normal(constraint, at);
  Clearance result;
  if (std::abs(n.n.y()) < parallel_to_delta * n.n.norm()) {
    result.travel_mm = std::numeric_limits<double>::infinity();
    return result;
  }
  const Eigen::Vector3d apart = at.of_reference * constraint.reference_mm -
                                (configuration.pivot_mm + at.of_moving * constraint.moving_mm);
  const Eigen::Vector3d slope = n.n / n.n.y();
  result.travel_mm = apart.dot(slope);
  result.gradient = distance_jacobian(constraint, at).transpose() * slope;
  result.gradient(about_y) += apart.dot(slope_change(n, n.over_theta));
  result.gradient(about_varus) += apart.dot(slope_change(n, n.over_varus));
  return result;
}

Matrix5d clearance_hessian(const ContactConstraint& constraint, const Configuration& configuration,
                           const Rotations& at)
{
  if (constraint.offset_mm > 0.0) return rounded_hessian(constraint, configuration, at);
  const Normal n = common_normal(constraint, at);
  if (std::abs(n.n.y()) < parallel_to_delta * n.n.norm()) return Matrix5d::Zero();
  const Eigen::Vector3d slope = n.n / n.n.y();
  const Eigen::Matrix<double, 3, 5> J = distance_jacobian(constraint, at);
  // Terms proportional to the distance of the points vanish where they coincide.
  Matrix5d half = Matrix5d::Zero();
  half.col(about_y) += J.transpose() * slope_change(n, n.over_theta);
  half.col(about_varus) += J.transpose() * slope_change(n, n.over_varus);
  Matrix5d hessian = half + half.transpose();
  hessian(about_y, about_y) -= slope.dot(about_delta(about_delta(at.of_moving * constraint.moving_mm)));
  hessian(about_varus, about_varus) += slope.dot(about_x(about_x(at.of_reference * constraint.reference_mm)));
  return hessian;
}

Eigen::Vector3d contact_point_mm(const ContactConstraint& constraint, const Configuration& configuration,
                                 const Rotations& at)
{
  if (!(constraint.offset_mm > 0.0)) return at.of_reference * constraint.reference_mm;
  const RoundedContact touch = rounded_travel_of(constraint, configuration, at);
  return touch.reference_mm + constraint.reference_offset_mm * touch.normal;
}

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
