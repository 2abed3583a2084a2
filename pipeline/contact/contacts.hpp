/// Contact points and normals of two meshes at a pose (thesis 3.3 and 3.7).
#pragma once

#include <optional>
#include <vector>

#include "contact/features.hpp"
#include "contact/narrow_phase.hpp"
#include "model/solver_options.hpp"
#include "geometry/gap_query.hpp"
#include "geometry/placement.hpp"

namespace vrda::contact {

/// A mesh in the solver frame with bounding-volume tree and connectivity.
struct Collider {
  geometry::TreeMesh tree_mesh;
  SurfaceFeatures features;
};

Collider make_collider(Mesh mesh);

/// One contact between two features. All in the solver frame S.
struct Contact {
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< on the reference's surface
  /// Point of application of the reaction, on the surface that gave the normal; crossing edges: the
  /// reference.
  Eigen::Vector3d application_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, direction of the reaction on the moving object
  double distance_mm = 0.0;
  geometry::TrianglePair triangles;
};

struct ContactOptions {
  double band_mm = 0.1;  ///< features closer than this are in contact
  /// Slope (rad) towards a nearer neighbour up to which a feature counts as a separate contact.
  double slope_rad = 0.0017;
  ContactPoints points = ContactPoints::exact;
  ContactNormals normals = ContactNormals::least_curvature;
};

/// The first intersecting pair of triangles found, if any; `hint` is tried first.
/// `reference` is rotated to its attitude.
std::optional<geometry::TrianglePair> find_collision(const geometry::TreeMesh& reference,
                                                      const geometry::TreeMesh& moving,
                                                      const MovingPose& pose, NarrowPhase& narrow_phase,
                                                      const geometry::TrianglePair& hint = {});
/// The same with the moving object placed in the reference's own frame by any rigid motion.
std::optional<geometry::TrianglePair> find_collision(const geometry::TreeMesh& reference,
                                                      const geometry::TreeMesh& moving,
                                                      const geometry::RigidPlacement& place,
                                                      NarrowPhase& narrow_phase,
                                                      const geometry::TrianglePair& hint = {});

/// The same with pairs from `pairs`, a query between both meshes at the attitude of `reference`: three times
/// as fast.
std::optional<geometry::TrianglePair> find_collision(const Mesh& reference, const Mesh& moving,
                                                      const MovingPose& pose, geometry::GapQuery& pairs,
                                                      NarrowPhase& narrow_phase,
                                                      const geometry::TrianglePair& hint = {});

/// The same with the reference at zero attitude and the moving object placed there by `place`: `pose` is its
/// pose at the attitude of `pairs`.
std::optional<geometry::TrianglePair> find_collision(const Mesh& reference, const Mesh& moving,
                                                      const geometry::RigidPlacement& place,
                                                      const MovingPose& pose, geometry::GapQuery& pairs,
                                                      NarrowPhase& narrow_phase,
                                                      const geometry::TrianglePair& hint = {});

/// Pairs of triangles of one mesh that intersect without a common vertex, at most `limit`; each once, smaller
/// row first. Neighbours in a welded mesh share vertices, so a valid mesh has none.
std::vector<geometry::TrianglePair> find_self_overlaps(const geometry::TreeMesh& mesh,
                                                        NarrowPhase& narrow_phase, std::size_t limit);

/// The two objects of a contact query.
struct ContactObjects {
  const geometry::TreeMesh& reference;       ///< rotated to its attitude
  const SurfaceFeatures& reference_features;  ///< of the same mesh in any attitude
  const Collider& moving;
  /// Every pair within the band, and others; null: found by the trees.
  const std::vector<geometry::TrianglePair>* candidates = nullptr;
};

/// Pose of both objects in S.
struct ObjectPoses {
  Attitude attitude;
  MovingPose pose;
};

/// Contacts within the band whose normals oppose Delta, nearest first. Overlapping pairs of triangles give no
/// contact, so the objects should not overlap.
std::vector<Contact> find_contacts(const ContactObjects& objects, const MovingPose& pose,
                                   NarrowPhase& narrow_phase, const ContactOptions& options);
/// The same without a rotated copy of the reference: `reference` is at zero attitude, `candidates` contain
/// every pair within the band (GapQuery::close_pairs).
std::vector<Contact> find_contacts(const Collider& reference, const Collider& moving,
                                   const ObjectPoses& standing,
                                   const std::vector<geometry::TrianglePair>& candidates,
                                   NarrowPhase& narrow_phase, const ContactOptions& options);

}  // namespace vrda::contact
