#include <gmock/gmock.h>

#include "geometry/generated_knee.hpp"
#include "geometry/nearest_surface.hpp"
#include "support/meshes.hpp"

namespace vrda::surfaces_test {

using namespace geometry;

// Points on a ring around the origin at several radii, none on an axis.
std::vector<Eigen::Vector3d> probes()
{
  std::vector<Eigen::Vector3d> points;
  for (int i = 1; i <= 40; ++i)
    points.push_back(Eigen::Vector3d(i % 7 - 3.1, i % 5 - 2.2, i % 3 - 1.3).normalized() * (2.0 + i));
  return points;
}

TEST(NearestSurface, DistanceToABallIsItsClosedForm)
{
  const NearestSurface ball(test::ball(20.0, 64, 128));
  const double sagitta_mm = 20.0 * (3.2 / 64) * (3.2 / 64) / 4.0;  // of a facet of pi / 64
  for (const Eigen::Vector3d& p : probes()) {
    const SurfacePoint nearest = ball.nearest(p);
    EXPECT_NEAR(nearest.distance_mm, std::abs(p.norm() - 20.0), sagitta_mm);
    EXPECT_NEAR((nearest.p_mm - p).norm(), nearest.distance_mm, 1e-12);
    EXPECT_GT(ball.normal(nearest.triangle).dot(p.normalized()), 0.99);
  }
}

TEST(NearestSurface, LimitsOfDistanceAndDirectionExcludeTriangles)
{
  const NearestSurface box(test::box({0, 0, 0}, {2, 2, 2}));
  EXPECT_EQ(box.nearest({5, 0, 0}, {3.9}).triangle, -1);
  EXPECT_DOUBLE_EQ(box.nearest({5, 0, 0}, {4.1}).distance_mm, 4.0);
  // Only the opposite face has this direction.
  EXPECT_DOUBLE_EQ(box.nearest({5, 0, 0}, {100.0, 0.9, -Eigen::Vector3d::UnitX()}).distance_mm, 6.0);
  EXPECT_EQ(NearestSurface(Mesh{}).nearest({0, 0, 0}).triangle, -1);
}

TEST(PointTree, NearestEqualsTheSearchOfAllPoints)
{
  const SurfacePoints points = sample_surface(test::ball(20.0), 500);
  const PointTree tree(points);
  int n_limited = 0;
  for (const Eigen::Vector3d& p : probes()) {
    const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, 2) / 3.0;
    double any = 1e9, towards = 1e9;
    for (Eigen::Index i = 0; i < 500; ++i) {
      const double sq = (points.positions_mm.row(i).transpose() - p).squaredNorm();
      any = std::min(any, sq);
      if (points.normals.row(i).dot(normal.transpose()) > 0.3) towards = std::min(towards, sq);
    }
    EXPECT_DOUBLE_EQ(tree.nearest(p, normal, -1.1).distance_sq_mm2, any);
    EXPECT_DOUBLE_EQ(tree.nearest(p, normal, 0.3).distance_sq_mm2, towards);
    n_limited += towards > any ? 1 : 0;
  }
  EXPECT_GT(n_limited, 10);
}

TEST(SampleSurface, PointsLieOnTheSurfaceInEqualShares)
{
  const Mesh box = test::box({0, 0, 0}, {10, 20, 30});
  const SurfacePoints points = sample_surface(box, 2200);
  int n_of_x = 0;
  for (Eigen::Index i = 0; i < 2200; ++i) {
    const Eigen::Vector3d p = points.positions_mm.row(i), n = points.normals.row(i);
    EXPECT_NEAR(n.cwiseAbs().dot(p.cwiseAbs()), n.cwiseAbs().dot(Eigen::Vector3d(5, 10, 15)), 1e-12);
    n_of_x += n.x() != 0.0 ? 1 : 0;
  }
  EXPECT_NEAR(n_of_x, 1200, 2);  // 2 * 600 of 2 * (600 + 300 + 200) mm2
  EXPECT_EQ(sample_surface(Mesh{}, 5).positions_mm.rows(), 0);
}

TEST(SampleSurface, AMirroredMeshGivesTheMirroredPoints)
{
  const Mesh ball = transformed(test::ball(20.0), Pose(Eigen::Translation3d(1, 2, 3)));
  const SurfacePoints points = sample_surface(ball, 100), other = sample_surface(mirrored_z(ball), 100);
  EXPECT_EQ(mirrored_z(points).positions_mm, other.positions_mm);
}

TEST(UnitOfMeshes, IsThatOfAJointsWidthWhateverTheShaft)
{
  const Mesh shaft = test::box({0, 0, 0}, {350, 75, 60}), stump = test::box({0, 0, 0}, {80, 75, 40});
  for (const double unit_mm : {1.0, 10.0, 1000.0}) {
    Mesh femur = shaft, tibia = stump;
    femur.vertices_mm /= unit_mm;
    tibia.vertices_mm /= unit_mm;
    EXPECT_DOUBLE_EQ(unit_mm_of(femur, tibia), unit_mm);
  }
}

TEST(JointRegion, IsBetweenTheBonesAndPointsToTheFemur)
{
  const JointRegion region =
      joint_region(test::box({7, 40, 0}, {50, 70, 60}), test::box({7, -40, 0}, {50, 70, 60}));
  EXPECT_NEAR(region.nearest_mm, 10.0, 1.0);  // the samples are some mm apart
  EXPECT_NEAR(region.centre_mm.y(), 0.0, 1.0);
  EXPECT_NEAR(region.centre_mm.x(), 7.0, 1.0);
  EXPECT_GT(region.up.y(), 0.99);
}

}  // namespace vrda::surfaces_test
