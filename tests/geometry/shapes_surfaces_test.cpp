#include <gtest/gtest.h>

#include <cmath>

#include "core/text.hpp"
#include "geometry/level_set.hpp"

namespace vrda::surfaces_test {

void expect_closed_and_outward(const Mesh& mesh)
{
  EXPECT_EQ(edge_counts(mesh).boundary, 0);
  EXPECT_EQ(edge_counts(mesh).non_manifold, 0);
  EXPECT_GT(signed_volume_mm3(mesh), 0.0);
}

TEST(LevelSet, BallIsExactAtItsVertices)
{
  const geometry::Field ball = [](const Eigen::Vector3d& p) { return p.norm() - 10.0; };
  for (const double cell_mm : {4.0, 2.0, 0.7}) {
    geometry::LevelSetOptions options;
    options.cell_mm = cell_mm;
    const Mesh mesh = geometry::level_set_mesh(ball, {{-11, -11, -11}, {11, 11, 11}}, options);
    expect_closed_and_outward(mesh);
    EXPECT_LT((mesh.vertices_mm.rowwise().norm().array() - 10.0).abs().maxCoeff(),
              1e-9);  // Newton's last step
    // Central differences over 1e-3 mm: error h^2 / (6 r^2) and rounding 1e-12.
    EXPECT_LT((mesh.normals - mesh.vertices_mm / 10.0).rowwise().norm().maxCoeff(), 1e-7);
    EXPECT_NEAR(mean_edge_length_mm(mesh) / cell_mm, 1.0, 0.25);
  }
}

TEST(LevelSet, ASurfaceThatLeavesItsBoxIsABrokenPromise)
{
  const geometry::Field ball = [](const Eigen::Vector3d& p) { return p.norm() - 20.0; };
  EXPECT_THROW(geometry::level_set_mesh(ball, {{-11, -11, -30}, {11, 11, 30}}, {}), InternalError);
}

TEST(LevelSet, SkippedEmptySpaceChangesNothing)
{
  const geometry::Field ball = [](const Eigen::Vector3d& p) { return p.norm() - 10.0; };
  geometry::LevelSetOptions skipping, careful;
  skipping.cell_mm = careful.cell_mm = 0.9;
  skipping.max_gradient = 1.0;
  careful.max_gradient = 1e9;
  const Box box{{-12, -12, -12}, {12, 12, 12}};
  EXPECT_EQ(geometry::level_set_mesh(ball, box, skipping).vertices_mm,
            geometry::level_set_mesh(ball, box, careful).vertices_mm);
}

TEST(LevelSet, ASurfaceAlongAnotherHasItsVerticesWhereBothAgree)
{
  // Two halves of one rod that overlap from y = -9 to 9; their ends are rounded over 2 mm.
  const auto rod = [](const Eigen::Vector3d& p) { return std::sqrt(p.x() * p.x() + p.z() * p.z()) - 8.0; };
  const auto half = [&](double low_mm, double high_mm) {
    const geometry::Field field = [=](const Eigen::Vector3d& p) {
      return geometry::smooth_max(geometry::smooth_max(rod(p), p.y() - high_mm, 2.0), low_mm - p.y(), 2.0);
    };
    return geometry::LevelSet{field, {{-10.3, low_mm - 2.1, -11}, {10, high_mm + 2.4, 11}}};
  };
  const geometry::LevelSet lower = half(-30.0, 9.0), upper = half(-9.0, 30.0);
  geometry::LevelSetOptions options;
  options.cell_mm = 1.7;
  const auto [first, second] = geometry::adjoining_level_set_meshes(lower, upper, options);
  EXPECT_EQ(first.vertices_mm, geometry::level_set_mesh(lower.field, lower.box_mm, options).vertices_mm);
  expect_closed_and_outward(second);
  EXPECT_GT(bounding_box(second).max_mm.y(), 29.0);
  int n_shared = 0, n_within = 0;
  for (Eigen::Index v = 0; v < second.vertices_mm.rows(); ++v) {
    constexpr double safely_shared_mm = 4.0;  // more than the ends' rounding and a cell
    const bool is_within = std::abs(second.vertices_mm(v, 1)) < safely_shared_mm &&
                           std::abs(rod(second.vertices_mm.row(v))) < 1e-6;
    const double nearest =
        (first.vertices_mm.rowwise() - second.vertices_mm.row(v)).rowwise().norm().minCoeff();
    n_within += is_within ? 1 : 0;
    n_shared += is_within && nearest == 0.0 ? 1 : 0;
  }
  EXPECT_GT(n_within, 100);
  EXPECT_EQ(n_shared, n_within);
}

TEST(Surface, EllipsoidHasTwentySquaresOfTrianglesOnTheSurface)
{
  for (const int n_edges : {1, 2, 7}) {
    const Mesh mesh = geometry::ellipsoid_mesh({3, 5, 4}, n_edges);
    expect_closed_and_outward(mesh);
    EXPECT_EQ(mesh.triangles.rows(), 20 * n_edges * n_edges);
    EXPECT_DOUBLE_EQ(bounding_box(mesh).max_mm.y(), 5.0);
    for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
      const Eigen::Vector3d p = mesh.vertices_mm.row(v);
      EXPECT_NEAR(p.cwiseQuotient(Eigen::Vector3d(3, 5, 4)).norm(), 1.0, 1e-14);
    }
  }
}

TEST(Surface, BlocksFacingEitherWayAreClosedAndHaveTheirVolume)
{
  for (const double back_y_mm : {-2.0, 3.0}) {
    geometry::ShapedBlock block;
    geometry::append_lines(block.x_mm, -2.0, 2.0, 4);
    geometry::append_lines(block.z_mm, -1.0, 2.0, 3);
    block.front_y_mm = [](double, double) { return 1.0; };
    block.back_y_mm = back_y_mm;
    expect_closed_and_outward(geometry::block_mesh(block));
    EXPECT_NEAR(signed_volume_mm3(geometry::block_mesh(block)), 12.0 * std::abs(back_y_mm - 1.0), 1e-12);
  }
}

TEST(Surface, AHoleGoesThroughTheBlock)
{
  geometry::ShapedBlock block;
  geometry::append_lines(block.x_mm, -4.0, 4.0, 8);
  block.z_mm = block.x_mm;
  block.front_y_mm = [](double, double) { return 0.0; };
  block.back_y_mm = 1.0;
  block.hole_half_mm = 2.0;
  expect_closed_and_outward(geometry::block_mesh(block));
  EXPECT_NEAR(signed_volume_mm3(geometry::block_mesh(block)), 64.0 - 16.0, 1e-12);
}

}  // namespace vrda::surfaces_test
