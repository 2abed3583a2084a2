#include "contact/candidates.hpp"

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

namespace vrda::contact {
namespace {

// Cosine below which two opposed faces are coplanar: 1e-6 rad moves a corner of a 10 mm face by 1e-5 mm.
constexpr double flat_cosine = -1.0 + 1e-12;
// Points of one feature computed from several triangles differ by rounding only.
constexpr double same_point_mm = 1e-6;

// At an equilibrium the distance is zero but for rounding, which must not decide whether a pair is in
// contact.
constexpr double touching_mm = 1e-9;

Candidate with_features(const Scene& scene, Candidate candidate)
{
  candidate.reference = feature_at(scene.reference.mesh, scene.reference_features, candidate.pair.reference,
                                   candidate.p_reference_mm, scene.reference_corners(candidate.pair));
  candidate.moving = feature_at(scene.moving.tree_mesh.mesh, scene.moving.features, candidate.pair.moving,
                                candidate.p_moving_mm, scene.moving_corners(candidate.pair));
  return candidate;
}

bool is_inside(const geometry::Corners& face, const Eigen::Vector3d& n, const Eigen::Vector3d& p)
{
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d along = face[(k + 1) % 3] - face[k];
    if (n.dot(along.cross(p - face[k])) < -1e-12 * along.squaredNorm()) return false;
  }
  return true;
}

// Two coplanar faces touch in a polygon: its corners are vertices of one inside the other and crossings of
// their edges.
std::vector<Candidate> polygon_corners(const Scene& scene, const Candidate& pair)
{
  const geometry::Corners r = scene.reference_corners(pair.pair), m = scene.moving_corners(pair.pair);
  const Eigen::Vector3d n = unit_normal(r);
  std::vector<Candidate> result;
  const auto add = [&](const Eigen::Vector3d& on_reference, const Eigen::Vector3d& on_moving) {
    Candidate corner = pair;
    corner.p_reference_mm = on_reference;
    corner.p_moving_mm = on_moving;
    corner.distance_mm = (on_moving - on_reference).norm();
    if (const double offset_mm = scene.offset_mm(pair.pair); offset_mm > 0.0)
      corner.distance_mm = std::max(0.0, corner.distance_mm - offset_mm);
    result.push_back(with_features(scene, corner));
  };
  for (const Eigen::Vector3d& p : m) {
    if (is_inside(r, n, p)) add(p - n.dot(p - r[0]) * n, p);
  }
  for (const Eigen::Vector3d& p : r) {
    if (is_inside(m, -n, p)) add(p, p - n.dot(p - m[0]) * n);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d d = r[(i + 1) % 3] - r[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d e = m[(k + 1) % 3] - m[k];
      const double cross = n.dot(d.cross(e));
      if (std::abs(cross) <= parallel_edges * d.norm() * e.norm()) continue;
      const Eigen::Vector3d w = m[k] - r[i];
      const double s = n.dot(w.cross(e)) / cross, t = n.dot(w.cross(d)) / cross;
      if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) add(r[i] + s * d, m[k] + t * e);
    }
  }
  return result;
}

using Segment = std::array<Eigen::Vector3d, 2>;

// The part of a segment where direction . (p - origin) is not negative; empty without.
std::optional<Segment> clipped(const Segment& s, const Eigen::Vector3d& direction,
                               const Eigen::Vector3d& origin)
{
  const double first = direction.dot(s[0] - origin), last = direction.dot(s[1] - origin);
  if (first < 0.0 && last < 0.0) return std::nullopt;
  if (first >= 0.0 && last >= 0.0) return s;
  const Eigen::Vector3d cut = s[0] + (first / (first - last)) * (s[1] - s[0]);
  return first < 0.0 ? Segment{cut, s[1]} : Segment{s[0], cut};
}

std::optional<Segment> over_face(Segment edge, const geometry::Corners& face)
{
  const Eigen::Vector3d n = unit_normal(face);
  for (std::size_t k = 0; k < 3; ++k) {
    const std::optional<Segment> rest = clipped(edge, n.cross(face[(k + 1) % 3] - face[k]), face[k]);
    if (!rest) return std::nullopt;
    edge = *rest;
  }
  return edge;
}

std::optional<Segment> beside_edge(const Segment& edge, const Segment& other)
{
  const Eigen::Vector3d along = other[1] - other[0];
  const std::optional<Segment> rest = clipped(edge, along, other[0]);
  return rest ? clipped(*rest, -along, other[1]) : std::nullopt;
}

// An edge that lies along a face or along another edge has a segment of closest points, any of which may have
// been found: the segment's ends, or nothing where the closest points are unique.
std::vector<Candidate> segment_ends(const Scene& scene, const Candidate& c)
{
  const bool has_moving_edge = c.moving.kind == FeatureKind::edge;
  const Feature& of_edge = has_moving_edge ? c.moving : c.reference;
  const Feature& of_other = has_moving_edge ? c.reference : c.moving;
  if (of_edge.kind != FeatureKind::edge || of_other.kind == FeatureKind::vertex) return {};
  const auto segment = [&](const Feature& feature, bool is_moving) {
    const auto& [features, mesh] = is_moving ? std::tie(scene.moving.features, scene.moving.tree_mesh.mesh)
                                             : std::tie(scene.reference_features, scene.reference.mesh);
    Segment result;
    for (std::size_t k = 0; k < 2; ++k) {
      result[k] = mesh.vertices_mm.row(features.edge_vertices(feature.index)[k]);
      if (is_moving) result[k] = scene.place(result[k]);
    }
    return result;
  };
  const Segment edge = segment(of_edge, has_moving_edge);
  const Eigen::Vector3d along = (edge[1] - edge[0]).normalized();
  std::optional<Segment> common;
  if (of_other.kind == FeatureKind::face) {
    common =
        over_face(edge, has_moving_edge ? scene.reference_corners(c.pair) : scene.moving_corners(c.pair));
  } else {
    const Segment other = segment(of_other, !has_moving_edge);
    if (along.cross((other[1] - other[0]).normalized()).norm() > parallel_edges) return {};
    common = beside_edge(edge, other);
  }
  if (!common) return {};
  std::vector<Candidate> result;
  const Eigen::Vector3d found = has_moving_edge ? c.p_moving_mm : c.p_reference_mm;
  for (const Eigen::Vector3d& end : *common) {
    Candidate at_end = c;
    // The gap is the same all along.
    const Eigen::Vector3d shift = along.dot(end - found) * along;
    at_end.p_reference_mm += shift;
    at_end.p_moving_mm += shift;
    result.push_back(with_features(scene, at_end));
  }
  return result;
}

bool is_overlap(const Scene& scene, const geometry::TrianglePair& pair, double distance_mm)
{
  return distance_mm < (scene.offset_mm(pair) > 0.0 ? -rounded_touching_mm : -touching_mm);
}

TriangleDistance estimated(const Scene& scene, const geometry::Corners& r, const geometry::Corners& m)
{
  const std::optional<TriangleDistance> found = closest_points(r, m);
  return found ? *found : scene.narrow_phase.measure(r, m);
}
}  // namespace

std::optional<Candidate> measured(const Scene& scene, Candidate candidate)
{
  const TriangleDistance found = scene.narrow_phase.measure(scene.reference_corners(candidate.pair),
                                                            scene.moving_corners(candidate.pair));
  const double distance_mm = found.distance_mm - scene.offset_mm(candidate.pair);
  if (is_overlap(scene, candidate.pair, distance_mm)) return std::nullopt;
  candidate.distance_mm = std::max(0.0, distance_mm);
  candidate.p_reference_mm = found.p_reference_mm;
  candidate.p_moving_mm = found.p_moving_mm;
  return with_features(scene, candidate);
}

bool is_near_side(const Mesh& reference, const Mesh& moving, const geometry::TrianglePair& pair,
                  const geometry::Corners& r, const geometry::Corners& m, const Eigen::Vector3d& delta)
{
  const auto faces = [](const geometry::Corners& t, const Eigen::Vector3d& direction) {
    return (t[1] - t[0]).cross(t[2] - t[0]).dot(direction) > 0.0;
  };
  return (overlap_mm(reference, pair.reference) == 0.0 || faces(r, -delta)) &&
         (overlap_mm(moving, pair.moving) == 0.0 || faces(m, delta));
}

std::vector<Candidate> close_pairs(const Scene& scene)
{
  const Eigen::Vector3d delta = scene.place.direction(Eigen::Vector3d::UnitY());
  std::vector<Candidate> result;
  const double band_mm = scene.options.band_mm;
  const auto visit = [&](const geometry::TrianglePair& pair) {
    const geometry::Corners r = scene.reference_corners(pair), m = scene.moving_corners(pair);
    if (!is_near_side(scene.reference.mesh, scene.moving.tree_mesh.mesh, pair, r, m, delta)) return false;
    const double offset_mm = scene.offset_mm(pair);
    // Pairs of a gap query are screened already.
    if (scene.candidates == nullptr && is_certainly_separated(r, m, band_mm + offset_mm)) return false;
    const TriangleDistance found = estimated(scene, r, m);
    const double distance_mm = found.distance_mm - offset_mm;
    if (is_overlap(scene, pair, distance_mm) || distance_mm > band_mm) return false;
    result.push_back({pair, std::max(0.0, distance_mm), found.p_reference_mm, found.p_moving_mm, {}, {}});
    return false;
  };
  if (scene.candidates != nullptr) {
    std::for_each(scene.candidates->begin(), scene.candidates->end(), visit);
  } else {
    geometry::visit_close_pairs(
        scene.reference.tree, scene.moving.tree_mesh.tree, scene.place,
        band_mm + geometry::rounding_mm(scene.reference.mesh, scene.moving.tree_mesh.mesh), visit);
  }
  std::sort(result.begin(), result.end(),
            [](const Candidate& l, const Candidate& r) { return l.pair < r.pair; });
  return result;
}
namespace {

// One candidate for each pair of features: the nearest, ties by the smallest pair.
std::vector<Candidate> unique_by_feature(std::vector<Candidate> all)
{
  const auto key = [](const Candidate& c) { return std::tie(c.reference, c.moving, c.distance_mm, c.pair); };
  std::sort(all.begin(), all.end(), [&](const Candidate& l, const Candidate& r) { return key(l) < key(r); });
  const auto same = [](const Candidate& l, const Candidate& r) {
    return l.reference == r.reference && l.moving == r.moving &&
           (l.p_reference_mm - r.p_reference_mm).norm() <= same_point_mm;
  };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  return all;
}

// Whether both are of one segment of closest points, of which each may be an end.
bool are_on_a_segment(const Candidate& c, const Candidate& other)
{
  const Eigen::Vector3d apart = c.p_moving_mm - c.p_reference_mm,
                        along = other.p_reference_mm - c.p_reference_mm;
  return along.norm() > same_point_mm && std::abs(apart.dot(along)) <= same_point_mm * apart.norm();
}

// Whether no neighbouring pair of triangles is clearly nearer: otherwise the candidate belongs to the flank
// of another contact.
bool is_separate_contact(const Scene& scene, const std::vector<Candidate>& pairs, const Candidate& candidate)
{
  for (const std::int32_t r : scene.reference_features.star(candidate.reference)) {
    for (const std::int32_t m : scene.moving.features.star(candidate.moving)) {
      const geometry::TrianglePair neighbour{r, m};
      const auto found =
          std::lower_bound(pairs.begin(), pairs.end(), neighbour,
                           [](const Candidate& c, const geometry::TrianglePair& p) { return c.pair < p; });
      if (found == pairs.end() || found->pair != neighbour) continue;
      const double away_mm = (found->p_moving_mm - candidate.p_moving_mm).norm() +
                             (found->p_reference_mm - candidate.p_reference_mm).norm();
      const double allowed_mm = scene.options.slope_rad * away_mm + same_point_mm;
      if (found->distance_mm < candidate.distance_mm - allowed_mm) return false;
    }
  }
  return true;
}
}  // namespace

std::vector<Candidate> touching_features(const Scene& scene, const std::vector<Candidate>& pairs)
{
  std::vector<Candidate> near, all;
  const auto add = [&all](const std::vector<Candidate>& some) {
    all.insert(all.end(), some.begin(), some.end());
  };
  const auto keep_contacts = [&](std::vector<Candidate>& some) {
    some = unique_by_feature(std::move(some));
    std::erase_if(some, [&](const Candidate& c) { return !is_separate_contact(scene, pairs, c); });
  };
  for (const Candidate& pair : pairs) {
    const double cosine =
        unit_normal(scene.reference_corners(pair.pair)).dot(unit_normal(scene.moving_corners(pair.pair)));
    const std::vector<Candidate> corner =
        cosine < flat_cosine ? polygon_corners(scene, pair) : std::vector<Candidate>{};
    add(corner);
    // Coplanar faces with a degenerate polygon keep their closest points.
    if (corner.empty()) near.push_back(with_features(scene, pair));
  }
  // A feature is found through each of its triangles; the narrow phase measures one pair.
  keep_contacts(near);
  for (const Candidate& each : near) {
    const std::optional<Candidate> candidate = measured(scene, each);
    if (!candidate) continue;
    const std::vector<Candidate> ends = segment_ends(scene, *candidate);
    add(ends.empty() ? std::vector<Candidate>{*candidate} : ends);
    if (ends.empty() && are_on_a_segment(each, *candidate)) all.push_back(each);
  }
  keep_contacts(all);
  return all;
}
}  // namespace vrda::contact
