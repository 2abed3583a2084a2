#include "geometry/gap_features.hpp"

#include <algorithm>
#include <tuple>

namespace vrda::geometry {
namespace {

// A point computed from different triangles differs by rounding: coordinates of 100 mm, divided by sines of
// facets down to 1e-3.
constexpr double same_travel_mm = 1e-10;
constexpr double same_point_mm = 1e-9;
constexpr double same_normal = 1e-9;

Eigen::Vector3d unit_normal(const Corners& c)
{
  return (c[1] - c[0]).cross(c[2] - c[0]).normalized();
}

bool is_same(const GapFeature& a, const GapFeature& b)
{
  return (a.point_mm - b.point_mm).cwiseAbs().maxCoeff() <= same_point_mm &&
         (a.normal - b.normal).cwiseAbs().maxCoeff() <= same_normal;
}

// A vertex and a face, or two edges, of the moving and of the reference mesh.
FeatureKey key_of(const Mesh& r, const Mesh& m, const NearCandidate& candidate)
{
  const auto both = [](std::int32_t first, std::int32_t second) {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(first)) << 32U |
           static_cast<std::uint32_t>(second);
  };
  const auto vertex = [](const Mesh& mesh, std::int32_t row, unsigned corner) {
    return mesh.triangles(row, static_cast<Eigen::Index>(corner % 3));
  };
  const auto edge = [&](const Mesh& mesh, std::int32_t row, unsigned corner) {
    const auto [low, high] = std::minmax({vertex(mesh, row, corner), vertex(mesh, row, corner + 1)});
    return both(low, high);
  };
  const auto& [pair, at] = candidate;
  switch (at.kind) {
    case ContactKind::moving_vertex:
      return {both(pair.reference, -1), both(vertex(m, pair.moving, at.moving), -1)};
    case ContactKind::reference_vertex:
      return {both(vertex(r, pair.reference, at.reference), -2), both(pair.moving, -2)};
    case ContactKind::reference_edge:
      return {edge(r, pair.reference, at.reference), both(vertex(m, pair.moving, at.moving), -3)};
    case ContactKind::moving_edge:
      return {both(vertex(r, pair.reference, at.reference), -4), edge(m, pair.moving, at.moving)};
    case ContactKind::vertices:
      return {both(vertex(r, pair.reference, at.reference), -5), both(vertex(m, pair.moving, at.moving), -5)};
    case ContactKind::edges:
      break;
  }
  return {edge(r, pair.reference, at.reference), edge(m, pair.moving, at.moving)};
}

}  // namespace

void keep_one_candidate_per_feature(const Mesh& reference, const Mesh& moving,
                                    std::vector<NearCandidate>& near, std::vector<FeatureKey>& keys)
{
  std::size_t n_kept = 0;
  keys.clear();
  for (const NearCandidate& candidate : near) {
    const FeatureKey key = key_of(reference, moving, candidate);
    const auto known = std::find(keys.begin(), keys.end(), key);
    if (known == keys.end()) {
      keys.push_back(key);
      near[n_kept++] = candidate;
      continue;
    }
    NearCandidate& other = near[static_cast<std::size_t>(known - keys.begin())];
    if (std::tie(candidate.at.travel_mm, candidate.pair) < std::tie(other.at.travel_mm, other.pair))
      other = candidate;
  }
  near.resize(n_kept);
}

GapFeature gap_feature(const GapFace& reference, const GapFace& moving, const ContactCandidate& candidate,
                       const TrianglePair& pair, double offset_mm)
{
  GapFeature feature;
  feature.travel_mm = candidate.travel_mm;
  feature.triangles = pair;
  feature.kind = candidate.kind;
  feature.offset_mm = offset_mm;
  const Corners &r = reference.corner, &m = moving.corner;
  // From the reference's point to the moving object's at the end of the travel, across `edge`.
  const auto direction = [&feature, &r, &candidate] {
    const Eigen::Vector3d w =
        feature.point_mm + candidate.travel_mm * Eigen::Vector3d::UnitY() - r[candidate.reference];
    return (w - feature.edge.dot(w) * feature.edge).normalized();
  };
  switch (candidate.kind) {
    case ContactCandidate::Kind::moving_vertex:
      feature.point_mm = m[candidate.moving];
      feature.normal = unit_normal(r);
      break;
    case ContactCandidate::Kind::reference_vertex:
      feature.point_mm = r[candidate.reference] - candidate.travel_mm * Eigen::Vector3d::UnitY();
      feature.normal = -unit_normal(m);
      if (offset_mm > 0.0) feature.point_mm += offset_mm * feature.normal;
      break;
    case ContactCandidate::Kind::edges: {
      const Eigen::Vector3d d = r[(candidate.reference + 1) % 3] - r[candidate.reference];
      const Eigen::Vector3d e = m[(candidate.moving + 1) % 3] - m[candidate.moving];
      feature.point_mm = m[candidate.moving] + candidate.along_moving * e;
      const Eigen::Vector3d n = d.cross(e).normalized();
      feature.normal = n.y() < 0.0 ? n : Eigen::Vector3d(-n);
      break;
    }
    case ContactKind::reference_edge:
      feature.point_mm = m[candidate.moving];
      feature.edge = (r[(candidate.reference + 1) % 3] - r[candidate.reference]).normalized();
      feature.normal = direction();
      break;
    case ContactKind::moving_edge: {
      const Eigen::Vector3d e = m[(candidate.moving + 1) % 3] - m[candidate.moving];
      feature.point_mm = m[candidate.moving] + candidate.along_moving * e;
      feature.edge = e.normalized();
      feature.normal = direction();
      break;
    }
    case ContactKind::vertices:
      feature.point_mm = m[candidate.moving];
      feature.normal = direction();
      break;
  }
  return feature;
}

void merge_features(std::vector<GapFeature>& features)
{
  std::sort(features.begin(), features.end(), [](const GapFeature& a, const GapFeature& b) {
    return std::tie(a.travel_mm, a.triangles, a.point_mm.x(), a.point_mm.z(), a.normal.x(), a.normal.z()) <
           std::tie(b.travel_mm, b.triangles, b.point_mm.x(), b.point_mm.z(), b.normal.x(), b.normal.z());
  });
  std::size_t n_kept = 0;
  for (const GapFeature& feature : features) {
    bool is_new = true;
    for (std::size_t k = n_kept; is_new && k > 0; --k) {
      if (feature.travel_mm - features[k - 1].travel_mm > same_travel_mm) break;
      is_new = !is_same(feature, features[k - 1]);
    }
    if (is_new) features[n_kept++] = feature;
  }
  features.resize(n_kept);
}

}  // namespace vrda::geometry
