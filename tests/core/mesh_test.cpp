#include "model/mesh.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "core/units.hpp"
#include "support/meshes.hpp"

namespace vrda::mesh_test {

TEST(Mesh, box)
{
  const Mesh box = test::box({100, -50, 3}, {2, 4, 6});
  EXPECT_NEAR(signed_volume_mm3(box), 48.0, 1e-12);
  EXPECT_NEAR(area_mm2(box), 2 * (8 + 12 + 24), 1e-12);
  EXPECT_EQ(edge_counts(box).boundary, 0);
  EXPECT_EQ(edge_counts(box).non_manifold, 0);
  EXPECT_EQ(bounding_box(box).min_mm, Eigen::Vector3d(99, -52, 0));
  EXPECT_EQ(bounding_box(box).max_mm, Eigen::Vector3d(101, -48, 6));
}

TEST(Mesh, ball)
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

TEST(Mesh, sheet)
{
  Mesh sheet = test::sheet(10, 4);
  EXPECT_EQ(edge_counts(sheet).boundary, 16);
  EXPECT_EQ(edge_counts(sheet).non_manifold, 0);
  std::swap(sheet.triangles(10, 0), sheet.triangles(10, 1));
  EXPECT_GT(edge_counts(sheet).non_manifold, 0);
}

TEST(Mesh, mirrored)
{
  const Mesh ball = test::ball(7.3, 8, 12);
  const Mesh mirrored = mirrored_z(ball);
  EXPECT_NEAR(signed_volume_mm3(mirrored), signed_volume_mm3(ball), 1e-10);
  const Mesh twice = mirrored_z(mirrored);
  EXPECT_EQ(twice.vertices_mm, ball.vertices_mm);
  EXPECT_EQ(twice.triangles, ball.triangles);
}

TEST(Mesh, appended)
{
  Mesh two = test::box({0, 0, 0}, {1, 1, 1});
  append(two, test::box({5, 0, 0}, {2, 2, 2}));
  EXPECT_EQ(two.triangles.rows(), 24);
  EXPECT_NEAR(signed_volume_mm3(two), 9.0, 1e-12);
  EXPECT_EQ(two.normals.rows(), two.vertices_mm.rows());
}

constexpr double single_rounding = 1e-6;  // of a unit vector in single precision

std::vector<Eigen::Index> every_triangle(const Mesh& mesh)
{
  std::vector<Eigen::Index> all(static_cast<std::size_t>(mesh.triangles.rows()));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

Eigen::Vector3d as_vector(const std::array<float, 3>& v)
{
  return {v[0], v[1], v[2]};
}

TEST(DrawMesh, cube)
{
  const Mesh cube = test::box({0, 0, 0}, {2, 2, 2});
  const RenderMesh sharp = make_render_mesh(cube, every_triangle(cube), {0, 0, 0}, rad_from_deg(89));
  EXPECT_EQ(sharp.vertices.size(), 24U);  // three faces at each corner
  for (const RenderVertex& vertex : sharp.vertices) {
    const Eigen::Vector3d n = as_vector(vertex.normal);
    EXPECT_NEAR(n.cwiseAbs().maxCoeff(), 1.0, single_rounding);
    EXPECT_NEAR(n.dot(as_vector(vertex.position_mm)), 1.0, single_rounding);  // outward
  }
  const RenderMesh round = make_render_mesh(cube, every_triangle(cube), {0, 0, 0}, rad_from_deg(91));
  EXPECT_EQ(round.vertices.size(), 8U);
  for (const RenderVertex& vertex : round.vertices)
    EXPECT_GT(as_vector(vertex.normal).cwiseAbs().minCoeff(), 0.2);
}

TEST(DrawMesh, ball)
{
  const Mesh ball = test::ball(20, 32, 64);
  const RenderMesh drawn = make_render_mesh(ball, every_triangle(ball), {0, 0, 0});
  EXPECT_EQ(drawn.vertices.size(), static_cast<std::size_t>(ball.vertices_mm.rows()));
  EXPECT_EQ(drawn.triangles.size(), static_cast<std::size_t>(3 * ball.triangles.rows()));
  // A quarter of the angle between neighbouring rings: faces around a vertex deviate by half of it to either
  // side.
  constexpr double tolerance_rad = pi / 32 / 4;
  for (const RenderVertex& vertex : drawn.vertices) {
    EXPECT_LT((as_vector(vertex.normal) - as_vector(vertex.position_mm) / 20.0).norm(), tolerance_rad);
  }
}

TEST(DrawMesh, listed_triangles)
{
  Mesh cube = test::box({0, 0, 0}, {2, 2, 2});
  cube.triangles.row(1) << 3, 3, 4;
  const RenderMesh drawn = make_render_mesh(cube, {0, 1, 5}, {0, 0, 0});
  EXPECT_EQ(drawn.triangles.size(), 6U);
  EXPECT_LE(drawn.vertices.size(), 6U);
}

TEST(DrawMesh, far_from_origin)
{
  // At 600 mm single precision resolves 0.00006 mm; relative to the origin it is exact here.
  const Mesh cube = test::box({600, -300, 75}, {0.25, 0.25, 0.25});
  const RenderMesh drawn = make_render_mesh(cube, every_triangle(cube), {600, -300, 75});
  for (const RenderVertex& vertex : drawn.vertices) {
    for (const float x_mm : vertex.position_mm) EXPECT_EQ(std::abs(x_mm), 0.125F);
  }
}

}  // namespace vrda::mesh_test
