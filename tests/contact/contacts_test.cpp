// Contact points, normals and distances against closed form, under random rigid motions of both objects.
#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "contact/contacts.hpp"
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

constexpr int n_placements = 400;
// Less than the distance to the neighbours of a ball's vertex.
constexpr double band_mm = 0.02;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high)
  {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }
  Eigen::Vector3d within(double size_mm)
  {
    return {between(-size_mm, size_mm), between(-size_mm, size_mm), between(-size_mm, size_mm)};
  }
  /// Log-uniform from 1e-7 mm to half the band.
  double standoff_mm() { return 0.5 * band_mm * std::pow(10.0, between(-5.0, 0.0)); }

 private:
  std::mt19937_64 engine_;
};

Pose turned_by(const Eigen::Matrix3d& R)
{
  Pose X = Pose::Identity();
  X.linear() = R;
  return X;
}

Pose shifted_by(const Eigen::Vector3d& by_mm)
{
  return Pose(Eigen::Translation3d(by_mm));
}

// Two objects made in a local frame L in which the contact's normal is known, and the pose of L in S. The
// reference is placed by an attitude, the moving object by a pose.
struct Placed {
  Pose X_S_L;
  geometry::TreeMesh reference;
  contact::SurfaceFeatures reference_features;
  contact::Collider moving;
  MovingPose pose;
};

Placed placed(const Mesh& reference, const Mesh& moving, const Eigen::Vector3d& normal_local, Random& random)
{
  Placed result;
  Attitude attitude;
  Pose X_reference_L;
  // Reactions must oppose Delta.
  do {
    attitude = {random.between(-pi, pi), random.between(-1.5, 1.5)};
    X_reference_L = shifted_by(random.within(100.0)) *
                    turned_by(rotation_z(random.between(-1.0, 1.0)) * rotation_y(random.between(-pi, pi)));
    result.X_S_L = turned_by(reference_rotation(attitude)) * X_reference_L;
  } while ((result.X_S_L.linear() * normal_local).y() > -0.1);
  result.pose = {random.within(100.0), random.between(-pi, pi)};
  const contact::Collider fixed = contact::make_collider(transformed(reference, X_reference_L));
  result.reference = geometry::rotated_reference(fixed.tree_mesh, attitude);
  result.reference_features = fixed.features;
  result.moving = contact::make_collider(transformed(moving, pose_of(result.pose).inverse() * result.X_S_L));
  return result;
}

struct Expected {
  Eigen::Vector3d on_reference;
  Eigen::Vector3d on_moving;
  Eigen::Vector3d normal;
};

enum class Taken { from_reference, from_moving };

// Expects one contact, given in L.
void expect_contact(const Placed& scene, const Expected& expected, Taken taken, ContactNormals normals)
{
  contact::NarrowPhase narrow_phase;
  contact::ContactOptions options;
  options.band_mm = band_mm;
  options.normals = normals;
  const std::vector<contact::Contact> contacts = contact::find_contacts(
      {scene.reference, scene.reference_features, scene.moving}, scene.pose, narrow_phase, options);
  ASSERT_EQ(contacts.size(), 1U);
  const Pose X_L_S = scene.X_S_L.inverse();
  const contact::Contact& c = contacts[0];
  EXPECT_LT((X_L_S * c.point_mm - expected.on_reference).norm(), exact_mm);
  const Eigen::Vector3d application =
      taken == Taken::from_reference ? expected.on_reference : expected.on_moving;
  EXPECT_LT((X_L_S * c.application_mm - application).norm(), exact_mm);
  EXPECT_LT((X_L_S.linear() * c.normal - expected.normal).norm(), exact_mm);
  EXPECT_NEAR(c.distance_mm, (expected.on_moving - expected.on_reference).norm(), exact_mm);
}

// Apex at the origin, pointing up, tilted by up to 20 degrees.
Mesh tilted_pyramid(Random& random)
{
  return transformed(pyramid(3, 4), turned_by(rotation_y(random.between(-pi, pi)) *
                                              rotation_x(random.between(-0.35, 0.35))));
}

const Eigen::Matrix3d upside_down = Eigen::Vector3d(1, -1, -1).asDiagonal();

// Random points of the face away from its diagonal, which is an edge.
Eigen::Vector3d on_face(Random& random)
{
  Eigen::Vector3d p;
  do {
    p = {random.between(-9, 9), 0.0, random.between(-9, 9)};
  } while (std::abs(std::abs(p.x()) - std::abs(p.z())) < 0.1);
  return p;
}

TEST(ClosedForm, VertexUnderAFace)
{
  Random random(61);
  const Mesh above = test::box({0, 5, 0}, {20, 10, 20});
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const Eigen::Vector3d p = on_face(random), apex = p - random.standoff_mm() * Eigen::Vector3d::UnitY();
    const Mesh below = transformed(tilted_pyramid(random), shifted_by(apex));
    const Eigen::Vector3d n(0, -1, 0);
    expect_contact(placed(above, below, n, random), {p, apex, n}, Taken::from_reference,
                   ContactNormals::least_curvature);
  }
}

TEST(ClosedForm, VertexOverAFace)
{
  Random random(62);
  const Mesh below = test::box({0, -5, 0}, {20, 10, 20});
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const Eigen::Vector3d p = on_face(random), apex = p + random.standoff_mm() * Eigen::Vector3d::UnitY();
    const Mesh above = transformed(tilted_pyramid(random), shifted_by(apex) * turned_by(upside_down));
    const Eigen::Vector3d n(0, -1, 0);
    expect_contact(placed(above, below, n, random), {apex, p, n}, Taken::from_moving,
                   ContactNormals::least_curvature);
  }
}

// A bar along X whose lowest edge runs through the origin, both faces there at least 20 degrees from level.
Mesh bar_over_its_edge(Random& random)
{
  Mesh bar = test::box({0, 1, 1}, {30, 2, 2});
  return transformed(bar, turned_by(rotation_x(-rad_from_deg(45.0 + random.between(-25.0, 25.0)))) *
                              shifted_by({random.between(-12, 12), 0, 0}));
}

TEST(ClosedForm, EdgeAcrossEdge)
{
  Random random(63);
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const Eigen::Vector3d n(0, -1, 0), below_mm = random.standoff_mm() * n;
    const double crossing_rad = random.between(0.1, pi - 0.1);
    const Mesh above = bar_over_its_edge(random);
    const Mesh below =
        transformed(bar_over_its_edge(random),
                    shifted_by(below_mm) * turned_by(rotation_y(crossing_rad)) * turned_by(upside_down));
    expect_contact(placed(above, below, n, random), {Eigen::Vector3d::Zero(), below_mm, n},
                   Taken::from_reference, ContactNormals::least_curvature);
  }
}

constexpr int n_rings = 12;
constexpr int n_sectors = 24;

// A ball with any of its vertices on top, centred at the origin.
Mesh ball_vertex_up(double radius_mm, Random& random)
{
  const Mesh ball = test::ball(radius_mm, n_rings, n_sectors);
  const Eigen::Vector3d vertex =
      ball.vertices_mm.row(random.below(static_cast<int>(ball.vertices_mm.rows())));
  return transformed(ball, turned_by(rotation_y(random.between(-pi, pi)) *
                                     shortest_rotation(vertex.normalized(), Eigen::Vector3d::UnitY())));
}

TEST(ClosedForm, SphereUnderAPlane)
{
  // d = c . n - r along the plane's normal, here with the ball's vertex on that line.
  Random random(64);
  const Mesh above = test::box({0, 5, 0}, {20, 10, 20});
  const Eigen::Vector3d n(0, -1, 0);
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const double radius_mm = random.between(15.0, 40.0);
    const Eigen::Vector3d p = on_face(random), centre = p + (radius_mm + random.standoff_mm()) * n;
    const Mesh below = transformed(ball_vertex_up(radius_mm, random), shifted_by(centre));
    const Placed scene = placed(above, below, n, random);
    const Expected expected{p, centre - radius_mm * n, n};
    expect_contact(scene, expected, Taken::from_reference, ContactNormals::least_curvature);
    expect_contact(scene, expected, Taken::from_moving, ContactNormals::moving);
  }
}

TEST(ClosedForm, SphereOverAPlane)
{
  Random random(65);
  const Mesh below = test::box({0, -5, 0}, {20, 10, 20});
  const Eigen::Vector3d n(0, -1, 0);
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const double radius_mm = random.between(15.0, 40.0);
    const Eigen::Vector3d p = on_face(random), centre = p - (radius_mm + random.standoff_mm()) * n;
    const Mesh above =
        transformed(ball_vertex_up(radius_mm, random), shifted_by(centre) * turned_by(upside_down));
    const Placed scene = placed(above, below, n, random);
    const Expected expected{centre + radius_mm * n, p, n};
    expect_contact(scene, expected, Taken::from_moving, ContactNormals::least_curvature);
    expect_contact(scene, expected, Taken::from_reference, ContactNormals::reference);
  }
}

TEST(ClosedForm, SphereUnderSphere)
{
  // d = |c - C| - r - R, with a vertex of each ball on the line of centres.
  Random random(66);
  const Eigen::Vector3d n(0, -1, 0);
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const double upper_mm = random.between(15.0, 40.0), lower_mm = random.between(15.0, 40.0);
    const Mesh above = transformed(ball_vertex_up(upper_mm, random), turned_by(upside_down));
    const Eigen::Vector3d centre = (upper_mm + lower_mm + random.standoff_mm()) * n;
    const Mesh below = transformed(ball_vertex_up(lower_mm, random), shifted_by(centre));
    const Placed scene = placed(above, below, n, random);
    const Expected expected{upper_mm * n, centre - lower_mm * n, n};
    expect_contact(scene, expected, Taken::from_reference, ContactNormals::reference);
    expect_contact(scene, expected, Taken::from_moving, ContactNormals::moving);
  }
}

TEST(ClosedForm, NormalsInterpolatedOnASphereAreRadialAnywhere)
{
  Random random(67);
  const double radius_mm = 20.0;
  const Mesh ball = test::ball(radius_mm, n_rings, n_sectors);
  for (int k = 0; k < n_placements; ++k) {
    SCOPED_TRACE(k);
    const auto [a, b, c] = corners(ball, random.below(static_cast<int>(ball.triangles.rows())));
    const double u = random.between(0.05, 0.45), v = random.between(0.05, 0.45);
    const Eigen::Vector3d p = a + u * (b - a) + v * (c - a), outward = (b - a).cross(c - a).normalized();
    const Eigen::Vector3d apex = p + random.standoff_mm() * outward;
    const Mesh tip =
        transformed(tilted_pyramid(random),
                    shifted_by(apex) * turned_by(shortest_rotation(Eigen::Vector3d::UnitY(), -outward)));
    const Eigen::Vector3d radial = p.normalized();
    expect_contact(placed(ball, tip, radial, random), {p, apex, radial}, Taken::from_reference,
                   ContactNormals::reference);
    expect_contact(placed(tip, ball, -radial, random), {apex, p, -radial}, Taken::from_moving,
                   ContactNormals::moving);
  }
}

}  // namespace vrda::contacts_test
