/// Coordinates and contact constraints of the equilibrium: position of a pivot in the middle of the moving
/// object, rotation theta about it, and varus. A central pivot keeps displacements small for meshes far from
/// their origin. Angles are scaled by a lever to mm, so that one trust radius serves all coordinates.
#pragma once

#include <algorithm>

#include "geometry/gap_query.hpp"
#include "model/coordinates.hpp"
#include "model/mesh.hpp"

namespace vrda::solve {

/// Centre of rotation of one moving object and the radius by which angles become lengths.
struct RotationScale {
  Eigen::Vector3d pivot_mm = Eigen::Vector3d::Zero();  ///< middle of the object, moving frame
  double lever_mm = 1.0;                               ///< half its larger horizontal extent
};

inline RotationScale rotation_scale_of(const Mesh& moving)
{
  const Box box = bounding_box(moving);
  const Eigen::Vector3d middle = 0.5 * (box.min_mm + box.max_mm), size = box.max_mm - box.min_mm;
  return {{middle.x(), 0.0, middle.z()}, std::max(0.5 * std::max(size.x(), size.z()), 1e-6)};
}

/// Configuration of the joint at one flexion.
struct Configuration {
  Eigen::Vector3d pivot_mm = Eigen::Vector3d::Zero();  ///< position of the pivot in S
  double theta_rad = 0.0;
  double varus_rad = 0.0;
};

/// `configuration` after `step`; the angles of `step` are multiplied by the lever, so all are mm.
inline Configuration moved(const Configuration& configuration, const Vector5d& step,
                           const RotationScale& scale)
{
  return {configuration.pivot_mm + step.head<3>(), configuration.theta_rad + step(about_y) / scale.lever_mm,
          configuration.varus_rad + step(about_varus) / scale.lever_mm};
}

/// The step between two configurations, mm; angles multiplied by the lever.
inline Vector5d step_between(const Configuration& from, const Configuration& to, const RotationScale& scale)
{
  Vector5d step;
  step << to.pivot_mm - from.pivot_mm, scale.lever_mm * (to.theta_rad - from.theta_rad),
      scale.lever_mm * (to.varus_rad - from.varus_rad);
  return step;
}

inline MovingPose pose_at(const Configuration& configuration, const RotationScale& scale)
{
  return {configuration.pivot_mm - rotation_y(configuration.theta_rad) * scale.pivot_mm,
          configuration.theta_rad};
}

inline Configuration configuration_at(const MovingPose& pose, double varus_rad, const RotationScale& scale)
{
  return {pose.translation_mm + rotation_y(pose.theta_rad) * scale.pivot_mm, pose.theta_rad, varus_rad};
}

/// A contact constraint made from a gap feature: its face or edges are extended to infinite planes or lines,
/// so that the travel left along Delta and its derivatives are exact at every configuration. The last three
/// kinds need an offset: a cylinder about an edge that meets a vertex, and two spheres.
struct ContactConstraint {
  enum class Kind : std::uint8_t {
    face_of_reference,
    face_of_moving,
    edges,
    reference_edge,
    moving_edge,
    vertices
  };
  Kind kind = Kind::face_of_reference;
  Eigen::Vector3d reference_mm;         ///< point of the reference, S at zero attitude
  Eigen::Vector3d moving_mm;            ///< point of the moving object, relative to its pivot
  Eigen::Vector3d reference_direction;  ///< face normal or edge of the reference, S at zero attitude
  Eigen::Vector3d moving_direction;     ///< face normal or edge of the moving object, moving frame
  geometry::TrianglePair triangles;
  double offset_mm = 0.0;            ///< sum of both offsets (rounded_contact.hpp)
  double reference_offset_mm = 0.0;  ///< that of the reference
  std::int32_t vertex = -1;          ///< touches the face, and belongs to the other object; -1 for edges
};

/// Rotations of both objects at a configuration.
struct Rotations {
  Rotations(const Attitude& attitude, double theta_rad);
  Rotations(const Configuration& configuration, double flexion_rad)
      : Rotations({flexion_rad, configuration.varus_rad}, configuration.theta_rad)
  {
  }
  Eigen::Matrix3d of_reference;
  Eigen::Matrix3d of_moving;
};

/// Both meshes in S at zero attitude and zero pose.
struct ConstraintMeshes {
  const Mesh& reference;
  const Mesh& moving;
  const RotationScale& scale;
};

/// The constraint of `feature`, which was found at `configuration`.
ContactConstraint contact_constraint_of(const geometry::GapFeature& feature, const ConstraintMeshes& meshes,
                                        const Configuration& configuration, const Rotations& rotations);

/// Travel left along Delta and its gradient over the configuration (angles in rad, not scaled). Infinite with
/// a zero gradient where the extended face or edges are parallel to Delta.
struct Clearance {
  double travel_mm = 0.0;
  Vector5d gradient = Vector5d::Zero();
};
Clearance clearance(const ContactConstraint& constraint, const Configuration& configuration,
                    const Rotations& rotations);

/// Hessian of the travel, exact where the travel is zero.
Matrix5d clearance_hessian(const ContactConstraint& constraint, const Configuration& configuration,
                           const Rotations& rotations);

/// Where the constraint acts, S: on the reference's surface, with its offset.
Eigen::Vector3d contact_point_mm(const ContactConstraint& constraint, const Configuration& configuration,
                                 const Rotations& rotations);

// A contact constraint between objects rounded by an offset: distance along its own normal and travel into
// contact, with the points where the force acts. Derivatives follow from these points alone: the distance of
// two bodies changes as that of their nearest points, with the normal held.

/// The bare features of both objects in one frame; directions as in ContactConstraint.
struct PlacedConstraint {
  ContactConstraint::Kind kind = ContactConstraint::Kind::face_of_reference;
  double offset_mm = 0.0;
  Eigen::Vector3d reference_mm, moving_mm, reference_direction, moving_direction;
};

struct RoundedContact {
  double mm = 0.0;               ///< distance or travel; infinite where they pass, the rest is then undefined
  Eigen::Vector3d normal;        ///< unit, reaction on the moving object, against Delta
  Eigen::Vector3d reference_mm;  ///< nearest point of the bare reference
  Eigen::Vector3d moving_mm;     ///< nearest point of the bare moving object, where it is now
};

/// Distance of the rounded features; negative: overlap.
RoundedContact rounded_distance(const PlacedConstraint& constraint, const Eigen::Vector3d& delta);

/// Travel along `delta` until they touch.
RoundedContact rounded_travel(const PlacedConstraint& constraint, const Eigen::Vector3d& delta);

}  // namespace vrda::solve
