#include "solve/sweep.hpp"

#include <gtest/gtest.h>

#include "core/text.hpp"
#include "support/meshes.hpp"

namespace vrda::joint_test {

TEST(Joint, ThicknessIsThatOfThePlate)
{
  // A plate of 100 x 2 x 100: twice volume over area is 40000 / 20800.
  EXPECT_NEAR(solve::thinnest_part_mm({test::box({0, 0, 0}, {100, 2, 100}), {}}), 40000.0 / 20800.0, 1e-12);
}

TEST(Joint, TheThinnestComponentCounts)
{
  solve::SolverBody body{test::box({0, 0, 0}, {100, 2, 100}), std::vector<std::int32_t>(12, 0)};
  append(body.mesh, test::box({0, 50, 0}, {3, 3, 3}));
  body.component.insert(body.component.end(), 12, 1);
  EXPECT_NEAR(solve::thinnest_part_mm(body), 1.0, 1e-12);
}

TEST(Joint, AnOpenSheetCountsByItsEdges)
{
  const Mesh sheet = test::sheet(10, 5);
  EXPECT_NEAR(solve::thinnest_part_mm({sheet, {}}), mean_edge_length_mm(sheet), 1e-12);
}

TEST(Joint, CompartmentsSplitTheMovingTriangles)
{
  std::vector<Compartment> of_triangle(12, Compartment::medial);
  of_triangle[3] = Compartment::lateral;
  of_triangle[4] = Compartment::none;
  const solve::Joint joint =
      solve::make_joint({test::ball(5), {}}, {test::box({0, 0, 0}, {1, 1, 1}), {}}, of_triangle);
  const auto first_triangle = [&](const geometry::GapTree& compartment) {
    return geometry::GapQuery(joint.reference_gap, compartment).next_contact({{0, -20, 0}, 0}).pair.moving;
  };
  EXPECT_EQ(first_triangle(joint.lateral_gap), 3);
  EXPECT_GE(first_triangle(joint.medial_gap), 0);
  EXPECT_NE(first_triangle(joint.medial_gap), 3);
  EXPECT_NE(first_triangle(joint.medial_gap), 4);
  EXPECT_DOUBLE_EQ(solve::extent_along_delta_mm(joint.moving.tree_mesh.mesh), 1.0);
}

TEST(Joint, BrokenPromisesAreInternalErrors)
{
  EXPECT_THROW(solve::make_joint({Mesh{}, {}}, {test::ball(5), {}}, {}), InternalError);
  EXPECT_THROW(solve::make_joint({test::ball(5), {}}, {test::ball(5), {}}, {Compartment::medial}),
               InternalError);
}

}  // namespace vrda::joint_test
