#include "view/scene.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

#include "core/units.hpp"

namespace vrda::view::solids_test {

constexpr double single_rounding_mm = 1e-4;  // single precision at 100 mm, summed

Eigen::Vector3d position(const RenderVertex& vertex)
{
  return {vertex.position_mm[0], vertex.position_mm[1], vertex.position_mm[2]};
}
Eigen::Vector3d normal(const RenderVertex& vertex)
{
  return {vertex.normal[0], vertex.normal[1], vertex.normal[2]};
}

double volume_mm3(const RenderMesh& mesh)
{
  double volume = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const Eigen::Vector3d a = position(mesh.vertices[mesh.triangles[t]]),
                          b = position(mesh.vertices[mesh.triangles[t + 1]]),
                          c = position(mesh.vertices[mesh.triangles[t + 2]]);
    volume += a.dot(b.cross(c)) / 6.0;
  }
  return volume;
}

/// Checks that normals are unit vectors on the outer side of their faces.
void expect_sound(const RenderMesh& mesh)
{
  for (const RenderVertex& vertex : mesh.vertices) EXPECT_NEAR(normal(vertex).norm(), 1.0, 1e-3);
  int n_faces = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const Eigen::Vector3d a = position(mesh.vertices[mesh.triangles[t]]),
                          b = position(mesh.vertices[mesh.triangles[t + 1]]),
                          c = position(mesh.vertices[mesh.triangles[t + 2]]);
    const Eigen::Vector3d face = (b - a).cross(c - a);
    const bool is_face = face.norm() > 1e-6;  // degenerate triangles have no area
    n_faces += is_face ? 1 : 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double agreement = face.dot(normal(mesh.vertices[mesh.triangles[t + k]]));
      EXPECT_TRUE(!is_face || agreement > -1e-6 * face.norm());
    }
  }
  EXPECT_GT(n_faces, 40);
}

double polygon_part()  // area of the regular 12-gon / area of its circle
{
  return 12.0 * 0.5 * 0.5 / pi;
}

TEST(Solids, Ball)
{
  RenderMesh mesh;
  add_balls(mesh, 1);
  EXPECT_EQ(mesh.vertices.size(), ball_size().n_vertices);
  EXPECT_EQ(mesh.triangles.size(), ball_size().n_indices);
  const Eigen::Vector3d centre(40, -30, 7);
  set_ball(mesh, 0, centre, 5.0);
  for (const RenderVertex& vertex : mesh.vertices) {
    EXPECT_NEAR((position(vertex) - centre).norm(), 5.0, single_rounding_mm);
    EXPECT_LT((position(vertex) - centre - 5.0 * normal(vertex)).norm(), single_rounding_mm);
  }
  expect_sound(mesh);
  EXPECT_GT(volume_mm3(mesh), 0.88 * 4.0 / 3.0 * pi * 125.0);
  EXPECT_LT(volume_mm3(mesh), 4.0 / 3.0 * pi * 125.0);
}

TEST(Solids, RodAndTube)
{
  const Eigen::Vector3d from(3, 4, 5), to(-20, 30, 11);
  const double expected_mm3 = polygon_part() * pi * 4.0 * (to - from).norm();
  RenderMesh rod;
  add_rods(rod, 1);
  set_rod(rod, 0, from, to, 2.0);
  expect_sound(rod);
  EXPECT_NEAR(volume_mm3(rod), expected_mm3, 1e-4 * expected_mm3);
  RenderMesh tube;
  const std::array<Eigen::Vector3d, 4> way{from, 0.7 * from + 0.3 * to, 0.7 * from + 0.3 * to, to};
  add_tube(tube, way.size());
  EXPECT_EQ(tube.vertices.size(), tube_size(4).n_vertices);
  EXPECT_EQ(tube.triangles.size(), tube_size(4).n_indices);
  set_tube(tube, 0, way, 2.0);
  expect_sound(tube);
  EXPECT_NEAR(volume_mm3(tube), expected_mm3, 1e-4 * expected_mm3);
}

TEST(Solids, Band)
{
  // A twisted band along Y: its width turns from X to Z.
  std::array<Eigen::Vector3d, 5> way;
  for (std::size_t k = 0; k < way.size(); ++k) way[k] = {0.0, 10.0 * static_cast<double>(k), 0.0};
  RenderMesh mesh;
  add_tube(mesh, way.size());
  set_band(mesh, 0, way, {3.0, 0.5, {2.0, 1.0, 0.0}, {0.0, 1.0, 2.0}});
  expect_sound(mesh);
  for (std::size_t k = 0; k < way.size(); ++k) {
    SCOPED_TRACE(k);
    const double part = static_cast<double>(k) / 4.0;
    const Eigen::Vector3d wide = Eigen::Vector3d(1.0 - part, 0.0, part).normalized();
    const Eigen::Vector3d thin = Eigen::Vector3d(-part, 0.0, 1.0 - part).normalized();
    double width_mm = 0.0, thickness_mm = 0.0;
    for (std::size_t side = 0; side < 12; ++side) {
      const RenderVertex& vertex = mesh.vertices[12 * (k + 1) + side];
      const Eigen::Vector3d from_axis = position(vertex) - way[k];
      EXPECT_NEAR(from_axis.y(), 0.0, single_rounding_mm);
      // The normal of the ellipse (x / 3)^2 + (z / 0.5)^2 = 1.
      const double x = from_axis.dot(wide), z = from_axis.dot(thin);
      EXPECT_NEAR(x * x / 9.0 + z * z / 0.25, 1.0, single_rounding_mm);
      const Eigen::Vector3d gradient = (x / 9.0 * wide + z / 0.25 * thin).normalized();
      EXPECT_NEAR(gradient.dot(normal(vertex)), 1.0, single_rounding_mm);
      width_mm = std::max(width_mm, x);
      thickness_mm = std::max(thickness_mm, z);
    }
    EXPECT_NEAR(width_mm, 3.0, single_rounding_mm);
    EXPECT_NEAR(thickness_mm, 0.5, single_rounding_mm);
  }
}

TEST(Solids, Arrow)
{
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-50.0, 50.0);
  int n_short = 0, n_long = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::Vector3d from(place(random), place(random), place(random));
    const Eigen::Vector3d along = Eigen::Vector3d(place(random), place(random), place(random)).normalized();
    const double length_mm = i % 2 == 0 ? 1.0 : 25.0;
    n_short += i % 2 == 0 ? 1 : 0;
    n_long += i % 2 == 0 ? 0 : 1;
    RenderMesh mesh;
    add_arrows(mesh, 1);
    set_arrow(mesh, 0, from, from + length_mm * along, 0.6);
    expect_sound(mesh);
    double low = 1e9, high = -1e9;
    for (const RenderVertex& vertex : mesh.vertices) {
      low = std::min(low, (position(vertex) - from).dot(along));
      high = std::max(high, (position(vertex) - from).dot(along));
    }
    EXPECT_NEAR(low, 0.0, single_rounding_mm);
    EXPECT_NEAR(high, length_mm, single_rounding_mm);
  }
  EXPECT_EQ(n_short, 100);
  EXPECT_EQ(n_long, 100);
}

}  // namespace vrda::view::solids_test
