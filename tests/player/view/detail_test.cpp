#include "view/gl_mesh.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "player/view/pictures.hpp"
#include "support/meshes.hpp"

namespace vrda::view::detail_test {

RenderMesh mesh_of(const Mesh& mesh)
{
  Scene scene;
  test::add(scene, mesh, test::plain({1, 1, 1}));
  return scene.drawables[0].mesh;
}

Eigen::Vector3d corner_mm(const RenderMesh& mesh, std::uint32_t vertex)
{
  return Eigen::Map<const Eigen::Vector3f>(mesh.vertices[vertex].position_mm.data()).cast<double>();
}

/// Largest depth of triangle centroids inside a ball of `radius_mm`.
double sagitta_mm(const RenderMesh& mesh, const std::vector<std::uint32_t>& triangles, double radius_mm)
{
  double most_mm = 0.0;
  for (std::size_t i = 0; i < triangles.size(); i += 3) {
    const Eigen::Vector3d middle_mm = (corner_mm(mesh, triangles[i]) + corner_mm(mesh, triangles[i + 1]) +
                                       corner_mm(mesh, triangles[i + 2])) /
                                      3.0;
    most_mm = std::max(most_mm, radius_mm - middle_mm.norm());
  }
  return most_mm;
}

TEST(Detail, LevelsOfABall)
{
  constexpr double radius_mm = 20.0;
  const RenderMesh mesh = mesh_of(test::ball(radius_mm, 96, 192));
  const std::vector<DetailLevel> levels = levels_of(mesh);
  ASSERT_GE(levels.size(), 4U);
  EXPECT_EQ(levels[0].triangles.size(), mesh.triangles.size());
  EXPECT_EQ(levels[0].error_mm, 0.0);
  const double whole_mm = sagitta_mm(mesh, mesh.triangles, radius_mm);
  for (std::size_t i = 1; i < levels.size(); ++i) {
    SCOPED_TRACE(i);
    EXPECT_LT(levels[i].triangles.size(), 0.8 * static_cast<double>(levels[i - 1].triangles.size()));
    EXPECT_GT(levels[i].error_mm, levels[i - 1].error_mm);
    // meshoptimizer's error is a mean over the planes around a vertex: the largest distance is up to about
    // twice that.
    EXPECT_LE(sagitta_mm(mesh, levels[i].triangles, radius_mm), whole_mm + 2.0 * levels[i].error_mm);
    for (const std::uint32_t vertex : levels[i].triangles) ASSERT_LT(vertex, mesh.vertices.size());
  }
  EXPECT_LT(levels.back().triangles.size(), mesh.triangles.size() / 10);
}

TEST(Closed, BoxBallSheet)
{
  EXPECT_TRUE(is_closed(
      mesh_of(test::box({0, 0, 0}, {1, 2, 3}))));  // vertices are split along every edge by the creases
  EXPECT_TRUE(is_closed(mesh_of(test::ball(20))));
  EXPECT_FALSE(is_closed(mesh_of(test::sheet(20, 3))));
  EXPECT_FALSE(is_closed({}));
}

TEST(Closed, HoleOrInsideOut)
{
  RenderMesh mesh = mesh_of(test::ball(20));
  RenderMesh inside_out = mesh;
  for (std::size_t i = 0; i < mesh.triangles.size(); i += 3)
    std::swap(inside_out.triangles[i], inside_out.triangles[i + 1]);
  EXPECT_FALSE(is_closed(inside_out));
  mesh.triangles.resize(mesh.triangles.size() - 3);
  EXPECT_FALSE(is_closed(mesh));
}

}  // namespace vrda::view::detail_test
