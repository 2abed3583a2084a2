/// Pairs of features that may be in contact: closest points by the narrow phase, one candidate a pair of
/// features.
#pragma once

#include <optional>
#include <vector>

#include "contact/contacts.hpp"
#include "contact/narrow_phase.hpp"

namespace vrda::contact {

/// Sine below which two edges are parallel and their cross product has no direction.
constexpr double parallel_edges = 1e-6;

/// Closest points of a pair of bare triangles and the features that they lie on, in the reference's frame.
struct Candidate {
  geometry::TrianglePair pair;
  double distance_mm = 0.0;  ///< less both offsets
  Eigen::Vector3d p_reference_mm;
  Eigen::Vector3d p_moving_mm;
  Feature reference;
  Feature moving;
};

/// Two objects in the reference's frame.
struct Scene {
  const geometry::TreeMesh& reference;
  const SurfaceFeatures& reference_features;
  const Collider& moving;
  geometry::RigidPlacement place;  // of the moving object in the reference's frame
  NarrowPhase& narrow_phase;
  const ContactOptions& options;
  const std::vector<geometry::TrianglePair>* candidates;  // null: pairs from the trees

  double offset_mm(const geometry::TrianglePair& pair) const
  {
    return vrda::offset_mm(reference.mesh, pair.reference) +
           vrda::offset_mm(moving.tree_mesh.mesh, pair.moving);
  }
  double overlap_mm(const geometry::TrianglePair& pair) const
  {
    return vrda::overlap_mm(reference.mesh, pair.reference) +
           vrda::overlap_mm(moving.tree_mesh.mesh, pair.moving);
  }
  geometry::Corners reference_corners(const geometry::TrianglePair& pair) const
  {
    return corners(reference.mesh, pair.reference);
  }
  geometry::Corners moving_corners(const geometry::TrianglePair& pair) const
  {
    return place(corners(moving.tree_mesh.mesh, pair.moving));
  }
};
/// Of a part with an allowed overlap only the side that faces the other object along Delta counts: where it
/// is thinner than twice that, the limit of its far side is in front (inward_limit). All in the reference's
/// frame.
bool is_near_side(const Mesh& reference, const Mesh& moving, const geometry::TrianglePair& pair,
                  const geometry::Corners& r, const geometry::Corners& m, const Eigen::Vector3d& delta);

/// All pairs within the band with their distances in closed form, sorted by pair; their features are not set.
std::vector<Candidate> close_pairs(const Scene& scene);

/// The candidate with distance, points and features of the narrow phase; empty if that finds an overlap.
std::optional<Candidate> measured(const Scene& scene, Candidate candidate);

/// One candidate for each pair of features in contact, of the pairs of close_pairs, by the narrow phase.
std::vector<Candidate> touching_features(const Scene& scene, const std::vector<Candidate>& pairs);

}  // namespace vrda::contact
