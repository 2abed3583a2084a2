#include "contact/contacts.hpp"

#include <gmock/gmock.h>

#include <cmath>

#include "core/units.hpp"
#include "model/frames.hpp"
#include "support/meshes.hpp"

namespace vrda::contacts_test {

constexpr double exact_mm = 1e-9;
constexpr double standoff_mm = 0.01;

// A square pyramid, apex up at the origin, half width and height as given.
Mesh pyramid(double half_mm, double height_mm)
{
  Mesh mesh;
  mesh.vertices_mm.resize(5, 3);
  mesh.vertices_mm << 0, 0, 0, half_mm, -height_mm, half_mm, half_mm, -height_mm, -half_mm, -half_mm,
      -height_mm, -half_mm, -half_mm, -height_mm, half_mm;
  mesh.triangles.resize(6, 3);
  mesh.triangles << 0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 1, 1, 4, 3, 1, 3, 2;
  return mesh;
}

// A prism with its ridge up along Z at y = 0.
Mesh roof(double half_length_mm)
{
  Mesh mesh;
  mesh.vertices_mm.resize(6, 3);
  mesh.vertices_mm << 0, 0, -half_length_mm, 1, -1, -half_length_mm, -1, -1, -half_length_mm, 0, 0,
      half_length_mm, 1, -1, half_length_mm, -1, -1, half_length_mm;
  mesh.triangles.resize(8, 3);
  mesh.triangles << 0, 1, 2, 3, 5, 4, 0, 3, 4, 0, 4, 1, 0, 2, 5, 0, 5, 3, 1, 4, 5, 1, 5, 2;
  return mesh;
}

std::vector<contact::Contact> contacts_of(const Mesh& reference, const Mesh& moving, const MovingPose& pose,
                                          const contact::ContactOptions& options = {})
{
  contact::NarrowPhase narrow_phase;
  const contact::Collider r = contact::make_collider(reference);
  const contact::Collider m = contact::make_collider(moving);
  return contact::find_contacts({r.tree_mesh, r.features, m}, pose, narrow_phase, options);
}

TEST(Contacts, ApexUnderFaceIsOneContactWithTheFacesNormal)
{
  // The underside of a box tilted about Z; the apex touches it from below.
  Pose tilt = Pose::Identity();
  tilt.linear() = rotation_z(rad_from_deg(10));
  const Mesh reference = transformed(test::box({0, 5, 0}, {20, 10, 20}), tilt);
  const Eigen::Vector3d n = tilt.linear() * Eigen::Vector3d(0, -1, 0);
  const Eigen::Vector3d on_face = tilt * Eigen::Vector3d(2, 0, 3);
  const MovingPose pose{on_face + standoff_mm * n, 0.3};
  const std::vector<contact::Contact> contacts = contacts_of(reference, pyramid(3, 4), pose);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_LT((contacts[0].point_mm - on_face).norm(), exact_mm);
  EXPECT_LT((contacts[0].normal - n).norm(), exact_mm);
  EXPECT_NEAR(contacts[0].distance_mm, standoff_mm, exact_mm);
}

// The apex is found through each of its four faces: the narrow phase measures one pair.
TEST(Contacts, AreMeasuredByTheNarrowPhaseOnceAFeature)
{
  const contact::Collider box = contact::make_collider(test::box({0, 5, 0}, {20, 10, 20}));
  const contact::Collider apex = contact::make_collider(pyramid(3, 4));
  contact::NarrowPhase narrow_phase;
  const std::vector<contact::Contact> contacts = contact::find_contacts(
      {box.tree_mesh, box.features, apex}, {{2, -standoff_mm, 3}, 0.3}, narrow_phase, {});
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(narrow_phase.n_measured(), 1);
}

TEST(Contacts, CrossingEdgesGiveTheirCrossProduct)
{
  // Lower edge of a bar along X rolled by 45 degrees, over the upper edge of one along Z.
  Pose roll_x = Pose::Identity(), roll_z = Pose::Identity();
  roll_x.linear() = rotation_x(rad_from_deg(45));
  roll_z.linear() = rotation_z(rad_from_deg(45));
  const double half_diagonal = std::sqrt(2.0);
  const Mesh upper = transformed(test::box({0, 0, 0}, {30, 2, 2}), roll_x);
  const Mesh lower = transformed(test::box({0, 0, 0}, {2, 2, 30}), roll_z);
  const MovingPose pose{{0.5, -2 * half_diagonal - standoff_mm, 0.25}, 0.0};
  const std::vector<contact::Contact> contacts = contacts_of(upper, lower, pose);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_LT((contacts[0].point_mm - Eigen::Vector3d(0.5, -half_diagonal, 0)).norm(), exact_mm);
  EXPECT_LT((contacts[0].normal - Eigen::Vector3d(0, -1, 0)).norm(), exact_mm);
}

TEST(Contacts, FlatFacesTouchAtTheCornersOfTheirCommonPolygon)
{
  const Mesh upper = test::box({0, 2, 0}, {4, 4, 4});
  const Mesh lower = test::box({0, -1, 0}, {4, 2, 4});
  const std::vector<contact::Contact> contacts = contacts_of(upper, lower, {{1.0, -standoff_mm, 0.5}, 0.0});
  // Overlap: x from -1 to 2, z from -1.5 to 2; the diagonals of both faces add crossings on its border or
  // inside.
  const auto has = [&](double x, double z) {
    return std::any_of(contacts.begin(), contacts.end(), [&](const contact::Contact& c) {
      return (c.point_mm - Eigen::Vector3d(x, 0, z)).norm() < exact_mm;
    });
  };
  EXPECT_TRUE(has(-1, -1.5));
  EXPECT_TRUE(has(-1, 2));
  EXPECT_TRUE(has(2, -1.5));
  EXPECT_TRUE(has(2, 2));
  for (const contact::Contact& c : contacts) {
    EXPECT_LT((c.normal - Eigen::Vector3d(0, -1, 0)).norm(), exact_mm);
    EXPECT_TRUE(c.point_mm.x() > -1 - exact_mm && c.point_mm.x() < 2 + exact_mm);
  }
}

TEST(Contacts, LeastCurvatureTakesTheFlatSideAndTheOthersTakeTheirs)
{
  // A box corner region far from a vertex: apex (sharp) under a gently curved ball seen from below.
  const Mesh reference = test::ball(50, 64, 128);
  const MovingPose pose{{0, -50 - standoff_mm, 0}, 0.0};
  contact::ContactOptions options;
  const std::vector<contact::Contact> least = contacts_of(reference, pyramid(3, 4), pose, options);
  ASSERT_EQ(least.size(), 1u);
  EXPECT_LT((least[0].normal - Eigen::Vector3d(0, -1, 0)).norm(), 1e-6) << "symmetry about the pole";
  options.normals = ContactNormals::reference;
  const std::vector<contact::Contact> reference_side = contacts_of(reference, pyramid(3, 4), pose, options);
  ASSERT_EQ(reference_side.size(), 1u);
  EXPECT_LT((reference_side[0].normal - Eigen::Vector3d(0, -1, 0)).norm(), 1e-6);
  options.normals = ContactNormals::moving;
  const std::vector<contact::Contact> moving_side = contacts_of(reference, pyramid(3, 4), pose, options);
  ASSERT_EQ(moving_side.size(), 1u);
  EXPECT_LT(moving_side[0].normal.y(), 0.0);
}

TEST(Contacts, NothingActsAlongTheEdgeThatAVertexTouches)
{
  // The apex of a flat pyramid leaning by 10 degrees about Z under the lower edge of a bar along X. The apex
  // bends less, and the mean of its faces leans along the edge.
  Pose roll = Pose::Identity(), lean = Pose::Identity();
  roll.linear() = rotation_x(rad_from_deg(45));
  lean.linear() = rotation_z(rad_from_deg(10));
  const Mesh bar = transformed(test::box({0, 0, 0}, {30, 2, 2}), roll);
  const Mesh apex = transformed(pyramid(3, 1), lean);
  const double apart_mm = std::sqrt(2.0) + standoff_mm;
  const std::vector<contact::Contact> from_below = contacts_of(bar, apex, {{0.5, -apart_mm, 0}, 0.0});
  ASSERT_EQ(from_below.size(), 1u);
  EXPECT_LT((from_below[0].normal - Eigen::Vector3d(0, -1, 0)).norm(), exact_mm);
  // The same with the roles exchanged: the pyramid points down and the bar is below.
  Pose over = Pose::Identity();
  over.linear() = rotation_x(pi);
  const std::vector<contact::Contact> hanging =
      contacts_of(transformed(apex, over), bar, {{0.5, -apart_mm, 0}, 0.0});
  ASSERT_EQ(hanging.size(), 1u);
  EXPECT_LT((hanging[0].normal - Eigen::Vector3d(0, -1, 0)).norm(), exact_mm);
}

TEST(Contacts, BackFacesStruckFromBehindAreDropped)
{
  // The moving tip has passed an upward-facing sheet and touches it from above: no reaction along -Delta.
  const Mesh sheet = test::sheet(10, 4);  // normal +Y
  EXPECT_TRUE(contacts_of(sheet, pyramid(1, 4), {{0.3, -standoff_mm, 0.2}, 0.0}).empty());
  Mesh underside = sheet;
  underside.triangles.col(1).swap(underside.triangles.col(2));
  EXPECT_EQ(contacts_of(underside, pyramid(1, 4), {{0.3, -standoff_mm, 0.2}, 0.0}).size(), 1u);
}

// A ridge from z = -1 to 1 under a box that ends at z = 0.5: any point between is nearest.
TEST(Contacts, ARidgeUnderAFaceTouchesAtTheEndsOfTheCommonSegment)
{
  const Mesh ridge = roof(1.0);
  for (const double turn : {0.0, 0.3}) {
    SCOPED_TRACE(turn);
    const Mesh above = transformed(test::box({0.2, 2, -1.5}, {4, 4, 4}),
                                   Pose(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY())));
    const std::vector<contact::Contact> contacts = contacts_of(above, ridge, {{0, -standoff_mm, 0}, 0});
    // The box's face has a diagonal, across which the ridge goes from one triangle to the other.
    double least = 1.0, most = -1.0;
    for (const contact::Contact& c : contacts) {
      EXPECT_NEAR(c.point_mm.x(), 0.0, exact_mm);
      EXPECT_NEAR(c.point_mm.y(), 0.0, exact_mm);
      EXPECT_NEAR(c.distance_mm, standoff_mm, exact_mm);
      least = std::min(least, c.point_mm.z());
      most = std::max(most, c.point_mm.z());
    }
    EXPECT_LE(contacts.size(), 3U);
    EXPECT_NEAR(least, -1.0, exact_mm);
    EXPECT_NEAR(most, 0.5 / std::cos(turn), exact_mm);
  }
}

TEST(Contacts, TwoParallelRidgesTouchAtTheEndsOfTheirCommonSegment)
{
  const Mesh above = transformed(
      roof(2.0), Pose(Eigen::AngleAxisd(pi, Eigen::Vector3d::UnitX()) * Eigen::Translation3d(0, 0, -1.6)));
  const std::vector<contact::Contact> contacts = contacts_of(above, roof(1.0), {{0, -standoff_mm, 0}, 0});
  ASSERT_EQ(contacts.size(), 2U);
  const double least = std::min(contacts[0].point_mm.z(), contacts[1].point_mm.z());
  const double most = std::max(contacts[0].point_mm.z(), contacts[1].point_mm.z());
  EXPECT_NEAR(least, -0.4, exact_mm);
  EXPECT_NEAR(most, 1.0, exact_mm);
}

// Any point of the ridge over the triangle is a closest one, and which the narrow phase finds depends on
// rounding.
TEST(Contacts, ARidgeAcrossATriangleTouchesAtBothEndsOfTheCommonSegment)
{
  Mesh table;  // a prism with a triangle on top
  table.vertices_mm.resize(6, 3);
  table.vertices_mm << -2, 0, -2, 0, 0, 2, 2, 0, -2, -2, -3, -2, 0, -3, 2, 2, -3, -2;
  table.triangles.resize(8, 3);
  table.triangles << 0, 1, 2, 3, 5, 4, 0, 3, 4, 0, 4, 1, 1, 4, 5, 1, 5, 2, 2, 5, 3, 2, 3, 0;
  const Mesh ridge = transformed(roof(10.0), Pose(Eigen::AngleAxisd(pi, Eigen::Vector3d::UnitZ())));
  for (int k = 0; k < 60; ++k) {
    const MovingPose pose{{0.1, -standoff_mm, 0.3}, 0.05 + 0.1 * k};
    const std::vector<contact::Contact> contacts = contacts_of(ridge, table, pose);
    ASSERT_EQ(contacts.size(), 2U) << pose.theta_rad;
    double low_mm = 10.0, high_mm = -10.0;  // where the triangle's border crosses the ridge, x = 0
    for (Eigen::Index i = 0; i < 3; ++i) {
      const Eigen::Matrix3d R = rotation_y(pose.theta_rad);
      const Eigen::Vector3d from = R * table.vertices_mm.row(i).transpose() + pose.translation_mm;
      const Eigen::Vector3d to = R * table.vertices_mm.row((i + 1) % 3).transpose() + pose.translation_mm;
      if ((from.x() > 0.0) == (to.x() > 0.0)) continue;
      const double z_mm = from.z() + from.x() / (from.x() - to.x()) * (to.z() - from.z());
      low_mm = std::min(low_mm, z_mm);
      high_mm = std::max(high_mm, z_mm);
    }
    const double a_mm = contacts[0].point_mm.z(), b_mm = contacts[1].point_mm.z();
    EXPECT_NEAR(std::min(a_mm, b_mm), low_mm, exact_mm);
    EXPECT_NEAR(std::max(a_mm, b_mm), high_mm, exact_mm);
  }
}

TEST(Contacts, NothingBeyondTheBand)
{
  EXPECT_TRUE(contacts_of(test::box({0, 2, 0}, {4, 4, 4}), pyramid(1, 1), {{0, -0.11, 0}, 0}).empty());
  EXPECT_EQ(contacts_of(test::box({0, 2, 0}, {4, 4, 4}), pyramid(1, 1), {{0.3, -0.09, 0.1}, 0}).size(), 1u);
}

TEST(Contacts, TriangleCentresReproduceTheFirstImplementation)
{
  contact::ContactOptions options;
  options.points = ContactPoints::triangle_centre;
  options.normals = ContactNormals::reference;
  Mesh underside = test::sheet(6, 1);
  underside.triangles.col(1).swap(underside.triangles.col(2));
  underside.normals = -underside.normals;
  const MovingPose pose{{1.0, -standoff_mm, -1.5}, 0.0};
  const std::vector<contact::Contact> contacts = contacts_of(underside, pyramid(1, 1), pose, options);
  ASSERT_FALSE(contacts.empty());
  const auto corner = corners(underside, contacts[0].triangles.reference);
  EXPECT_LT((contacts[0].point_mm - (corner[0] + corner[1] + corner[2]) / 3.0).norm(), exact_mm);
  EXPECT_EQ(contacts[0].application_mm, contacts[0].point_mm);
  EXPECT_LT((contacts[0].normal - Eigen::Vector3d(0, -1, 0)).norm(), exact_mm);
}

TEST(Collision, BallsTouchWhenTheirCentresAreNearEnough)
{
  contact::NarrowPhase narrow_phase;
  const geometry::TreeMesh upper = geometry::make_tree_mesh(test::ball(10, 32, 64));
  const geometry::TreeMesh lower = geometry::make_tree_mesh(test::ball(6, 32, 64));
  // Facets are inside the spheres by at most the sagitta of an edge of pi / 32.
  const double facet_mm = 16 * (pi / 32) * (pi / 32) / 8 * 2;
  for (const double angle : {0.0, 0.4, 1.0}) {
    const Eigen::Vector3d away(std::sin(angle), -std::cos(angle), 0);
    EXPECT_FALSE(contact::find_collision(upper, lower, {16.001 * away, 0.1}, narrow_phase).has_value());
    EXPECT_TRUE(
        contact::find_collision(upper, lower, {(16 - facet_mm) * away, 0.1}, narrow_phase).has_value());
  }
}

TEST(SelfOverlap, ASoundMeshHasNoneAndTwoCrossingBoxesHaveSome)
{
  contact::NarrowPhase narrow_phase;
  EXPECT_TRUE(contact::find_self_overlaps(geometry::make_tree_mesh(test::ball(10, 12, 20)), narrow_phase, 100)
                  .empty());
  Mesh crossing = test::box({0, 0, 0}, {4, 4, 4});
  append(crossing, test::box({1, 1, 1}, {4, 4, 4}));
  const std::vector<geometry::TrianglePair> found =
      contact::find_self_overlaps(geometry::make_tree_mesh(crossing), narrow_phase, 1000);
  std::vector<geometry::TrianglePair> all;  // no triangles of different boxes share a vertex
  for (std::int32_t i = 0; i < 12; ++i) {
    for (std::int32_t k = 12; k < 24; ++k) {
      if (narrow_phase.overlap(corners(crossing, i), corners(crossing, k))) all.push_back({i, k});
    }
  }
  EXPECT_FALSE(all.empty());
  EXPECT_THAT(found, testing::UnorderedElementsAreArray(all));
  EXPECT_EQ(contact::find_self_overlaps(geometry::make_tree_mesh(crossing), narrow_phase, 2).size(), 2u);
}

TEST(Collision, AHintIsTriedFirstAndChangesNothingElse)
{
  contact::NarrowPhase narrow_phase;
  const geometry::TreeMesh upper = geometry::make_tree_mesh(test::box({0, 0, 0}, {4, 4, 4}));
  const geometry::TreeMesh lower = geometry::make_tree_mesh(test::box({0, 0, 0}, {4, 4, 4}));
  const auto hit = contact::find_collision(upper, lower, {{1, -3, 1}, 0.2}, narrow_phase);
  ASSERT_TRUE(hit.has_value());
  EXPECT_EQ(contact::find_collision(upper, lower, {{1, -3, 1}, 0.2}, narrow_phase, *hit), hit);
  EXPECT_FALSE(contact::find_collision(upper, lower, {{1, -5, 1}, 0.2}, narrow_phase, *hit).has_value());
}

TEST(SurfaceFeatures, ABoxBendsByARightAngleAtItsEdgesAndNotOnItsDiagonals)
{
  const Mesh box = test::box({0, 0, 0}, {2, 4, 6});
  const contact::SurfaceFeatures features(box);
  int n_sharp = 0, n_flat = 0;
  for (std::int32_t t = 0; t < 12; ++t) {
    for (int k = 0; k < 3; ++k) {
      const double bend = features.bend({contact::FeatureKind::edge, features.edge_of(t, k)});
      const bool is_diagonal = bend < 0.5;
      EXPECT_NEAR(bend, is_diagonal ? 0.0 : 1.0, 1e-12);
      (is_diagonal ? n_flat : n_sharp) += 1;
    }
  }
  EXPECT_EQ(n_sharp, 24);
  EXPECT_EQ(n_flat, 12);
  for (std::int32_t v = 0; v < 8; ++v)
    EXPECT_NEAR(features.bend({contact::FeatureKind::vertex, v}), 1.0, 1e-12);
  EXPECT_EQ(features.bend({contact::FeatureKind::face, 3}), 0.0);
}

TEST(SurfaceFeatures, OpenEdgesAreSharpest)
{
  const Mesh sheet = test::sheet(4, 2);
  const contact::SurfaceFeatures features(sheet);
  EXPECT_EQ(features.bend({contact::FeatureKind::vertex, 0}), 2.0);
  EXPECT_NEAR(features.bend({contact::FeatureKind::vertex, 4}), 0.0, 1e-12) << "the middle";
  EXPECT_EQ(features.star({contact::FeatureKind::vertex, 4}).size(), 6u);
}

TEST(SurfaceFeatures, PointsAreFoundOnTheirFeature)
{
  const Mesh sheet = test::sheet(4, 1);  // triangles (0, 1, 3) and (0, 3, 2)
  const contact::SurfaceFeatures features(sheet);
  const auto corner = corners(sheet, 0);
  const auto at = [&](double a, double b, double c) {
    return contact::feature_at(sheet, features, 0, a * corner[0] + b * corner[1] + c * corner[2], corner);
  };
  EXPECT_EQ(at(0.3, 0.3, 0.4).kind, contact::FeatureKind::face);
  EXPECT_EQ(at(0.5, 0.5, 0.0), (contact::Feature{contact::FeatureKind::edge, features.edge_of(0, 0)}));
  EXPECT_EQ(at(0.0, 0.5, 0.5), (contact::Feature{contact::FeatureKind::edge, features.edge_of(0, 1)}));
  EXPECT_EQ(at(0.5, 0.0, 0.5), (contact::Feature{contact::FeatureKind::edge, features.edge_of(0, 2)}));
  EXPECT_EQ(at(0.0, 1.0, 0.0), (contact::Feature{contact::FeatureKind::vertex, 1}));
  EXPECT_EQ(features.edge_of(0, 2), features.edge_of(1, 0)) << "the shared diagonal";
}

}  // namespace vrda::contacts_test
