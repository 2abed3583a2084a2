#include "support/directional_gap.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/units.hpp"
#include "support/meshes.hpp"

namespace vrda::directional_gap_test {

constexpr double rounding_mm = 1e-12;

geometry::Gap gap_of(const geometry::TreeMesh& reference, const geometry::TreeMesh& moving,
                     const MovingPose& pose, geometry::GapKind kind = geometry::GapKind::non_negative,
                     const geometry::TrianglePair& hint = {})
{
  return test::directional_gap(reference, moving.mesh, moving.tree, pose, {kind, hint});
}

double brute_force_mm(const geometry::TreeMesh& reference, const geometry::TreeMesh& moving,
                      const MovingPose& pose, geometry::GapKind kind)
{
  const geometry::Placement place(pose);
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index r = 0; r < reference.mesh.triangles.rows(); ++r) {
    for (Eigen::Index m = 0; m < moving.mesh.triangles.rows(); ++m) {
      least = std::min(
          least, test::pair_travel_mm(corners(reference.mesh, r), place(corners(moving.mesh, m)), kind));
    }
  }
  return least;
}

TEST(DirectionalGap, BoxUnderBoxIsTheHeightBetweenThem)
{
  const geometry::TreeMesh reference = geometry::make_tree_mesh(test::box({0, 10, 0}, {4, 4, 4}));
  const geometry::TreeMesh moving = geometry::make_tree_mesh(test::box({0, 0, 0}, {2, 2, 2}));
  for (const double theta : {0.0, 0.3, -1.2}) {
    EXPECT_NEAR(gap_of(reference, moving, {{0.5, -3.0, 0.2}, theta}).travel_mm, 10.0, rounding_mm);
  }
}

TEST(DirectionalGap, VertexUnderFaceEdgeUnderEdgeAndNothing)
{
  // A ridge along X above a ridge along Z: edge over edge, at 5 - 2.
  Mesh upper, lower;
  upper.vertices_mm.resize(4, 3);
  upper.vertices_mm << -3, 5, 0, 3, 5, 0, 0, 7, 3, 0, 7, -3;
  upper.triangles.resize(2, 3);
  upper.triangles << 0, 1, 2, 1, 0, 3;
  lower.vertices_mm.resize(4, 3);
  lower.vertices_mm << 0, 2, -3, 0, 2, 3, 3, 0, 0, -3, 0, 0;
  lower.triangles.resize(2, 3);
  lower.triangles << 0, 1, 2, 1, 0, 3;
  const geometry::TreeMesh reference = geometry::make_tree_mesh(upper),
                           moving = geometry::make_tree_mesh(lower);
  EXPECT_NEAR(gap_of(reference, moving, {}).travel_mm, 3.0, rounding_mm);
  EXPECT_TRUE(std::isinf(gap_of(reference, moving, {{50, 0, 0}, 0}).travel_mm));
  EXPECT_TRUE(std::isinf(gap_of(reference, moving, {{0, 50, 0}, 0}).travel_mm)) << "nothing above";
}

TEST(DirectionalGap, BallUnderBallMatchesTheClosedFormWithinTheFacets)
{
  // Height between two spheres whose axes are h apart: d - sqrt((r + R)^2 - h^2).
  const double r = 5, R = 8;
  const geometry::TreeMesh reference = geometry::make_tree_mesh(test::ball(R, 128, 256));
  const geometry::TreeMesh moving = geometry::make_tree_mesh(test::ball(r, 128, 256));
  // Inscribed facets add up to the sagitta of an edge on each ball.
  const double facet_mm = (r + R) * 2 * (pi / 128) * (pi / 128) / 8 * 2;
  for (const double h : {0.0, 2.0, 5.0}) {
    const double expected = 30.0 - std::sqrt((r + R) * (r + R) - h * h);
    const double measured = gap_of(reference, moving, {{h, -30.0, 0.0}, 0.2}).travel_mm;
    EXPECT_GE(measured, expected - rounding_mm);
    EXPECT_LE(measured, expected + facet_mm);
  }
}

TEST(DirectionalGap, AgreesWithBruteForceAndWithAnyHint)
{
  const geometry::TreeMesh reference = geometry::make_tree_mesh(test::ball(10, 10, 16));
  const geometry::TreeMesh moving = geometry::make_tree_mesh(test::ball(7, 9, 14));
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  geometry::TrianglePair hint;
  int n_finite = 0, n_infinite = 0;
  for (int k = 0; k < 60; ++k) {
    const MovingPose pose{{18 * unit(random), -8 + 12 * unit(random), 12 * unit(random)}, 3 * unit(random)};
    for (const geometry::GapKind kind : {geometry::GapKind::non_negative, geometry::GapKind::signed_facing}) {
      const geometry::Gap cold = gap_of(reference, moving, pose, kind);
      EXPECT_EQ(cold.travel_mm, brute_force_mm(reference, moving, pose, kind));
      const geometry::Gap warm = gap_of(reference, moving, pose, kind, hint);
      EXPECT_EQ(warm.travel_mm, cold.travel_mm);
      EXPECT_EQ(warm.pair, cold.pair);
      n_finite += std::isfinite(cold.travel_mm) ? 1 : 0;
      n_infinite += std::isfinite(cold.travel_mm) ? 0 : 1;
      hint = cold.pair.reference >= 0 ? cold.pair : hint;
    }
  }
  EXPECT_GT(n_finite, 20);
  EXPECT_GT(n_infinite, 5);
}

TEST(DirectionalGap, GrowsOneForOneAsTheMovingObjectGoesDown)
{
  const geometry::TreeMesh reference = geometry::make_tree_mesh(test::ball(10, 10, 16));
  const geometry::TreeMesh moving = geometry::make_tree_mesh(test::box({0, 0, 0}, {8, 3, 5}));
  const double near = gap_of(reference, moving, {{1, -20, 2}, 0.5}).travel_mm;
  const double far = gap_of(reference, moving, {{1, -23, 2}, 0.5}).travel_mm;
  EXPECT_NEAR(far - near, 3.0, rounding_mm);
}

TEST(DirectionalGap, TurningTheWholeSceneAboutDeltaChangesNothing)
{
  const Mesh upper = test::box({1, 12, 2}, {9, 3, 5});
  const Mesh lower = test::ball(7, 9, 14);
  Pose X = Pose::Identity();
  X.linear() = rotation_y(0.77);
  const MovingPose pose{{3, -9, -1}, 0.2};
  MovingPose turned_pose{X * pose.translation_mm, 0.77 + pose.theta_rad};
  const double plain =
      gap_of(geometry::make_tree_mesh(upper), geometry::make_tree_mesh(lower), pose).travel_mm;
  const double turned =
      gap_of(geometry::make_tree_mesh(transformed(upper, X)), geometry::make_tree_mesh(lower), turned_pose)
          .travel_mm;
  EXPECT_NEAR(plain, turned, rounding_mm);
}

TEST(DirectionalGap, MoreTrianglesNeverGiveMoreRoom)
{
  const geometry::TreeMesh moving = geometry::make_tree_mesh(test::ball(7, 9, 14));
  Mesh upper = test::ball(10, 10, 16);
  const double alone = gap_of(geometry::make_tree_mesh(upper), moving, {{2, -25, 0}, 0}).travel_mm;
  append(upper, test::box({0, -12, 0}, {1, 1, 1}));
  EXPECT_LT(gap_of(geometry::make_tree_mesh(upper), moving, {{2, -25, 0}, 0}).travel_mm, alone);
}

TEST(DirectionalGap, FromAfarIsNegativeByTheDepthOfAnOverlap)
{
  const geometry::TreeMesh reference = geometry::make_tree_mesh(test::box({0, 10, 0}, {4, 4, 4}));
  const geometry::TreeMesh moving = geometry::make_tree_mesh(test::box({0, 0, 0}, {2, 2, 2}));
  // Top of the moving box at 8.5, underside of the reference at 8.
  EXPECT_NEAR(gap_of(reference, moving, {{0, 7.5, 0}, 0}, geometry::GapKind::signed_facing).travel_mm, -0.5,
              rounding_mm);
}

TEST(DirectionalGap, VerticalSheetsMeetByTheirEdges)
{
  Mesh wall;  // vertical triangle, lower edge from (-2, 4, 0) to (2, 4, 0)
  wall.vertices_mm.resize(3, 3);
  wall.vertices_mm << -2, 4, 0, 2, 4, 0, 0, 8, 0;
  wall.triangles.resize(1, 3);
  wall.triangles << 0, 1, 2;
  const geometry::TreeMesh moving = geometry::make_tree_mesh(test::box({0, 0, 0}, {1, 2, 1}));
  EXPECT_NEAR(gap_of(geometry::make_tree_mesh(wall), moving, {}).travel_mm, 3.0, rounding_mm);
}

}  // namespace vrda::directional_gap_test
