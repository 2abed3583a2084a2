#include "contact/features.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace vrda::contact {
namespace {

// Bend of an edge with one face or more than two: the maximum.
constexpr double open_bend = 2.0;
// Barycentric distance below which a point is on the edge: GJK's points are accurate to 1e-9 of the size.
constexpr double on_edge = 1e-6;

double bend_between(const Mesh& mesh, std::span<const std::int32_t> triangles)
{
  if (triangles.size() != 2) return open_bend;
  return 1.0 - face_normal(mesh, triangles[0]).dot(face_normal(mesh, triangles[1]));
}

}  // namespace

// Edges in the order of their first use.
void SurfaceFeatures::number_edges(const Mesh& mesh)
{
  struct Use {
    std::int32_t low, high, place;  // place: 3 * triangle + corner
  };
  const auto n_uses = static_cast<std::int32_t>(3 * mesh.triangles.rows());
  const auto corner = [&](std::int32_t place) { return mesh.triangles(place / 3, place % 3); };
  const auto next = [](std::int32_t place) { return place - place % 3 + (place + 1) % 3; };
  std::vector<Use> uses;
  uses.reserve(static_cast<std::size_t>(n_uses));
  for (std::int32_t place = 0; place < n_uses; ++place) {
    const auto [low, high] = std::minmax({corner(place), corner(next(place))});
    uses.push_back({low, high, place});
  }
  std::sort(uses.begin(), uses.end(), [](const Use& a, const Use& b) {
    return std::tie(a.low, a.high, a.place) < std::tie(b.low, b.high, b.place);
  });
  std::vector<std::int32_t> first(uses.size());  // [place] of the first use of the same edge
  for (std::size_t i = 0; i < uses.size(); ++i) {
    const bool is_same = i > 0 && uses[i - 1].low == uses[i].low && uses[i - 1].high == uses[i].high;
    const std::int32_t place = uses[i].place;
    first[static_cast<std::size_t>(place)] =
        is_same ? first[static_cast<std::size_t>(uses[i - 1].place)] : place;
  }
  uses = {};
  edge_of_triangle_.resize(static_cast<std::size_t>(mesh.triangles.rows()));
  const auto edge_at = [&](std::int32_t place) -> std::int32_t& {
    return edge_of_triangle_[static_cast<std::size_t>(place / 3)][static_cast<std::size_t>(place % 3)];
  };
  for (std::int32_t place = 0; place < n_uses; ++place) {
    const std::int32_t known = first[static_cast<std::size_t>(place)];
    edge_at(place) = known == place ? static_cast<std::int32_t>(edge_vertices_.size()) : edge_at(known);
    if (known != place) continue;
    const auto [low, high] = std::minmax({corner(place), corner(next(place))});
    edge_vertices_.push_back({low, high});
  }
}

SurfaceFeatures::Stars SurfaceFeatures::stars_of(const std::vector<Corners3>& rows, std::size_t n)
{
  Stars stars;
  stars.begin.assign(n + 1, 0);
  for (const Corners3& row : rows) {
    for (const std::int32_t i : row) ++stars.begin[static_cast<std::size_t>(i) + 1];
  }
  std::partial_sum(stars.begin.begin(), stars.begin.end(), stars.begin.begin());
  stars.triangles.resize(3 * rows.size());
  std::vector<std::size_t> end(stars.begin.begin(), stars.begin.end() - 1);
  for (std::size_t t = 0; t < rows.size(); ++t) {
    for (const std::int32_t i : rows[t])
      stars.triangles[end[static_cast<std::size_t>(i)]++] = static_cast<std::int32_t>(t);
  }
  return stars;
}

SurfaceFeatures::SurfaceFeatures(const Mesh& mesh)
{
  number_edges(mesh);
  edge_triangles_ = stars_of(edge_of_triangle_, edge_vertices_.size());
  std::vector<Corners3> rows(edge_of_triangle_.size());
  for (std::size_t t = 0; t < rows.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k)
      rows[t][k] = mesh.triangles(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(k));
  }
  vertex_triangles_ = stars_of(rows, static_cast<std::size_t>(mesh.vertices_mm.rows()));
  vertex_bend_.assign(static_cast<std::size_t>(mesh.vertices_mm.rows()), 0.0);
  edge_bend_.reserve(edge_vertices_.size());
  for (std::size_t e = 0; e < edge_vertices_.size(); ++e) {
    edge_bend_.push_back(bend_between(mesh, edge_star(static_cast<std::int32_t>(e))));
    for (const std::int32_t v : edge_vertices_[e]) {
      double& bend = vertex_bend_[static_cast<std::size_t>(v)];
      bend = std::max(bend, edge_bend_[e]);
    }
  }
}

std::vector<std::int32_t> SurfaceFeatures::star(const Feature& feature) const
{
  if (feature.kind == FeatureKind::face) return {feature.index};
  const std::span<const std::int32_t> triangles =
      (feature.kind == FeatureKind::vertex ? vertex_triangles_ : edge_triangles_).of(feature.index);
  return {triangles.begin(), triangles.end()};
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
      const std::span<const std::int32_t> faces = features.edge_star(edge);
      const bool is_inner = faces.size() == 2 && !is_behind(mesh, faces[0], faces[1], flat_mm) &&
                            !is_behind(mesh, faces[1], faces[0], flat_mm);
      if (is_inner) continue;
      for (const std::int32_t v : features.edge_vertices(edge)) sticks[static_cast<std::size_t>(v)] = true;
    }
  }
  return sticks;
}

}  // namespace vrda::contact
