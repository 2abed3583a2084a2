/// Vertices, edges and faces of a mesh and how sharply the surface bends at them.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <vector>

#include "core/mesh.hpp"

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

  /// Triangles that share the feature.
  std::vector<std::int32_t> star(const Feature& feature) const;

  /// Largest bend around the feature; 0 for a face.
  double bend(const Feature& feature) const;

 private:
  std::vector<std::array<std::int32_t, 3>> edge_of_triangle_;
  std::vector<std::array<std::int32_t, 2>> edge_vertices_;
  std::vector<std::vector<std::int32_t>> edge_triangles_;
  std::vector<std::vector<std::int32_t>> vertex_triangles_;
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

}  // namespace vrda::contact
