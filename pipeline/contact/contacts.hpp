/// Vertices, edges and faces of a mesh and how sharply the surface bends at them.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "contact/narrow_phase.hpp"
#include "geometry/gap_query.hpp"
#include "geometry/placement.hpp"
#include "model/mesh.hpp"
#include "model/step_record.hpp"

namespace vrda::contact {

enum class FeatureKind : std::int8_t { vertex, edge, face };

/// A vertex, edge or face of one mesh.
struct Feature {
  FeatureKind kind = FeatureKind::face;
  std::int32_t index = -1;
  auto operator<=>(const Feature&) const = default;
};

/// Connectivity and bend of a mesh. The bend is 1 - cos of the angle between the normals of two neighbouring
/// faces: 0 when flat, 2 at an open edge. It is invariant under rigid motion.
class SurfaceFeatures {
 public:
  SurfaceFeatures() = default;
  explicit SurfaceFeatures(const Mesh& mesh);

  /// Edge k of triangle t runs from its corner k to corner (k + 1) % 3.
  std::int32_t edge_of(std::int32_t triangle, int k) const
  {
    return edge_of_triangle_[static_cast<std::size_t>(triangle)][static_cast<std::size_t>(k)];
  }
  std::array<std::int32_t, 2> edge_vertices(std::int32_t edge) const
  {
    return edge_vertices_[static_cast<std::size_t>(edge)];
  }

  /// Triangles that share the feature, ascending.
  std::vector<std::int32_t> star(const Feature& feature) const;
  std::span<const std::int32_t> edge_star(std::int32_t edge) const { return edge_triangles_.of(edge); }

  /// Largest bend around the feature; 0 for a face.
  double bend(const Feature& feature) const;

 private:
  // Lists of triangles, one for each edge or vertex, in one array.
  struct Stars {
    std::vector<std::int32_t> triangles;
    std::vector<std::size_t> begin;  // [n + 1]
    std::span<const std::int32_t> of(std::int32_t i) const
    {
      const std::size_t first = begin[static_cast<std::size_t>(i)];
      return {triangles.data() + first, begin[static_cast<std::size_t>(i) + 1] - first};
    }
  };
  using Corners3 = std::array<std::int32_t, 3>;
  static Stars stars_of(const std::vector<Corners3>& rows, std::size_t n);
  void number_edges(const Mesh& mesh);

  std::vector<std::array<std::int32_t, 3>> edge_of_triangle_;
  std::vector<std::array<std::int32_t, 2>> edge_vertices_;
  Stars edge_triangles_, vertex_triangles_;
  std::vector<double> edge_bend_;
  std::vector<double> vertex_bend_;
};

/// The feature of triangle `t` that contains `p`, given the current positions of the corners. A point within
/// a millionth of the triangle's size of an edge or corner belongs to it.
Feature feature_at(const Mesh& mesh, const SurfaceFeatures& features, std::int32_t t,
                   const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 3>& corner);

/// [n_vertices] whether a convex, boundary or non-manifold edge ends at the vertex. Around any other vertex
/// the surface is flat or concave: another point touches a face no later, so the vertex itself carries no
/// load.
std::vector<bool> protruding_vertices(const Mesh& mesh, const SurfaceFeatures& features);

// Contact points and normals of two meshes at a pose (thesis 3.3 and 3.7).

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
                                                     const geometry::TreeMesh& moving, const MovingPose& pose,
                                                     NarrowPhase& narrow_phase,
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
  const geometry::TreeMesh& reference;        ///< rotated to its attitude
  const SurfaceFeatures& reference_features;  ///< of the same mesh in any attitude
  const Collider& moving;
  /// Every pair within the band, and others; null: found by the trees.
  const std::vector<geometry::TrianglePair>* candidates = nullptr;
};

/// Contacts within the band whose normals oppose Delta, nearest first. Overlapping pairs of triangles give no
/// contact, so the objects should not overlap.
std::vector<Contact> find_contacts(const ContactObjects& objects, const MovingPose& pose,
                                   NarrowPhase& narrow_phase, const ContactOptions& options);
/// The same without a rotated copy of the reference, which is at zero attitude.
std::vector<Contact> find_contacts(const ContactObjects& objects, const Attitude& attitude,
                                   const MovingPose& pose, NarrowPhase& narrow_phase,
                                   const ContactOptions& options);

}  // namespace vrda::contact
