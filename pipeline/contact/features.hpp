/// Vertices, edges and faces of a mesh and how sharply the surface bends at them.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

#include "model/mesh.hpp"

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

}  // namespace vrda::contact
