/// The equilibrium's own coordinates: where the middle of the moving object stands, its turn, and varus.
/// Turning about the middle keeps a mesh far from its origin from swinging through space, and angles times a
/// lever are millimetres, so that one trust radius fits all.
#pragma once

#include <algorithm>

#include "core/coordinates.hpp"
#include "core/mesh.hpp"
#include "proximity/gap_query.hpp"

namespace vrda {

/// Of one moving object.
struct Grip {
  Eigen::Vector3d pivot_mm = Eigen::Vector3d::Zero();  ///< middle of the object, in its own frame
  double lever_mm = 1.0;                               ///< half its larger horizontal extent
};

inline Grip grip_of(const Mesh& moving)
{
  const Box box = bounding_box(moving);
  const Eigen::Vector3d middle = 0.5 * (box.min_mm + box.max_mm), size = box.max_mm - box.min_mm;
  return {{middle.x(), 0.0, middle.z()}, std::max(0.5 * std::max(size.x(), size.z()), 1e-6)};
}

struct Place {
  Eigen::Vector3d pivot_mm = Eigen::Vector3d::Zero();  ///< where the pivot stands, S
  double theta_rad = 0.0;
  double varus_rad = 0.0;
};

/// Angles of `step` are times the lever: all mm.
inline Place moved(const Place& place, const Vector5d& step, const Grip& grip)
{
  return {place.pivot_mm + step.head<3>(), place.theta_rad + step(about_y) / grip.lever_mm,
          place.varus_rad + step(about_varus) / grip.lever_mm};
}

/// The step from one place to another, angles times the lever.
inline Vector5d step_between(const Place& from, const Place& to, const Grip& grip)
{
  Vector5d step;
  step << to.pivot_mm - from.pivot_mm, grip.lever_mm * (to.theta_rad - from.theta_rad),
      grip.lever_mm * (to.varus_rad - from.varus_rad);
  return step;
}

inline MovingPose pose_at(const Place& place, const Grip& grip)
{
  return {place.pivot_mm - rotation_y(place.theta_rad) * grip.pivot_mm, place.theta_rad};
}

inline Place place_at(const MovingPose& pose, double varus_rad, const Grip& grip)
{
  return {pose.translation_mm + rotation_y(pose.theta_rad) * grip.pivot_mm, pose.theta_rad, varus_rad};
}

/// A gap feature kept for other poses: its face or edges extended without end, so that its travel is known
/// exactly, with derivatives, wherever the moving object goes. What the steps of the equilibrium are made of.
struct Obstacle {
  enum class Kind : std::uint8_t { face_of_reference, face_of_moving, edges };
  Kind kind = Kind::face_of_reference;
  Eigen::Vector3d reference_mm;         ///< a point of the reference, zero attitude
  Eigen::Vector3d moving_mm;            ///< a point of the moving object, from its pivot
  Eigen::Vector3d reference_direction;  ///< face normal or edge of the reference, zero attitude
  Eigen::Vector3d moving_direction;     ///< face normal or edge of the moving object, its own frame
  TrianglePair triangles;
  std::int32_t vertex =
      -1;  ///< that touches the face; of the moving object where the face is the reference's
};

/// Both objects' rotations at a place.
struct Rotations {
  Rotations(const Place& place, double flexion_rad);
  Eigen::Matrix3d of_reference;
  Eigen::Matrix3d of_moving;
};

/// Both meshes in S at zero attitude and zero pose.
struct TouchingMeshes {
  const Mesh& reference;
  const Mesh& moving;
  const Grip& grip;
};

/// `feature` as found at `place`.
Obstacle obstacle_of(const GapFeature& feature, const TouchingMeshes& meshes, const Place& place,
                     const Rotations& rotations);

/// Travel left and its derivatives over a Place's coordinates (angles in rad, not times the lever). Infinite,
/// with no derivatives, where the extended edges or face have turned upright.
struct Clearance {
  double travel_mm = 0.0;
  Vector5d gradient = Vector5d::Zero();
};
Clearance clearance(const Obstacle& obstacle, const Place& place, const Rotations& rotations);

/// Second derivatives of the travel, exact where it is zero.
Matrix5d clearance_bend(const Obstacle& obstacle, const Rotations& rotations);

}  // namespace vrda
