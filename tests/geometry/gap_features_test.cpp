// Gap features: completeness and gradients.
// Gaps of meshes rounded by an offset: closed forms, every pair of triangles, and the distance at contact.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/gap_query.hpp"
#include "geometry/gap_scenes.hpp"
#include "geometry/gap_tree.hpp"
#include "model/coordinates.hpp"
#include "support/directional_gap.hpp"
#include "support/meshes.hpp"

namespace vrda::gap_features_test {

using test::GapBodies;
using test::GapRandom;

constexpr double rounding_mm = 1e-11;
// A point computed from neighbouring triangles has this error along slivers.
constexpr double same_mm = 1e-8;

TEST(GapFeatures, ReachTheLeastTravelAndKeepTheBand)
{
  GapRandom random(12);
  std::size_t n_features = 0;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    for (int k = 0; k < 25; ++k) {
      query.set_attitude(random.attitude());
      const MovingPose pose = random.pose(4, bodies.depth_mm);
      const double travel = query.travel_mm(pose);
      const geometry::GapResult& answer = query.features(pose, 0.5);
      ASSERT_FALSE(answer.features.empty());
      EXPECT_EQ(answer.travel_mm, travel);
      EXPECT_EQ(answer.features.front().travel_mm, travel);
      EXPECT_EQ(answer.features.front().triangles, answer.pair);
      for (const geometry::GapFeature& feature : answer.features) {
        EXPECT_LE(feature.travel_mm, travel + 0.5);
        EXPECT_LT(feature.normal.y(), 0.0);
        EXPECT_NEAR(feature.normal.norm(), 1.0, 1e-14);
      }
      n_features += answer.features.size();
    }
  }
  EXPECT_GT(n_features, 200U);
}

// Every contact candidate of every facing pair within the limit, as features, unmasked and unmerged.
struct DenseFeatures {
  std::vector<geometry::GapFeature> vertices, edges;
};

DenseFeatures dense_features(const GapBodies& bodies, const Attitude& attitude, const MovingPose& pose,
                             double limit_mm)
{
  DenseFeatures features;
  const Mesh there = geometry::rotated_reference(geometry::make_tree_mesh(bodies.reference), attitude).mesh;
  const geometry::Placement place(pose);
  for (std::int32_t m = 0; m < bodies.moving.triangles.rows(); ++m) {
    const geometry::GapFace moving = geometry::gap_face(place(corners(bodies.moving, m)));
    for (std::int32_t r = 0; r < there.triangles.rows() && moving.faces_up(); ++r) {
      const geometry::GapFace reference = geometry::gap_face(corners(there, r));
      if (!reference.faces_down()) continue;
      geometry::visit_contact_candidates(reference, moving, [&](const geometry::ContactCandidate& at) {
        if (at.travel_mm > limit_mm) return;
        auto& list = at.kind == geometry::ContactCandidate::Kind::edges ? features.edges : features.vertices;
        list.push_back(geometry::gap_feature(reference, moving, at, {r, m}));
      });
    }
  }
  return features;
}

bool holds(const std::vector<geometry::GapFeature>& features, const geometry::GapFeature& wanted)
{
  return std::any_of(features.begin(), features.end(), [&wanted](const geometry::GapFeature& f) {
    return std::abs(f.travel_mm - wanted.travel_mm) <= same_mm &&
           (f.point_mm - wanted.point_mm).norm() <= same_mm && (f.normal - wanted.normal).norm() <= same_mm;
  });
}

TEST(GapFeatures, AreEveryVertexOverAFaceAndOnlyEdgesThatReallyCross)
{
  GapRandom random(21);
  std::size_t n_vertices = 0, n_edges = 0, n_skipped = 0;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    for (int k = 0; k < 12; ++k) {
      const Attitude attitude = random.attitude();
      const MovingPose pose = random.pose(4, bodies.depth_mm);
      query.set_attitude(attitude);
      const geometry::GapResult& answer = query.features(pose, 1.0);
      // Within the band by more than rounding.
      const DenseFeatures all = dense_features(bodies, attitude, pose, answer.travel_mm + 1.0 - rounding_mm);
      for (const geometry::GapFeature& f : all.vertices) EXPECT_TRUE(holds(answer.features, f));
      for (const geometry::GapFeature& f : all.edges) n_skipped += holds(answer.features, f) ? 0 : 1;
      for (const geometry::GapFeature& feature : answer.features) {
        const bool is_vertex = holds(all.vertices, feature), is_edges = holds(all.edges, feature);
        EXPECT_TRUE(is_vertex || is_edges || feature.travel_mm > answer.travel_mm + 1.0 - 2 * rounding_mm);
        n_vertices += is_vertex ? 1 : 0;
        n_edges += is_edges ? 1 : 0;
      }
    }
  }
  EXPECT_GT(n_vertices, 100U);
  EXPECT_GT(n_edges, 100U);
  EXPECT_GT(n_skipped, 100U) << "flat and reflex edges";
}

// Derivatives of the travel by central differences of queries.
Vector5d gradient_by_differences(geometry::GapQuery& query, const Attitude& attitude, const MovingPose& pose,
                                 double step)
{
  Vector5d gradient;
  for (Eigen::Index k = 0; k < n_coordinates; ++k) {
    double side[2];
    for (const int sign : {0, 1}) {
      const double change = sign == 0 ? -step : step;
      Attitude there = attitude;
      MovingPose moved = pose;
      if (k < 3) moved.translation_mm[k] += change;
      if (k == about_y) moved.theta_rad += change;
      if (k == about_varus) there.varus_rad += change;
      query.set_attitude(there);
      side[sign] = query.travel_mm(moved);
    }
    gradient[k] = (side[1] - side[0]) / (2 * step);
  }
  return gradient;
}

/// d travel / d coordinates: -(J^T n) / n.y, with J the Jacobian of the material point at contact, i.e. after
/// the travel along +Y.
Vector5d travel_gradient(const geometry::GapFeature& feature, const MovingPose& pose)
{
  const Eigen::Vector3d touch = feature.point_mm + feature.travel_mm * Eigen::Vector3d::UnitY();
  return -(point_jacobian(touch, pose).transpose() * feature.normal) / feature.normal.y();
}

TEST(GapFeatures, GradientMatchesDifferencesAwayFromKinks)
{
  GapRandom random(13);
  int n_checked = 0, n_kinks = 0;
  const double step = 1e-6;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    for (int k = 0; k < 40; ++k) {
      const Attitude attitude = random.attitude();
      const MovingPose pose = random.pose(4, bodies.depth_mm);
      query.set_attitude(attitude);
      // Lever arms are up to 50 mm: over these steps no feature outside the band can become the minimum.
      const geometry::GapResult& answer = query.features(pose, 200 * step);
      const bool is_smooth = answer.features.size() == 1;
      (is_smooth ? n_checked : n_kinks) += 1;
      const Vector5d expected = travel_gradient(answer.features.front(), pose);
      EXPECT_NEAR(expected[along_y], -1.0, 1e-14);
      const Vector5d measured = is_smooth ? gradient_by_differences(query, attitude, pose, step) : expected;
      // Rounding / step, and the curvature of a rotation by 1e-6 rad over 50 mm, each with slopes up to 100.
      EXPECT_LT((measured - expected).cwiseAbs().maxCoeff(), 1e-5 * (1.0 + expected.cwiseAbs().maxCoeff()));
    }
  }
  EXPECT_GT(n_checked, 80);
  EXPECT_GT(n_kinks, 0);
}

TEST(GapFeatures, AtAKinkTheLeastOfAllLinearisationsHolds)
{
  // A face of the moving sheet directly under the common corner of four faces of the reference.
  Mesh upper;
  upper.vertices_mm.resize(5, 3);
  upper.vertices_mm << 0, 0, 0, 5, 2, 0, 0, 3, 5, -5, 1, 0, 0, 2.5, -5;
  upper.triangles.resize(4, 3);
  upper.triangles << 0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1;
  Mesh lower = test::sheet(20, 2);
  const MovingPose pose{{0.7, -4, 0.4}, 0.3};
  geometry::GapQuery query{geometry::GapTree(upper), geometry::GapTree(lower)};
  const geometry::GapResult answer = query.features(pose, 1e-9);
  EXPECT_NEAR(answer.travel_mm, 4.0, rounding_mm);
  GapRandom random(22);
  const double step = 1e-6;
  int n_up = 0;
  for (int k = 0; k < 50; ++k) {
    MovingPose moved = pose;
    Vector5d change = Vector5d::Zero();
    for (Eigen::Index i = 0; i < 4; ++i) change[i] = step * random.unit();
    moved.translation_mm += change.head<3>();
    moved.theta_rad += change[about_y];
    double least = std::numeric_limits<double>::infinity();
    for (const geometry::GapFeature& feature : answer.features) {
      least = std::min(least, feature.travel_mm + travel_gradient(feature, pose).dot(change));
    }
    EXPECT_NEAR(query.travel_mm(moved), least, rounding_mm);
    n_up += least > answer.travel_mm ? 1 : 0;
  }
  EXPECT_GT(n_up, 10);
}

// The accuracy that is promised.
constexpr double closed_form_mm = 1e-9;
// Heights of some 30 mm, each a root or a sum of a few products; a sliver's slope may amplify errors.
constexpr double slope_rounding_mm = 1e-9;

Mesh with_offset(Mesh mesh, double mm)
{
  mesh.offset_mm.assign(static_cast<std::size_t>(mesh.triangles.rows()), mm);
  return mesh;
}

// One triangle; seen from above counter-clockwise if `faces_up`.
Mesh triangle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c)
{
  Mesh mesh;
  mesh.vertices_mm.resize(3, 3);
  mesh.vertices_mm << a.transpose(), b.transpose(), c.transpose();
  mesh.triangles.resize(1, 3);
  mesh.triangles << 0, 1, 2;
  return mesh;
}

// A needle with its tip at `tip` and the rest far below or above it; both sides.
Mesh needle(const Eigen::Vector3d& tip, double to_y)
{
  const Eigen::Vector3d base = tip + Eigen::Vector3d(0, to_y, 0);
  Mesh mesh;
  mesh.vertices_mm.resize(4, 3);
  mesh.vertices_mm << tip.transpose(), (base + Eigen::Vector3d(1, 0, 0)).transpose(),
      (base + Eigen::Vector3d(-1, 0, 1)).transpose(), (base + Eigen::Vector3d(-1, 0, -1)).transpose();
  mesh.triangles.resize(4, 3);
  mesh.triangles << 0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2;
  if (signed_volume_mm3(mesh) < 0.0) mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

struct Travels {
  double query_mm, next_mm, tree_mm;
};

Travels travels(const Mesh& reference, const Mesh& moving, const MovingPose& pose = {},
                const Attitude& attitude = {})
{
  geometry::GapQuery query{geometry::GapTree(reference), geometry::GapTree(moving)};
  query.set_attitude(attitude);
  const geometry::TreeMesh turned = rotated_reference(geometry::make_tree_mesh(reference), attitude);
  return {query.travel_mm(pose), query.next_contact(pose).travel_mm,
          test::directional_gap(turned, moving, geometry::BoxTree(moving), pose).travel_mm};
}

void expect_travel(const Mesh& reference, const Mesh& moving, double expected_mm)
{
  const Travels found = travels(reference, moving);
  EXPECT_NEAR(found.query_mm, expected_mm, closed_form_mm);
  EXPECT_NEAR(found.next_mm, expected_mm, closed_form_mm);
  EXPECT_NEAR(found.tree_mm, expected_mm, closed_form_mm);
}

// A large face over the origin at `height_mm`, directed down, with a slope along X.
Mesh ceiling(double height_mm, double slope)
{
  const auto at = [&](double x, double z) { return Eigen::Vector3d(x, height_mm + slope * x, z); };
  return triangle(at(-60, -60), at(80, 0), at(-60, 60));
}

TEST(RoundedGap, ASphereTouchesAPlane)
{
  // The centre is at 0, the plane at 10 along Y with a slope: 10 - r sqrt(1 + slope^2).
  for (const double slope : {0.0, 0.3, 1.5}) {
    SCOPED_TRACE(slope);
    const double r = 1.25, expected = 10.0 - r * std::sqrt(1.0 + slope * slope);
    expect_travel(ceiling(10, slope), with_offset(needle({0, 0, 0}, -40), r), expected);
    expect_travel(with_offset(ceiling(10, slope), r), needle({0, 0, 0}, -40), expected);
    expect_travel(with_offset(ceiling(10, slope), 0.5), with_offset(needle({0, 0, 0}, -40), 0.75), expected);
  }
}

TEST(RoundedGap, TwoSpheresTouch)
{
  // Centres 10 apart along Y and d across: 10 - sqrt((r + R)^2 - d^2); they pass beyond r + R.
  for (const double across : {0.0, 0.4, 1.2, 1.9}) {
    SCOPED_TRACE(across);
    const Mesh reference = with_offset(needle({0, 10, 0}, 40), 1.5);
    const Mesh moving = with_offset(needle({0.6 * across, 0, 0.8 * across}, -40), 0.5);
    expect_travel(reference, moving, 10.0 - std::sqrt(4.0 - across * across));
  }
}

// Two thin roofs: an edge along X at height 10 over the reference's flanks, one along `angle` at height 0.
Mesh roof(double angle_rad, double y, double flanks_mm)
{
  const Eigen::Vector3d u(std::cos(angle_rad), 0, std::sin(angle_rad)), v(-u.z(), 0, u.x());
  const Eigen::Vector3d ridge(0, y, 0), down(0, flanks_mm, 0);
  Mesh mesh;
  mesh.vertices_mm.resize(4, 3);
  mesh.vertices_mm << (ridge - 30 * u).transpose(), (ridge + 30 * u).transpose(),
      (ridge + down + 3 * v).transpose(), (ridge + down - 3 * v).transpose();
  mesh.triangles.resize(4, 3);
  mesh.triangles << 0, 1, 2, 1, 0, 3, 0, 2, 3, 1, 3, 2;
  if (signed_volume_mm3(mesh) < 0.0) mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

TEST(RoundedGap, AnEdgeTouchesAnEdge)
{
  // Horizontal lines 10 apart that cross: 10 - r at any angle.
  for (const double angle : {0.3, 1.0, 1.5707963267948966}) {
    SCOPED_TRACE(angle);
    expect_travel(with_offset(roof(0.0, 10, 30), 0.7), with_offset(roof(angle, 0, -30), 0.4), 10.0 - 1.1);
  }
}

TEST(RoundedGap, AVertexTouchesAnEdgeAndAnEdgeAVertex)
{
  // d beside the line: 10 - sqrt(r^2 - d^2).
  const double expected = 10.0 - std::sqrt(1.1 * 1.1 - 0.6 * 0.6);
  expect_travel(with_offset(roof(0.0, 10, 30), 1.1), needle({2, 0, 0.6}, -40), expected);
  expect_travel(needle({2, 10, 0.6}, 40), with_offset(roof(0.0, 0, -30), 1.1), expected);
}

TEST(RoundedGap, MeshesThatPassBareTouchRounded)
{
  // Two needles 1 mm apart across Delta: the trees must reach beyond the bare boxes.
  const Mesh reference = needle({0, 10, 0}, 40), moving = needle({3, 0, 0}, -40);
  EXPECT_TRUE(std::isinf(travels(reference, moving).query_mm));
  expect_travel(with_offset(reference, 4), moving, 10.0 - std::sqrt(16.0 - 9.0));
}

TEST(RoundedGap, APairWithinTheOffsetHasNoTravelLeftAndAPassedOneNone)
{
  const Mesh reference = with_offset(needle({0, 10, 0}, 1), 0.5), moving = needle({0, 0, 0}, -1);
  const auto next_mm = [&](double y) { return travels(reference, moving, {{0, y, 0}, 0.0}).next_mm; };
  EXPECT_NEAR(next_mm(9.0), 0.5, closed_form_mm);
  EXPECT_EQ(next_mm(9.8), 0.0);
  EXPECT_EQ(next_mm(12.4), 0.0);  // the base is within 0.5 mm of the reference's base, 11 + 1 + 0.5
  EXPECT_TRUE(std::isinf(next_mm(12.6)));
}

TEST(RoundedGap, FeaturesMeetAtTheOffsetAlongTheirNormal)
{
  GapRandom random(19);
  int n_features = 0;
  std::array<int, 6> of_kind{};
  for (GapBodies bodies : test::gap_bodies(random)) {
    bodies.reference = with_offset(bodies.reference, 1.0);
    bodies.moving = with_offset(bodies.moving, 0.5);
    geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    for (int k = 0; k < 20; ++k) {
      const Attitude attitude = random.attitude();
      const MovingPose pose = random.pose(8, bodies.depth_mm);
      query.set_attitude(attitude);
      for (const geometry::GapFeature& feature : query.features(pose, 0.05).features) {
        // The reference's point is on its triangle's plane or edge: within rounding of the triangle.
        const Eigen::Vector3d p_mm = feature.point_mm + feature.travel_mm * Eigen::Vector3d::UnitY() -
                                     feature.offset_mm * feature.normal;
        const geometry::TreeMesh turned =
            rotated_reference(geometry::make_tree_mesh(bodies.reference), attitude);
        const auto [a, b, c] = corners(turned.mesh, feature.triangles.reference);
        const Eigen::Vector3d n = (b - a).cross(c - a).normalized();
        EXPECT_NEAR(n.dot(p_mm - a), 0.0, 1e-7);
        EXPECT_NEAR(feature.normal.norm(), 1.0, 1e-12);
        EXPECT_LT(feature.normal.y(), 0.0);
        ++n_features;
        ++of_kind[static_cast<std::size_t>(feature.kind)];
      }
    }
  }
  EXPECT_GT(n_features, 60);
  for (const int n : of_kind) EXPECT_GT(n, 0);
}

}  // namespace vrda::gap_features_test
