#include "solve/obstacle.hpp"

#include <Eigen/Geometry>
#include <limits>

namespace vrda {
namespace {

// A feature's normal is a face's when the sine between them is below this: normals of thin triangles carry
// 1e-10 of rounding.
constexpr double same_direction = 1e-7;
// One point seen through both objects' rotations.
constexpr double same_point_mm = 1e-9;
// Height of a unit normal below which an extended face stands upright.
constexpr double upright = 1e-6;

Eigen::Vector3d about_x(const Eigen::Vector3d& v)
{
  return {0.0, -v.z(), v.y()};
}

Eigen::Vector3d about_delta(const Eigen::Vector3d& v)
{
  return {v.z(), 0.0, -v.x()};
}

// Row of the triangle's corner that lies at `p`, or -1.
std::int32_t corner_at(const Mesh& mesh, std::int32_t triangle, const Eigen::Vector3d& p)
{
  for (Eigen::Index k = 0; k < 3; ++k) {
    const std::int32_t v = mesh.triangles(triangle, k);
    if ((mesh.vertices_mm.row(v).transpose() - p).cwiseAbs().maxCoeff() <= same_point_mm) return v;
  }
  return -1;
}

// The two edges, unit, most nearly across `normal` together.
void take_edges(const Corners& reference, const Corners& moving, const Eigen::Vector3d& normal, Obstacle& out)
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

// The common normal and its derivatives over theta and varus, before scaling.
struct Normal {
  Eigen::Vector3d n, over_theta, over_varus;
};

Normal common_normal(const Obstacle& o, const Rotations& at)
{
  switch (o.kind) {
    case Obstacle::Kind::face_of_reference: {
      const Eigen::Vector3d n = at.of_reference * o.reference_direction;
      return {n, Eigen::Vector3d::Zero(), -about_x(n)};
    }
    case Obstacle::Kind::face_of_moving: {
      const Eigen::Vector3d n = at.of_moving * o.moving_direction;
      return {n, about_delta(n), Eigen::Vector3d::Zero()};
    }
    case Obstacle::Kind::edges:
      break;
  }
  const Eigen::Vector3d u = at.of_reference * o.reference_direction, v = at.of_moving * o.moving_direction;
  return {u.cross(v), u.cross(about_delta(v)), -about_x(u).cross(v)};
}

// d (n / n.y).
Eigen::Vector3d slope_change(const Normal& n, const Eigen::Vector3d& change)
{
  return (change - n.n * (change.y() / n.n.y())) / n.n.y();
}

// How fast reference point minus moving point changes.
Eigen::Matrix<double, 3, 5> distance_jacobian(const Obstacle& o, const Rotations& at)
{
  Eigen::Matrix<double, 3, 5> J;
  J.leftCols<3>() = -Eigen::Matrix3d::Identity();
  J.col(about_y) = -about_delta(at.of_moving * o.moving_mm);
  J.col(about_varus) = -about_x(at.of_reference * o.reference_mm);
  return J;
}

}  // namespace

Rotations::Rotations(const Place& place, double flexion_rad)
    : of_reference(reference_rotation({flexion_rad, place.varus_rad})), of_moving(rotation_y(place.theta_rad))
{
}

Obstacle obstacle_of(const GapFeature& feature, const TouchingMeshes& meshes, const Place& place,
                     const Rotations& rotations)
{
  Obstacle out;
  out.triangles = feature.triangles;
  out.reference_mm =
      rotations.of_reference.transpose() * (feature.point_mm + feature.travel_mm * Eigen::Vector3d::UnitY());
  out.moving_mm = rotations.of_moving.transpose() * (feature.point_mm - place.pivot_mm);
  const Eigen::Vector3d in_reference = rotations.of_reference.transpose() * feature.normal;
  const Eigen::Vector3d in_moving = rotations.of_moving.transpose() * feature.normal;
  const Eigen::Vector3d n_reference = face_normal(meshes.reference, feature.triangles.reference);
  const Eigen::Vector3d n_moving = face_normal(meshes.moving, feature.triangles.moving);
  out.reference_direction = in_reference;
  out.moving_direction = in_moving;
  out.vertex = corner_at(meshes.moving, feature.triangles.moving, out.moving_mm + meshes.grip.pivot_mm);
  if (out.vertex >= 0 && n_reference.cross(in_reference).norm() < same_direction) return out;
  out.vertex = corner_at(meshes.reference, feature.triangles.reference, out.reference_mm);
  if (out.vertex >= 0 && n_moving.cross(in_moving).norm() < same_direction) {
    out.kind = Obstacle::Kind::face_of_moving;
    return out;
  }
  out.vertex = -1;
  Corners r = corners(meshes.reference, feature.triangles.reference);
  Corners m = corners(meshes.moving, feature.triangles.moving);
  for (Eigen::Vector3d& p : r) p = rotations.of_reference * p;
  for (Eigen::Vector3d& p : m) p = rotations.of_moving * p;
  out.kind = Obstacle::Kind::edges;
  take_edges(r, m, feature.normal, out);
  out.reference_direction = rotations.of_reference.transpose() * out.reference_direction;
  out.moving_direction = rotations.of_moving.transpose() * out.moving_direction;
  return out;
}

Clearance clearance(const Obstacle& o, const Place& place, const Rotations& at)
{
  const Normal n = common_normal(o, at);
  Clearance result;
  if (std::abs(n.n.y()) < upright * n.n.norm()) {
    result.travel_mm = std::numeric_limits<double>::infinity();
    return result;
  }
  const Eigen::Vector3d apart =
      at.of_reference * o.reference_mm - (place.pivot_mm + at.of_moving * o.moving_mm);
  const Eigen::Vector3d slope = n.n / n.n.y();
  result.travel_mm = apart.dot(slope);
  result.gradient = distance_jacobian(o, at).transpose() * slope;
  result.gradient(about_y) += apart.dot(slope_change(n, n.over_theta));
  result.gradient(about_varus) += apart.dot(slope_change(n, n.over_varus));
  return result;
}

Matrix5d clearance_bend(const Obstacle& o, const Rotations& at)
{
  const Normal n = common_normal(o, at);
  if (std::abs(n.n.y()) < upright * n.n.norm()) return Matrix5d::Zero();
  const Eigen::Vector3d slope = n.n / n.n.y();
  const Eigen::Matrix<double, 3, 5> J = distance_jacobian(o, at);
  // Where both points meet, terms with their distance vanish.
  Matrix5d half = Matrix5d::Zero();
  half.col(about_y) += J.transpose() * slope_change(n, n.over_theta);
  half.col(about_varus) += J.transpose() * slope_change(n, n.over_varus);
  Matrix5d bend = half + half.transpose();
  bend(about_y, about_y) -= slope.dot(about_delta(about_delta(at.of_moving * o.moving_mm)));
  bend(about_varus, about_varus) += slope.dot(about_x(about_x(at.of_reference * o.reference_mm)));
  return bend;
}

}  // namespace vrda
