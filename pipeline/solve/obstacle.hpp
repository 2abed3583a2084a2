/// A gap feature kept for other poses: its face or edges extended without end, so that its travel is known
/// exactly, with derivatives, wherever the moving object goes. What the steps of the equilibrium are made of.
#pragma once

#include "proximity/gap_query.hpp"
#include "solve/place.hpp"

namespace vrda {

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
