#include "proximity/gap_features.hpp"

#include <algorithm>
#include <tuple>

namespace vrda::proximity {
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

}  // namespace

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

}  // namespace vrda::proximity
