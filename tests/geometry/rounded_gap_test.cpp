// Gaps of meshes rounded by an offset: closed forms, every pair of triangles, and the distance at contact.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "geometry/gap_query.hpp"
#include "geometry/gap_scenes.hpp"
#include "geometry/instruction_set.hpp"
#include "support/directional_gap.hpp"
#include "support/meshes.hpp"

namespace vrda::rounded_gap_test {

using test::GapBodies;
using test::GapRandom;

// The accuracy that is promised.
constexpr double closed_form_mm = 1e-9;
// Heights of some 30 mm, each a root or a sum of a few products; a sliver's slope may amplify errors.
constexpr double rounding_mm = 1e-9;

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

// Least travel over every pair of facing triangles.
double every_pair_mm(const GapBodies& bodies, const Attitude& attitude, const MovingPose& pose)
{
  const geometry::TreeMesh turned = rotated_reference(geometry::make_tree_mesh(bodies.reference), attitude);
  const geometry::Placement place(pose);
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index r = 0; r < turned.mesh.triangles.rows(); ++r) {
    for (Eigen::Index m = 0; m < bodies.moving.triangles.rows(); ++m) {
      const double offset = offset_mm(bodies.reference, r) + offset_mm(bodies.moving, m);
      least = std::min(least, test::pair_travel_mm(corners(turned.mesh, r), place(corners(bodies.moving, m)),
                                                   geometry::GapKind::signed_facing, offset));
    }
  }
  return least;
}

TEST(RoundedGap, EveryTraversalAgreesWithEveryPairOfTriangles)
{
  GapRandom random(7);
  int n_finite = 0, n_moved = 0;
  for (GapBodies bodies : test::gap_bodies(random)) {
    const double bare_scale = std::abs(bodies.depth_mm);
    const Mesh bare = bodies.reference;
    bodies.reference = with_offset(bodies.reference, 1.0);
    // Different offsets within one object, as of two components.
    bodies.moving = with_offset(bodies.moving, 0.0);
    for (std::size_t t = 0; t < bodies.moving.offset_mm.size(); t += 2) bodies.moving.offset_mm[t] = 0.6;
    for (int k = 0; k < 6; ++k) {
      const Attitude attitude = random.attitude();
      const MovingPose pose = random.pose(15, bodies.depth_mm);
      const double expected = every_pair_mm(bodies, attitude, pose);
      const double bare_mm = every_pair_mm({bare, bodies.moving, bodies.depth_mm}, attitude, pose);
      for (const geometry::InstructionSet set : geometry::instruction_sets()) {
        geometry::set_instruction_set(set);
        geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
        query.set_attitude(attitude);
        const double found = query.travel_mm(pose);
        EXPECT_EQ(std::isfinite(found), std::isfinite(expected));
        EXPECT_NEAR(std::isfinite(found) ? found : 0.0, std::isfinite(expected) ? expected : 0.0,
                    rounding_mm * bare_scale);
        EXPECT_EQ(test::bits_of(query.features(pose, 0.1)), test::bits_of(query.features(pose, 0.1)));
      }
      geometry::set_instruction_set(geometry::instruction_sets().back());
      const Travels all = travels(bodies.reference, bodies.moving, pose, attitude);
      EXPECT_EQ(all.next_mm, all.tree_mm);
      n_finite += std::isfinite(expected) ? 1 : 0;
      n_moved += expected < bare_mm - 0.5 ? 1 : 0;
    }
  }
  EXPECT_GT(n_finite, 20);
  EXPECT_GT(n_moved, 15);
}

// The pairs of earlier answers are tried first and bound the search: they must not decide it.
TEST(RoundedGap, AnswersDoNotDependOnEarlierQueries)
{
  GapRandom random(3);
  int n_finite = 0;
  for (GapBodies bodies : test::gap_bodies(random)) {
    bodies.reference = with_offset(bodies.reference, 1.0);
    bodies.moving = with_offset(bodies.moving, 0.4);
    const geometry::GapTree reference(bodies.reference), moving(bodies.moving);
    geometry::GapQuery used{reference, moving};
    for (int k = 0; k < 12; ++k) {
      const Attitude attitude = random.attitude();
      used.set_attitude(attitude);
      const MovingPose about = random.pose(15, bodies.depth_mm);
      for (int i = 0; i < 30; ++i) {
        MovingPose pose = about;
        pose.translation_mm += 0.3 * Eigen::Vector3d(random.unit(), random.unit(), random.unit());
        geometry::GapQuery fresh{reference, moving};
        fresh.set_attitude(attitude);
        ASSERT_EQ(test::bits_of(used.features(pose, 0.05)), test::bits_of(fresh.features(pose, 0.05)));
        const geometry::Gap after = used.next_contact(pose), first = fresh.next_contact(pose);
        ASSERT_EQ(after.travel_mm, first.travel_mm);
        ASSERT_EQ(after.pair, first.pair);
        n_finite += std::isfinite(first.travel_mm) ? 1 : 0;
      }
    }
  }
  EXPECT_GT(n_finite, 200);
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

}  // namespace vrda::rounded_gap_test
