#include "contact/contacts.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

#include "contact/candidates.hpp"

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

namespace {

// Normals oppose Delta where their component is below this: beyond rounding.
constexpr double opposing = -1e-9;

// `any_pair(visit)` calls `visit` for close pairs until it returns true.
template <typename Transform, typename AnyPair>
std::optional<geometry::TrianglePair> first_collision(const Mesh& reference, const Mesh& moving,
                                                      const Transform& place, NarrowPhase& narrow_phase,
                                                      const geometry::TrianglePair& hint,
                                                      const AnyPair& any_pair)
{
  std::optional<geometry::TrianglePair> found;
  // The moving object turns about Delta only.
  const Eigen::Vector3d delta = place.direction(Eigen::Vector3d::UnitY());
  const auto overlaps = [&](const geometry::TrianglePair& pair) {
    const geometry::Corners r = corners(reference, pair.reference), m = place(corners(moving, pair.moving));
    const double offset = offset_mm(reference, pair.reference) + offset_mm(moving, pair.moving);
    if (!is_near_side(reference, moving, pair, r, m, delta)) return false;
    if (is_certainly_separated(r, m, offset) || !narrow_phase.overlap(r, m, offset)) return false;
    found = pair;
    return true;
  };
  if (hint.reference < 0 || !overlaps(hint)) any_pair(overlaps);
  return found;
}

template <typename Transform>
std::optional<geometry::TrianglePair> collision_of_trees(const geometry::TreeMesh& reference,
                                                         const geometry::TreeMesh& moving,
                                                         const Transform& place, NarrowPhase& narrow_phase,
                                                         const geometry::TrianglePair& hint)
{
  return first_collision(reference.mesh, moving.mesh, place, narrow_phase, hint, [&](const auto& overlaps) {
    geometry::visit_close_pairs(reference.tree, moving.tree, place,
                                geometry::rounding_mm(reference.mesh, moving.mesh), overlaps);
  });
}

// For first_collision: the pairs that a query finds at the pose.
auto touching_pairs(geometry::GapQuery& pairs, const MovingPose& pose)
{
  return [&](const auto& overlaps) { pairs.any_close_pair(pose, 0.0, overlaps); };
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
                                    const geometry::Corners& corner)
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
  const geometry::Corners corner = scene.moving_corners(c.pair);
  return {-scene.place.direction(
              interpolated_normal(scene.moving.tree_mesh.mesh, c.pair.moving, c.p_moving_mm, corner)),
          false};
}

Contact exact_contact(const Scene& scene, const Candidate& c)
{
  if (scene.offset_mm(c.pair) > 0.0) {  // the bare surfaces are apart: one normal for both
    const Eigen::Vector3d normal = (c.p_moving_mm - c.p_reference_mm).normalized();
    const Eigen::Vector3d point =
        c.p_reference_mm + offset_mm(scene.reference.mesh, c.pair.reference) * normal;
    return {point, point, normal, c.distance_mm, c.pair};
  }
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
  const geometry::Corners r = scene.reference_corners(c.pair), m = scene.moving_corners(c.pair);
  const geometry::Corners& corner = takes_reference ? r : m;
  const Mesh& mesh = takes_reference ? scene.reference.mesh : scene.moving.tree_mesh.mesh;
  const std::int32_t t = takes_reference ? c.pair.reference : c.pair.moving;
  const Eigen::Vector3d centre = (corner[0] + corner[1] + corner[2]) / 3.0;
  const Eigen::Vector3d normal = interpolated_normal(mesh, t, centre, corner);
  const Eigen::Vector3d reaction = takes_reference ? normal : Eigen::Vector3d(-scene.place.direction(normal));
  const double outward_mm = takes_reference ? offset_mm(scene.reference.mesh, t) : -offset_mm(mesh, t);
  const Eigen::Vector3d point = outward_mm == 0.0 ? centre : Eigen::Vector3d(centre + outward_mm * reaction);
  return {point, point, reaction, c.distance_mm, c.pair};
}

// Of a contact between limits (inward_limit) that of the surfaces, which are apart by less.
Contact between_surfaces(const Scene& scene, Contact contact)
{
  const double of_both_mm = scene.overlap_mm(contact.triangles);
  if (of_both_mm == 0.0) return contact;
  const double of_reference_mm = overlap_mm(scene.reference.mesh, contact.triangles.reference);
  contact.distance_mm -= of_both_mm;
  contact.point_mm += of_reference_mm * contact.normal;
  contact.application_mm += of_reference_mm * contact.normal;
  return contact;
}

// All contacts that oppose Delta, nearest first, in the reference's frame.
std::vector<Contact> contacts_of(const Scene& scene, const Eigen::Vector3d& delta)
{
  const std::vector<Candidate> pairs = close_pairs(scene);
  std::vector<Contact> contacts;
  if (scene.options.points == ContactPoints::triangle_centre) {
    for (const Candidate& pair : pairs) {
      if (const std::optional<Candidate> c = measured(scene, pair))
        contacts.push_back(between_surfaces(scene, centre_contact(scene, *c)));
    }
  } else {
    for (const Candidate& c : touching_features(scene, pairs))
      contacts.push_back(between_surfaces(scene, exact_contact(scene, c)));
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
  result.tree_mesh = geometry::make_tree_mesh(std::move(mesh));
  return result;
}

std::optional<geometry::TrianglePair> find_collision(const geometry::TreeMesh& reference,
                                                     const geometry::TreeMesh& moving, const MovingPose& pose,
                                                     NarrowPhase& narrow_phase,
                                                     const geometry::TrianglePair& hint)
{
  return collision_of_trees(reference, moving, geometry::Placement(pose), narrow_phase, hint);
}

std::optional<geometry::TrianglePair> find_collision(const geometry::TreeMesh& reference,
                                                     const geometry::TreeMesh& moving,
                                                     const geometry::RigidPlacement& place,
                                                     NarrowPhase& narrow_phase,
                                                     const geometry::TrianglePair& hint)
{
  return collision_of_trees(reference, moving, place, narrow_phase, hint);
}

std::optional<geometry::TrianglePair> find_collision(const Mesh& reference, const Mesh& moving,
                                                     const MovingPose& pose, geometry::GapQuery& pairs,
                                                     NarrowPhase& narrow_phase,
                                                     const geometry::TrianglePair& hint)
{
  return first_collision(reference, moving, geometry::Placement(pose), narrow_phase, hint,
                         touching_pairs(pairs, pose));
}

std::optional<geometry::TrianglePair> find_collision(const Mesh& reference, const Mesh& moving,
                                                     const geometry::RigidPlacement& place,
                                                     const MovingPose& pose, geometry::GapQuery& pairs,
                                                     NarrowPhase& narrow_phase,
                                                     const geometry::TrianglePair& hint)
{
  return first_collision(reference, moving, place, narrow_phase, hint, touching_pairs(pairs, pose));
}

std::vector<geometry::TrianglePair> find_self_overlaps(const geometry::TreeMesh& mesh,
                                                       NarrowPhase& narrow_phase, std::size_t limit)
{
  std::vector<geometry::TrianglePair> found;
  const auto shares_a_vertex = [&](const geometry::TrianglePair& pair) {
    for (Eigen::Index i = 0; i < 3; ++i) {
      for (Eigen::Index k = 0; k < 3; ++k) {
        if (mesh.mesh.triangles(pair.reference, i) == mesh.mesh.triangles(pair.moving, k)) return true;
      }
    }
    return false;
  };
  geometry::visit_own_pairs(mesh.tree, [&](const geometry::TrianglePair& pair) {
    if (shares_a_vertex(pair)) return false;
    const geometry::Corners a = corners(mesh.mesh, pair.reference), b = corners(mesh.mesh, pair.moving);
    if (is_certainly_separated(a, b, 0.0) || !narrow_phase.overlap(a, b)) return false;
    found.push_back(pair);
    return found.size() >= limit;
  });
  return found;
}

std::vector<Contact> find_contacts(const ContactObjects& objects, const MovingPose& pose,
                                   NarrowPhase& narrow_phase, const ContactOptions& options)
{
  const Scene scene{objects.reference, objects.reference_features,
                    objects.moving,    geometry::RigidPlacement(pose_of(pose)),
                    narrow_phase,      options,
                    objects.candidates};
  return contacts_of(scene, Eigen::Vector3d::UnitY());
}

std::vector<Contact> find_contacts(const ContactObjects& objects, const Attitude& attitude,
                                   const MovingPose& pose, NarrowPhase& narrow_phase,
                                   const ContactOptions& options)
{
  Pose X_solver_reference = Pose::Identity();
  X_solver_reference.linear() = reference_rotation(attitude);
  Pose X_reference_solver = Pose::Identity();
  X_reference_solver.linear() = X_solver_reference.linear().transpose();
  const Scene scene{objects.reference, objects.reference_features,
                    objects.moving,    geometry::RigidPlacement(X_reference_solver * pose_of(pose)),
                    narrow_phase,      options,
                    objects.candidates};
  std::vector<Contact> contacts = contacts_of(scene, X_reference_solver.linear() * Eigen::Vector3d::UnitY());
  for (Contact& c : contacts) {
    c.point_mm = X_solver_reference * c.point_mm;
    c.application_mm = X_solver_reference * c.application_mm;
    c.normal = X_solver_reference.linear() * c.normal;
  }
  return contacts;
}

}  // namespace vrda::contact
