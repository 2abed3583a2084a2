// Each rule of gap_query.hpp on a scene with a closed form.
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/gap_query.hpp"
#include "support/meshes.hpp"

namespace vrda::gap_rules_test {

constexpr double rounding_mm = 1e-12;

Mesh triangles(const std::vector<Eigen::RowVector3d>& vertices, const std::vector<Eigen::RowVector3i>& rows)
{
  Mesh mesh;
  mesh.vertices_mm.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v)
    mesh.vertices_mm.row(static_cast<Eigen::Index>(v)) = vertices[v];
  mesh.triangles.resize(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t t = 0; t < rows.size(); ++t) mesh.triangles.row(static_cast<Eigen::Index>(t)) = rows[t];
  return mesh;
}

Mesh flipped(Mesh mesh)
{
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

// Two faces directed down with a common edge along X at y = height: a ridge, or a valley if rise < 0.
Mesh down_fold(double height, double rise)
{
  return triangles({{-4, height, 0}, {4, height, 0}, {0, height + rise, 4}, {0, height + rise, -4}},
                   {{0, 1, 2}, {1, 0, 3}});
}

// Two faces directed up with a common edge along Z at y = 0.
Mesh up_fold(double rise)
{
  return triangles({{0, 0, -4}, {0, 0, 4}, {4, -rise, 0}, {-4, -rise, 0}}, {{0, 1, 2}, {1, 0, 3}});
}

geometry::GapResult answer_of(const Mesh& reference, const Mesh& moving, const MovingPose& pose,
                              double band_mm)
{
  geometry::GapQuery query{geometry::GapTree(reference), geometry::GapTree(moving)};
  return query.features(pose, band_mm);
}

TEST(GapRules, RidgeOverRidgeIsOneCrossingFromEitherSide)
{
  const geometry::GapResult answer = answer_of(down_fold(5, 2), up_fold(2), {}, 0.1);
  ASSERT_EQ(answer.features.size(), 1U) << "found through four pairs of triangles";
  EXPECT_NEAR(answer.travel_mm, 5.0, rounding_mm);
  EXPECT_EQ(answer.pair, (geometry::TrianglePair{0, 0}));
  EXPECT_LT((answer.features[0].point_mm - Eigen::Vector3d::Zero()).norm(), rounding_mm);
  EXPECT_LT((answer.features[0].normal + Eigen::Vector3d::UnitY()).norm(), rounding_mm);
}

TEST(GapRules, ReflexAndFlatEdgesGiveNoCrossing)
{
  // A valley over a ridge: the first contact is at the valley's rim, at its corners over the ridge's faces.
  const geometry::GapResult valley = answer_of(down_fold(5, -1), up_fold(2), {}, 10.0);
  EXPECT_LT(valley.travel_mm, 5.0);
  for (const geometry::GapFeature& feature : valley.features) {
    EXPECT_GT(feature.point_mm.cwiseAbs().maxCoeff(), 0.1) << "the crossing in the middle is never first";
  }
  // Coplanar neighbours: crossings of diagonals inside flat sheets are not features.
  const Mesh above = flipped(test::sheet(4, 4));
  const MovingPose pose{{0.21, -3, 0.13}, 0.2};
  const geometry::GapResult flat = answer_of(above, test::sheet(20, 3), pose, 1e-9);
  EXPECT_EQ(flat.features.size(), 25U) << "the upper sheet's vertices; no convex edge is below its edges";
  for (const geometry::GapFeature& feature : flat.features) EXPECT_NEAR(feature.travel_mm, 3.0, rounding_mm);
}

TEST(GapRules, AVertexOverASharedEdgeGivesEachFaceItsNormalAndACoplanarOneOnce)
{
  // The tip of a pyramid under a ridge, under a flat diagonal, and under a corner of four faces.
  const Mesh tip = triangles({{0, 0, 0}, {1, -2, 0}, {0, -2, 1}, {-1, -2, 0}, {0, -2, -1}},
                             {{0, 2, 1}, {0, 3, 2}, {0, 4, 3}, {0, 1, 4}});
  EXPECT_EQ(answer_of(down_fold(5, 2), tip, {{1.0, 0, 0}, 0}, 1e-9).features.size(), 4U)
      << "both faces, and the two edges of the tip that leave across the ridge";
  const Mesh flat = flipped(test::sheet(4, 2));
  EXPECT_EQ(answer_of(flat, tip, {{0.5, -3, 0.5}, 0}, 1e-9).features.size(), 1U);
  EXPECT_EQ(answer_of(flat, tip, {{0.0, -3, 0.0}, 0}, 1e-9).features.size(), 5U)
      << "a vertex of the sheet right above: four faces below it, and the sheet itself once";
  const Mesh corner = triangles({{0, 5, 0}, {4, 7, 0}, {0, 7, 4}, {-4, 7, 0}, {0, 7, -4}},
                                {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1}});
  const geometry::GapResult tips = answer_of(corner, tip, {}, 1e-9);
  EXPECT_NEAR(tips.travel_mm, 5.0, rounding_mm);
  EXPECT_GE(tips.features.size(), 8U) << "four faces above, four below, and edges that cross at the tips";
}

TEST(GapRules, BackFacesCannotBeMet)
{
  const Mesh up = test::sheet(4, 2), down = flipped(up);
  const MovingPose below{{0, -3, 0}, 0};
  EXPECT_NEAR(answer_of(down, up, below, 0).travel_mm, 3.0, rounding_mm);
  EXPECT_TRUE(std::isinf(answer_of(up, up, below, 0).travel_mm)) << "back face of the reference";
  EXPECT_TRUE(std::isinf(answer_of(down, down, below, 0).travel_mm)) << "back face of the moving object";
}

TEST(GapRules, VerticalFacesTakePartByTheEdgesTheyShare)
{
  // A box's walls are vertical; contact with its lower rim is through the floor's edges.
  const Mesh box = test::box({0, 5, 0}, {2, 4, 2});
  // A roof edge along Z that is beside the rim at x = 1.5; the roof falls to both sides.
  const geometry::GapResult rim = answer_of(box, up_fold(2), {{1.5, 0, 0}, 0}, 1e-9);
  // The roof at x = 1 is 0.5 * 2 / 4 below its ridge; the box's floor is at 3.
  EXPECT_NEAR(rim.travel_mm, 3.25, rounding_mm);
  // A single vertical sheet faces neither way.
  const Mesh wall = triangles({{-2, 4, 0}, {2, 4, 0}, {0, 8, 0}}, {{0, 1, 2}});
  EXPECT_TRUE(std::isinf(answer_of(wall, test::box({0, 0, 0}, {1, 2, 1}), {}, 0).travel_mm));
  // Nor does a face tilted by less than 1e-6; one tilted by more does.
  const auto tilted = [](double tilt) {
    return triangles({{-2, 4, 0}, {2, 4, 0}, {0, 8, 4 * tilt}}, {{0, 1, 2}});
  };
  EXPECT_TRUE(std::isinf(answer_of(tilted(0.9e-6), test::sheet(4, 1), {}, 0).travel_mm));
  EXPECT_NEAR(answer_of(tilted(1.1e-6), test::sheet(4, 1), {}, 0).travel_mm, 4.0, 1e-6);
}

TEST(GapRules, ProjectionsThatOnlyGrazeMeet)
{
  const Mesh box = test::box({0, 5, 0}, {2, 2, 2}), other = test::box({0, 0, 0}, {2, 2, 2});
  // Side by side with a common line, a common corner, and 1e-9 mm apart.
  EXPECT_NEAR(answer_of(box, other, {{2, 0, 0.5}, 0}, 0).travel_mm, 3.0, rounding_mm);
  EXPECT_NEAR(answer_of(box, other, {{2, 0, 2}, 0}, 0).travel_mm, 3.0, rounding_mm);
  EXPECT_TRUE(std::isinf(answer_of(box, other, {{2 + 1e-9, 0, 0}, 0}, 0).travel_mm));
}

TEST(GapRules, NearlyParallelEdgesAreMeasuredAtOnePoint)
{
  // Rising ridges along X and nearly along X with a constant distance of 5 mm.
  for (const double sine : {1e-4, 1e-7, 1e-9, 1e-11, 1e-13, 0.0}) {
    SCOPED_TRACE(sine);
    const Mesh upper = triangles({{-4, 1, 0}, {4, 9, 0}, {0, 7, 4}, {0, 7, -4}}, {{0, 1, 2}, {1, 0, 3}});
    const Mesh lower =
        triangles({{-3, -3, -3 * sine}, {3, 3, 3 * sine}, {0, -3, 3}, {0, -3, -3}}, {{0, 2, 1}, {1, 3, 0}});
    EXPECT_NEAR(answer_of(upper, lower, {}, 0).travel_mm, 5.0, 10 * rounding_mm);
  }
}

}  // namespace vrda::gap_rules_test
