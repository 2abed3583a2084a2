#include "contact/features.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace vrda::contact {
namespace {

// Bend of an edge with one face or more than two: the maximum.
constexpr double open_bend = 2.0;
// Barycentric distance below which a point is on the edge: GJK's points are accurate to 1e-9 of the size.
constexpr double on_edge = 1e-6;

double bend_between(const Mesh& mesh, const std::vector<std::int32_t>& triangles)
{
  if (triangles.size() != 2) return open_bend;
  return 1.0 - face_normal(mesh, triangles[0]).dot(face_normal(mesh, triangles[1]));
}

}  // namespace

SurfaceFeatures::SurfaceFeatures(const Mesh& mesh)
{
  const auto n_triangles = static_cast<std::size_t>(mesh.triangles.rows());
  edge_of_triangle_.resize(n_triangles);
  vertex_triangles_.resize(static_cast<std::size_t>(mesh.vertices_mm.rows()));
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> known;
  for (std::size_t t = 0; t < n_triangles; ++t) {
    const auto row = static_cast<Eigen::Index>(t);
    for (int k = 0; k < 3; ++k) {
      const std::int32_t from = mesh.triangles(row, k), to = mesh.triangles(row, (k + 1) % 3);
      vertex_triangles_[static_cast<std::size_t>(from)].push_back(static_cast<std::int32_t>(t));
      const auto key = std::minmax(from, to);
      const auto [found, is_new] = known.try_emplace(key, static_cast<std::int32_t>(edge_vertices_.size()));
      if (is_new) {
        edge_vertices_.push_back({key.first, key.second});
        edge_triangles_.emplace_back();
      }
      edge_of_triangle_[t][static_cast<std::size_t>(k)] = found->second;
      edge_triangles_[static_cast<std::size_t>(found->second)].push_back(static_cast<std::int32_t>(t));
    }
  }
  vertex_bend_.assign(vertex_triangles_.size(), 0.0);
  for (std::size_t e = 0; e < edge_vertices_.size(); ++e) {
    edge_bend_.push_back(bend_between(mesh, edge_triangles_[e]));
    for (const std::int32_t v : edge_vertices_[e]) {
      double& bend = vertex_bend_[static_cast<std::size_t>(v)];
      bend = std::max(bend, edge_bend_[e]);
    }
  }
}

std::vector<std::int32_t> SurfaceFeatures::star(const Feature& feature) const
{
  switch (feature.kind) {
    case FeatureKind::vertex:
      return vertex_triangles_[static_cast<std::size_t>(feature.index)];
    case FeatureKind::edge:
      return edge_triangles_[static_cast<std::size_t>(feature.index)];
    case FeatureKind::face:
      break;
  }
  return {feature.index};
}

double SurfaceFeatures::bend(const Feature& feature) const
{
  switch (feature.kind) {
    case FeatureKind::vertex:
      return vertex_bend_[static_cast<std::size_t>(feature.index)];
    case FeatureKind::edge:
      return edge_bend_[static_cast<std::size_t>(feature.index)];
    case FeatureKind::face:
      break;
  }
  return 0.0;
}

Feature feature_at(const Mesh& mesh, const SurfaceFeatures& features, std::int32_t t,
                   const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 3>& corner)
{
  const Eigen::Vector3d n = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  const double area_sq = n.squaredNorm();
  std::array<bool, 3> is_zero{};  // weight of corner k vanishes: p is on the opposite edge
  int n_zero = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d& a = corner[(k + 1) % 3];
    const Eigen::Vector3d& b = corner[(k + 2) % 3];
    const double weight = n.dot((b - a).cross(p - a)) / area_sq;
    is_zero[k] = weight < on_edge;
    n_zero += is_zero[k] ? 1 : 0;
  }
  if (n_zero == 0) return {FeatureKind::face, t};
  for (int k = 0; k < 3; ++k) {
    const auto at = static_cast<std::size_t>(k);
    if (n_zero == 1 && is_zero[at]) return {FeatureKind::edge, features.edge_of(t, (k + 1) % 3)};
    if (n_zero >= 2 && !is_zero[at]) return {FeatureKind::vertex, mesh.triangles(t, k)};
  }
  return {FeatureKind::face, t};
}

namespace {

// Largest distance of a face from its neighbour's plane, relative to the largest coordinate, at which both
// are coplanar: a few roundings of transformed vertices.
constexpr double flat_share = 1e-13;

// Whether a corner of `other` is behind the plane of `face` by more than rounding, as across a convex edge.
bool is_behind(const Mesh& mesh, std::int32_t face, std::int32_t other, double flat_mm)
{
  const Eigen::Vector3d normal = face_normal(mesh, face), at = corners(mesh, face)[0];
  for (const Eigen::Vector3d& p : corners(mesh, other)) {
    if (normal.dot(p - at) < -flat_mm) return true;
  }
  return false;
}

}  // namespace

std::vector<bool> protruding_vertices(const Mesh& mesh, const SurfaceFeatures& features)
{
  std::vector<bool> sticks(static_cast<std::size_t>(mesh.vertices_mm.rows()), false);
  const double flat_mm =
      mesh.vertices_mm.rows() > 0 ? flat_share * mesh.vertices_mm.cwiseAbs().maxCoeff() : 0.0;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const std::int32_t edge = features.edge_of(static_cast<std::int32_t>(t), k);
      const std::vector<std::int32_t> faces = features.star({FeatureKind::edge, edge});
      const bool is_inner = faces.size() == 2 && !is_behind(mesh, faces[0], faces[1], flat_mm) &&
                            !is_behind(mesh, faces[1], faces[0], flat_mm);
      if (is_inner) continue;
      for (const std::int32_t v : features.edge_vertices(edge)) sticks[static_cast<std::size_t>(v)] = true;
    }
  }
  return sticks;
}

}  // namespace vrda::contact
