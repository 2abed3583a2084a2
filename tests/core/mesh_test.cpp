#include "core/mesh.hpp"

#include <gtest/gtest.h>

#include "core/trig.hpp"
#include "core/units.hpp"
#include "support/meshes.hpp"

namespace vrda::mesh_test {

TEST(Mesh, BoxHasItsClosedFormMeasures)
{
  const Mesh box = test::box({100, -50, 3}, {2, 4, 6});
  EXPECT_NEAR(signed_volume_mm3(box), 48.0, 1e-12);
  EXPECT_NEAR(area_mm2(box), 2 * (8 + 12 + 24), 1e-12);
  EXPECT_EQ(edge_counts(box).boundary, 0);
  EXPECT_EQ(edge_counts(box).non_manifold, 0);
  EXPECT_EQ(bounding_box(box).min_mm, Eigen::Vector3d(99, -52, 0));
  EXPECT_EQ(bounding_box(box).max_mm, Eigen::Vector3d(101, -48, 6));
}

TEST(Mesh, BallIsClosedAndItsNormalsPointOutward)
{
  const Mesh ball = test::ball(10, 64, 128);
  EXPECT_EQ(edge_counts(ball).boundary, 0);
  EXPECT_EQ(edge_counts(ball).non_manifold, 0);
  // Inscribed polyhedron: relative volume error below (pi / 64)^2.
  EXPECT_NEAR(signed_volume_mm3(ball) / (4.0 / 3.0 * pi * 1000), 1.0, 2.5e-3);
  const Points computed = vertex_normals(ball);
  for (Eigen::Index v = 0; v < computed.rows(); ++v) {
    EXPECT_GT(computed.row(v).dot(ball.normals.row(v)), 0.999);
  }
}

TEST(Mesh, SheetCountsItsBoundaryAndAFlippedFaceItsEdges)
{
  Mesh sheet = test::sheet(10, 4);
  EXPECT_EQ(edge_counts(sheet).boundary, 16);
  EXPECT_EQ(edge_counts(sheet).non_manifold, 0);
  std::swap(sheet.triangles(10, 0), sheet.triangles(10, 1));
  EXPECT_GT(edge_counts(sheet).non_manifold, 0);
}

TEST(Mesh, MirroringKeepsTheVolumeAndIsAnInvolutionToTheLastBit)
{
  const Mesh ball = test::ball(7.3, 8, 12);
  const Mesh mirrored = mirrored_z(ball);
  EXPECT_NEAR(signed_volume_mm3(mirrored), signed_volume_mm3(ball), 1e-10);
  const Mesh twice = mirrored_z(mirrored);
  EXPECT_EQ(twice.vertices_mm, ball.vertices_mm);
  EXPECT_EQ(twice.triangles, ball.triangles);
}

TEST(Mesh, AppendShiftsTheIndices)
{
  Mesh two = test::box({0, 0, 0}, {1, 1, 1});
  append(two, test::box({5, 0, 0}, {2, 2, 2}));
  EXPECT_EQ(two.triangles.rows(), 24);
  EXPECT_NEAR(signed_volume_mm3(two), 9.0, 1e-12);
  EXPECT_EQ(two.normals.rows(), two.vertices_mm.rows());
}

}  // namespace vrda::mesh_test
