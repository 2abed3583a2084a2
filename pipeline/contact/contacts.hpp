/// Contact points and normals of two meshes at a pose (thesis 3.3 and 3.7, DESIGN.md 5.1 step 2).
#pragma once

#include <optional>
#include <vector>

#include "contact/features.hpp"
#include "contact/narrow_phase.hpp"
#include "core/solver_options.hpp"
#include "proximity/placed.hpp"

namespace vrda {

/// A mesh that can touch: in the solver frame, with tree and connectivity.
struct Collider {
  TreeMesh solid;
  SurfaceFeatures features;
};

Collider make_collider(Mesh mesh);

/// One touching feature. All in the solver frame S.
struct Contact {
  Eigen::Vector3d point_mm = Eigen::Vector3d::Zero();  ///< on the reference's surface
  /// On the surface that gave the normal, where the reaction acts; crossing edges: on the reference.
  Eigen::Vector3d application_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< unit, direction of the reaction on the moving object
  double distance_mm = 0.0;
  TrianglePair triangles;
};

struct ContactOptions {
  double band_mm = 0.1;  ///< features closer than this touch
  /// Slope (rad) towards a nearer neighbour below which a feature still counts as touching by itself.
  double slope_rad = 0.0017;
  ContactPoints points = ContactPoints::exact;
  ContactNormals normals = ContactNormals::least_curvature;
};

/// The first pair found to share a point, if any; `hint` is tried first.
/// `reference` is turned to its attitude.
std::optional<TrianglePair> find_collision(const TreeMesh& reference, const TreeMesh& moving,
                                           const MovingPose& pose, NarrowPhase& narrow_phase,
                                           const TrianglePair& hint = {});
/// The same with the moving object placed in the reference's own frame by any rigid motion: nothing is
/// turned.
std::optional<TrianglePair> find_collision(const TreeMesh& reference, const TreeMesh& moving,
                                           const RigidPlacement& place, NarrowPhase& narrow_phase,
                                           const TrianglePair& hint = {});

/// Pairs of triangles of one mesh that share a point but no vertex, at most `limit` of them; each once,
/// with the smaller row first. A weld makes neighbours share vertices, so a sound mesh has none.
std::vector<TrianglePair> find_self_overlaps(const TreeMesh& mesh, NarrowPhase& narrow_phase,
                                             std::size_t limit);

/// The two objects whose contacts are asked for.
struct Touching {
  const TreeMesh& reference;                  ///< turned to its attitude
  const SurfaceFeatures& reference_features;  ///< of the same mesh in any attitude
  const Collider& moving;
};

/// Where both objects stand in S.
struct Standing {
  Attitude attitude;
  MovingPose pose;
};

/// Contacts within the band whose normals oppose Delta, nearest first. The objects should not overlap;
/// overlapping pairs give no contact.
std::vector<Contact> find_contacts(const Touching& objects, const MovingPose& pose, NarrowPhase& narrow_phase,
                                   const ContactOptions& options);
/// The same of a reference at zero attitude, which is not copied and turned, among `candidates`: pairs that
/// hold all that come within the band (GapQuery::close_pairs).
std::vector<Contact> find_contacts(const Collider& reference, const Collider& moving,
                                   const Standing& standing, const std::vector<TrianglePair>& candidates,
                                   NarrowPhase& narrow_phase, const ContactOptions& options);

}  // namespace vrda
