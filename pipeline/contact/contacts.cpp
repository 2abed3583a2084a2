#include "contact/contacts.hpp"

#include <algorithm>
#include <optional>
#include <tuple>
#include <utility>

#include "contact/narrow_phase.hpp"

namespace vrda::contact {
namespace {

// Cosine below which two opposed faces are coplanar: 1e-6 rad moves a corner of a 10 mm face by 1e-5 mm.
constexpr double flat_cosine = -1.0 + 1e-12;
// Normals oppose Delta where their component is below this: beyond rounding.
constexpr double opposing = -1e-9;
// Sine below which two edges are parallel and their cross product has no direction.
constexpr double parallel_edges = 1e-6;
// Points of one feature computed from several triangles differ by rounding only.
constexpr double same_point_mm = 1e-6;

struct Candidate {
  proximity::TrianglePair pair;
  double distance_mm = 0.0;
  Eigen::Vector3d p_reference_mm;
  Eigen::Vector3d p_moving_mm;
  Feature reference;
  Feature moving;
};

struct Scene {
  const proximity::TreeMesh& reference;
  const SurfaceFeatures& reference_features;
  const Collider& moving;
  proximity::RigidPlacement place;  // of the moving object in the reference's frame
  NarrowPhase& narrow_phase;
  const ContactOptions& options;
  const std::vector<proximity::TrianglePair>* candidates;  // null: pairs from the trees

  proximity::Corners reference_corners(const proximity::TrianglePair& pair) const
  {
    return corners(reference.mesh, pair.reference);
  }
  proximity::Corners moving_corners(const proximity::TrianglePair& pair) const
  {
    return place(corners(moving.tree_mesh.mesh, pair.moving));
  }
};

template <typename Transform>
std::optional<proximity::TrianglePair> first_collision(const proximity::TreeMesh& reference,
                                                       const proximity::TreeMesh& moving,
                                                       const Transform& place, NarrowPhase& narrow_phase,
                                                       const proximity::TrianglePair& hint)
{
  std::optional<proximity::TrianglePair> found;
  const auto overlaps = [&](const proximity::TrianglePair& pair) {
    const proximity::Corners r = corners(reference.mesh, pair.reference),
                             m = place(corners(moving.mesh, pair.moving));
    if (is_certainly_separated(r, m, 0.0) || !narrow_phase.measure(r, m).is_overlapping) return false;
    found = pair;
    return true;
  };
  if (hint.reference >= 0 && overlaps(hint)) return found;
  proximity::visit_close_pairs(reference.tree, moving.tree, place, 0.0, overlaps);
  return found;
}

Eigen::Vector3d unit_normal(const proximity::Corners& t)
{
  return (t[1] - t[0]).cross(t[2] - t[0]).normalized();
}

Candidate with_features(const Scene& scene, Candidate candidate)
{
  candidate.reference = feature_at(scene.reference.mesh, scene.reference_features, candidate.pair.reference,
                                   candidate.p_reference_mm, scene.reference_corners(candidate.pair));
  candidate.moving = feature_at(scene.moving.tree_mesh.mesh, scene.moving.features, candidate.pair.moving,
                                candidate.p_moving_mm, scene.moving_corners(candidate.pair));
  return candidate;
}

bool is_inside(const proximity::Corners& face, const Eigen::Vector3d& n, const Eigen::Vector3d& p)
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
  const proximity::Corners r = scene.reference_corners(pair.pair), m = scene.moving_corners(pair.pair);
  const Eigen::Vector3d n = unit_normal(r);
  std::vector<Candidate> result;
  const auto add = [&](const Eigen::Vector3d& on_reference, const Eigen::Vector3d& on_moving) {
    Candidate corner = pair;
    corner.p_reference_mm = on_reference;
    corner.p_moving_mm = on_moving;
    corner.distance_mm = (on_moving - on_reference).norm();
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

// All pairs within the band with their distances, sorted by pair.
std::vector<Candidate> close_pairs(const Scene& scene)
{
  std::vector<Candidate> result;
  const double band_mm = scene.options.band_mm;
  const auto visit = [&](const proximity::TrianglePair& pair) {
    const proximity::Corners r = scene.reference_corners(pair), m = scene.moving_corners(pair);
    if (is_certainly_separated(r, m, band_mm)) return false;
    const TriangleDistance found = scene.narrow_phase.measure(r, m);
    if (found.is_overlapping || found.distance_mm > band_mm) return false;
    const TriangleDistance measured = closest_points(r, m);
    result.push_back({pair, measured.distance_mm, measured.p_reference_mm, measured.p_moving_mm, {}, {}});
    return false;
  };
  if (scene.candidates != nullptr) {
    std::for_each(scene.candidates->begin(), scene.candidates->end(), visit);
  } else {
    proximity::visit_close_pairs(scene.reference.tree, scene.moving.tree_mesh.tree, scene.place, band_mm,
                                 visit);
  }
  std::sort(result.begin(), result.end(),
            [](const Candidate& l, const Candidate& r) { return l.pair < r.pair; });
  return result;
}

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

// Whether no neighbouring pair of triangles is clearly nearer: otherwise the candidate belongs to the flank
// of another contact.
bool is_separate_contact(const Scene& scene, const std::vector<Candidate>& pairs, const Candidate& candidate)
{
  for (const std::int32_t r : scene.reference_features.star(candidate.reference)) {
    for (const std::int32_t m : scene.moving.features.star(candidate.moving)) {
      const proximity::TrianglePair neighbour{r, m};
      const auto found =
          std::lower_bound(pairs.begin(), pairs.end(), neighbour,
                           [](const Candidate& c, const proximity::TrianglePair& p) { return c.pair < p; });
      if (found == pairs.end() || found->pair != neighbour) continue;
      const double away_mm = (found->p_moving_mm - candidate.p_moving_mm).norm() +
                             (found->p_reference_mm - candidate.p_reference_mm).norm();
      const double allowed_mm = scene.options.slope_rad * away_mm + same_point_mm;
      if (found->distance_mm < candidate.distance_mm - allowed_mm) return false;
    }
  }
  return true;
}

Eigen::Vector3d feature_normal(const Mesh& mesh, const SurfaceFeatures& features, const Feature& feature)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const std::int32_t t : features.star(feature)) sum += face_normal(mesh, t);
  const double length = sum.norm();
  return length > 0.0 ? Eigen::Vector3d(sum / length) : sum;
}

// Barycentric interpolation of the vertex normals of triangle t at p.
Eigen::Vector3d interpolated_normal(const Mesh& mesh, std::int32_t t, const Eigen::Vector3d& p,
                                    const proximity::Corners& corner)
{
  const Eigen::Vector3d n = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d& a = corner[(k + 1) % 3];
    const Eigen::Vector3d& b = corner[(k + 2) % 3];
    const double weight = n.dot((b - a).cross(p - a)) / n.squaredNorm();
    sum += weight * Eigen::Vector3d(mesh.normals.row(mesh.triangles(t, static_cast<Eigen::Index>(k))));
  }
  return sum.normalized();
}

Eigen::Vector3d edge_direction(const Mesh& mesh, const SurfaceFeatures& features, std::int32_t edge)
{
  const auto [a, b] = features.edge_vertices(edge);
  return Eigen::Vector3d(mesh.vertices_mm.row(b) - mesh.vertices_mm.row(a)).normalized();
}

// A contact's normal and the object that it was taken from.
struct Reaction {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  bool is_of_reference = true;
};

// Direction of a contact's edge on either side; empty where the feature is not an edge.
std::optional<Eigen::Vector3d> along_reference(const Scene& scene, const Candidate& c)
{
  if (c.reference.kind != FeatureKind::edge) return std::nullopt;
  return edge_direction(scene.reference.mesh, scene.reference_features, c.reference.index);
}

std::optional<Eigen::Vector3d> along_moving(const Scene& scene, const Candidate& c)
{
  if (c.moving.kind != FeatureKind::edge) return std::nullopt;
  return scene.place.direction(
      edge_direction(scene.moving.tree_mesh.mesh, scene.moving.features, c.moving.index));
}

// Without friction no force acts along an edge. The mean normal of the faces around a vertex may have such a
// component: at a corner it includes walls that do not touch.
Eigen::Vector3d across(const std::optional<Eigen::Vector3d>& edge, const Eigen::Vector3d& normal)
{
  if (!edge) return normal;
  const Eigen::Vector3d rest = normal - normal.dot(*edge) * *edge;
  const double length = rest.norm();
  return length > parallel_edges ? Eigen::Vector3d(rest / length) : normal;
}

// Thesis 3.7: the normal of the surface of least curvature; two crossing edges give their cross product.
Reaction least_curvature_normal(const Scene& scene, const Candidate& c)
{
  const auto of_reference = [&] {
    return feature_normal(scene.reference.mesh, scene.reference_features, c.reference);
  };
  const std::optional<Eigen::Vector3d> d = along_reference(scene, c), e = along_moving(scene, c);
  if (d && e) {
    const Eigen::Vector3d normal = d->cross(*e);
    if (normal.norm() > parallel_edges)
      return {(normal.dot(of_reference()) < 0.0 ? -normal : normal).normalized(), true};
  }
  const bool takes_reference =
      scene.reference_features.bend(c.reference) <= scene.moving.features.bend(c.moving);
  // An edge's own normal is perpendicular to it, so only a vertex's changes here.
  if (takes_reference)
    return {c.reference.kind == FeatureKind::vertex ? across(e, of_reference()) : of_reference(), true};
  const Eigen::Vector3d normal =
      -scene.place.direction(feature_normal(scene.moving.tree_mesh.mesh, scene.moving.features, c.moving));
  return {c.moving.kind == FeatureKind::vertex ? across(d, normal) : normal, false};
}

Reaction reaction(const Scene& scene, const Candidate& c)
{
  switch (scene.options.normals) {
    case ContactNormals::least_curvature:
      return least_curvature_normal(scene, c);
    case ContactNormals::reference:
      return {interpolated_normal(scene.reference.mesh, c.pair.reference, c.p_reference_mm,
                                  scene.reference_corners(c.pair)),
              true};
    case ContactNormals::moving:
      break;
  }
  const proximity::Corners corner = scene.moving_corners(c.pair);
  return {-scene.place.direction(
              interpolated_normal(scene.moving.tree_mesh.mesh, c.pair.moving, c.p_moving_mm, corner)),
          false};
}

Contact exact_contact(const Scene& scene, const Candidate& c)
{
  const Reaction found = reaction(scene, c);
  return {c.p_reference_mm, found.is_of_reference ? c.p_reference_mm : c.p_moving_mm, found.normal,
          c.distance_mm, c.pair};
}

// The thesis's first implementation (4.1): centre of the triangle, mean of its vertices' normals.
Contact centre_contact(const Scene& scene, const Candidate& c)
{
  const auto sharpest = [](const SurfaceFeatures& features, std::int32_t t) {
    double bend = 0.0;
    for (int k = 0; k < 3; ++k)
      bend = std::max(bend, features.bend({FeatureKind::edge, features.edge_of(t, k)}));
    return bend;
  };
  const bool takes_reference = scene.options.normals == ContactNormals::reference ||
                               (scene.options.normals == ContactNormals::least_curvature &&
                                sharpest(scene.reference_features, c.pair.reference) <=
                                    sharpest(scene.moving.features, c.pair.moving));
  const proximity::Corners r = scene.reference_corners(c.pair), m = scene.moving_corners(c.pair);
  const proximity::Corners& corner = takes_reference ? r : m;
  const Mesh& mesh = takes_reference ? scene.reference.mesh : scene.moving.tree_mesh.mesh;
  const std::int32_t t = takes_reference ? c.pair.reference : c.pair.moving;
  const Eigen::Vector3d centre = (corner[0] + corner[1] + corner[2]) / 3.0;
  const Eigen::Vector3d normal = interpolated_normal(mesh, t, centre, corner);
  return {centre, centre, takes_reference ? normal : Eigen::Vector3d(-scene.place.direction(normal)),
          c.distance_mm, c.pair};
}

std::vector<Candidate> touching_features(const Scene& scene, const std::vector<Candidate>& pairs)
{
  std::vector<Candidate> all;
  for (const Candidate& pair : pairs) {
    const double cosine =
        unit_normal(scene.reference_corners(pair.pair)).dot(unit_normal(scene.moving_corners(pair.pair)));
    if (cosine < flat_cosine) {
      const std::vector<Candidate> corner = polygon_corners(scene, pair);
      all.insert(all.end(), corner.begin(), corner.end());
    }
    // Coplanar faces with a degenerate polygon keep their closest points.
    if (cosine >= flat_cosine || all.empty() || all.back().pair != pair.pair)
      all.push_back(with_features(scene, pair));
  }
  all = unique_by_feature(std::move(all));
  std::erase_if(all, [&](const Candidate& c) { return !is_separate_contact(scene, pairs, c); });
  return all;
}

// All contacts that oppose Delta, nearest first, in the reference's frame.
std::vector<Contact> contacts_of(const Scene& scene, const Eigen::Vector3d& delta)
{
  const std::vector<Candidate> pairs = close_pairs(scene);
  std::vector<Contact> contacts;
  if (scene.options.points == ContactPoints::triangle_centre) {
    for (const Candidate& c : pairs) contacts.push_back(centre_contact(scene, c));
  } else {
    for (const Candidate& c : touching_features(scene, pairs)) contacts.push_back(exact_contact(scene, c));
  }
  std::erase_if(contacts, [&](const Contact& c) { return c.normal.dot(delta) >= opposing; });
  std::sort(contacts.begin(), contacts.end(), [](const Contact& l, const Contact& r) {
    return std::tie(l.distance_mm, l.triangles) < std::tie(r.distance_mm, r.triangles);
  });
  return contacts;
}

}  // namespace

Collider make_collider(Mesh mesh)
{
  if (mesh.normals.rows() != mesh.vertices_mm.rows()) mesh.normals = vertex_normals(mesh);
  Collider result;
  result.features = SurfaceFeatures(mesh);
  result.tree_mesh = proximity::make_tree_mesh(std::move(mesh));
  return result;
}

std::optional<proximity::TrianglePair> find_collision(const proximity::TreeMesh& reference,
                                                      const proximity::TreeMesh& moving,
                                                      const MovingPose& pose, NarrowPhase& narrow_phase,
                                                      const proximity::TrianglePair& hint)
{
  return first_collision(reference, moving, proximity::Placement(pose), narrow_phase, hint);
}

std::optional<proximity::TrianglePair> find_collision(const proximity::TreeMesh& reference,
                                                      const proximity::TreeMesh& moving,
                                                      const proximity::RigidPlacement& place,
                                                      NarrowPhase& narrow_phase,
                                                      const proximity::TrianglePair& hint)
{
  return first_collision(reference, moving, place, narrow_phase, hint);
}

std::vector<proximity::TrianglePair> find_self_overlaps(const proximity::TreeMesh& mesh,
                                                        NarrowPhase& narrow_phase, std::size_t limit)
{
  std::vector<proximity::TrianglePair> found;
  const auto shares_a_vertex = [&](const proximity::TrianglePair& pair) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index k = 0; k < 3; ++k) {
        if (mesh.mesh.triangles(pair.reference, i) == mesh.mesh.triangles(pair.moving, k)) return true;
      }
    }
    return false;
  };
  proximity::visit_close_pairs(
      mesh.tree, mesh.tree, proximity::Placement({}), 0.0, [&](const proximity::TrianglePair& pair) {
        if (pair.reference >= pair.moving || shares_a_vertex(pair)) return false;
        const proximity::Corners a = corners(mesh.mesh, pair.reference), b = corners(mesh.mesh, pair.moving);
        if (is_certainly_separated(a, b, 0.0) || !narrow_phase.measure(a, b).is_overlapping) return false;
        found.push_back(pair);
        return found.size() >= limit;
      });
  return found;
}

std::vector<Contact> find_contacts(const ContactObjects& objects, const MovingPose& pose,
                                   NarrowPhase& narrow_phase, const ContactOptions& options)
{
  const Scene scene{objects.reference,
                    objects.reference_features,
                    objects.moving,
                    proximity::RigidPlacement(pose_of(pose)),
                    narrow_phase,
                    options,
                    nullptr};
  return contacts_of(scene, Eigen::Vector3d::UnitY());
}

std::vector<Contact> find_contacts(const Collider& reference, const Collider& moving,
                                   const ObjectPoses& standing,
                                   const std::vector<proximity::TrianglePair>& candidates,
                                   NarrowPhase& narrow_phase, const ContactOptions& options)
{
  Pose X_solver_reference = Pose::Identity();
  X_solver_reference.linear() = reference_rotation(standing.attitude);
  Pose X_reference_solver = Pose::Identity();
  X_reference_solver.linear() = X_solver_reference.linear().transpose();
  const Scene scene{reference.tree_mesh,
                    reference.features,
                    moving,
                    proximity::RigidPlacement(X_reference_solver * pose_of(standing.pose)),
                    narrow_phase,
                    options,
                    &candidates};
  std::vector<Contact> contacts = contacts_of(scene, X_reference_solver.linear() * Eigen::Vector3d::UnitY());
  for (Contact& c : contacts) {
    c.point_mm = X_solver_reference * c.point_mm;
    c.application_mm = X_solver_reference * c.application_mm;
    c.normal = X_solver_reference.linear() * c.normal;
  }
  return contacts;
}

}  // namespace vrda::contact
