#include <gmock/gmock.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>
#include <set>

#include "core/units.hpp"
#include "geometry/generated_knee.hpp"
#include "geometry/nearest_surface.hpp"
#include "geometry/placement.hpp"
#include "geometry/simplified.hpp"
#include "support/meshes.hpp"

namespace vrda::surfaces_test {

bool holds(const geometry::BoxTree::Node& node, const Eigen::Vector3d& p)
{
  for (std::size_t k = 0; k < 3; ++k) {
    const double value = p[static_cast<Eigen::Index>(k)];
    if (value < node.min_mm[k] || value > node.max_mm[k]) return false;
  }
  return true;
}

// Rows of the triangles below node `n`.
std::vector<std::int32_t> below(const geometry::BoxTree& tree, std::size_t n)
{
  const geometry::BoxTree::Node& node = tree.nodes()[n];
  if (node.is_leaf())
    return {tree.order().begin() + node.first, tree.order().begin() + node.first + node.count};
  std::vector<std::int32_t> rows = below(tree, n + 1);
  const std::vector<std::int32_t> right = below(tree, static_cast<std::size_t>(node.first));
  rows.insert(rows.end(), right.begin(), right.end());
  return rows;
}

TEST(BoxTree, EveryTriangleOccursOnceAndIsInsideItsBoxes)
{
  const Mesh ball = test::ball(10, 9, 14);
  const geometry::BoxTree tree(ball);
  std::vector<std::int32_t> all = below(tree, 0);
  std::sort(all.begin(), all.end());
  std::vector<std::int32_t> expected(static_cast<std::size_t>(ball.triangles.rows()));
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(all, expected);
  for (std::size_t n = 0; n < tree.nodes().size(); ++n) {
    for (const std::int32_t t : below(tree, n)) {
      for (const Eigen::Vector3d& p : corners(ball, t)) EXPECT_TRUE(holds(tree.nodes()[n], p));
    }
  }
}

TEST(BoxTree, RefitEqualsABuildOfTheSameTopology)
{
  const geometry::TreeMesh ball = geometry::make_tree_mesh(test::ball(10, 9, 14));
  const geometry::TreeMesh there = geometry::rotated_reference(ball, {rad_from_deg(40), rad_from_deg(5)});
  for (std::size_t n = 0; n < there.tree.nodes().size(); ++n) {
    for (const std::int32_t t : below(there.tree, n)) {
      for (const Eigen::Vector3d& p : corners(there.mesh, t)) EXPECT_TRUE(holds(there.tree.nodes()[n], p));
    }
  }
}

TEST(BoxTree, ClosePairsMissNoneThatAreClose)
{
  const geometry::TreeMesh reference = geometry::make_tree_mesh(test::ball(10, 9, 14));
  const geometry::TreeMesh moving = geometry::make_tree_mesh(test::ball(7, 8, 12));
  const MovingPose pose{{3.0, -16.0, 1.0}, 0.4};
  const double band_mm = 1.0;
  std::set<geometry::TrianglePair> found;
  geometry::visit_close_pairs(reference.tree, moving.tree, geometry::Placement(pose), band_mm,
                              [&](const geometry::TrianglePair& pair) {
                                found.insert(pair);
                                return false;
                              });
  // Any pair with two corners within the band must be among them.
  const geometry::Placement place(pose);
  int n_close = 0;
  for (std::int32_t r = 0; r < reference.mesh.triangles.rows(); ++r) {
    for (std::int32_t m = 0; m < moving.mesh.triangles.rows(); ++m) {
      const geometry::Corners a = corners(reference.mesh, r), b = place(corners(moving.mesh, m));
      bool close = false;
      for (const Eigen::Vector3d& p : a) {
        for (const Eigen::Vector3d& q : b) close = close || (p - q).norm() <= band_mm;
      }
      if (!close) continue;
      ++n_close;
      EXPECT_TRUE(found.contains({r, m}));
    }
  }
  EXPECT_GT(n_close, 20);
  EXPECT_LT(found.size(),
            static_cast<std::size_t>(reference.mesh.triangles.rows() * moving.mesh.triangles.rows()) / 4);
}

TEST(BoxTree, EmptyTreesHaveNoPairs)
{
  const geometry::BoxTree empty(test::ball(1), {});
  EXPECT_TRUE(empty.is_empty());
  EXPECT_FALSE(geometry::visit_close_pairs(empty, geometry::make_tree_mesh(test::ball(1)).tree,
                                           geometry::Placement({}), 1.0,
                                           [](const geometry::TrianglePair&) { return true; }));
}

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double rounding_mm = 1e-12;  // of coordinates up to 100 mm

/// Brute force over all faces: intersection with the plane, then the side of each edge.
double every_face_mm(const Mesh& mesh, const geometry::Ray& ray)
{
  double shortest_mm = infinity;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d n = face_normal(mesh, t);
    const std::array<Eigen::Vector3d, 3> p = corners(mesh, t);
    if (!(n.dot(ray.direction) < 0.0)) continue;
    const double travel_mm = n.dot(p[0] - ray.from_mm) / n.dot(ray.direction);
    const Eigen::Vector3d place_mm = ray.from_mm + travel_mm * ray.direction;
    bool is_inside = travel_mm >= 0.0 && travel_mm <= ray.max_length_mm;
    for (std::size_t k = 0; k < 3; ++k)
      is_inside = is_inside && n.dot((p[(k + 1) % 3] - p[k]).cross(place_mm - p[k])) >= 0.0;
    if (is_inside) shortest_mm = std::min(shortest_mm, travel_mm);
  }
  return shortest_mm;
}

Eigen::Vector3d random_direction(std::mt19937& random)
{
  std::normal_distribution<double> normal;
  return Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized();
}

TEST(RayTravel, AgreesWithEveryFaceInTurn)
{
  Mesh mesh = test::ball(20.0, 9, 14);
  append(mesh, transformed(test::box({30, 5, -4}, {10, 12, 18}), Pose::Identity()));
  const geometry::BoxTree tree(mesh);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-45.0, 45.0), longest(5.0, 100.0);
  int n_met = 0, n_missed = 0, n_too_far = 0;
  for (int i = 0; i < 10000; ++i) {
    geometry::Ray ray{
        {place(random), place(random), place(random)}, random_direction(random), longest(random)};
    const double expected_mm = every_face_mm(mesh, ray),
                 found_mm = geometry::ray_distance_mm(mesh, tree, ray);
    const bool is_met = expected_mm < infinity;
    EXPECT_EQ(found_mm < infinity, is_met);
    EXPECT_NEAR(is_met ? found_mm : 0.0, is_met ? expected_mm : 0.0, 1e-9);
    n_met += is_met ? 1 : 0;
    ray.max_length_mm = 1000.0;
    const bool is_met_later = every_face_mm(mesh, ray) < infinity;
    n_too_far += !is_met && is_met_later ? 1 : 0;
    n_missed += is_met_later ? 0 : 1;
  }
  EXPECT_GT(n_met, 300);
  EXPECT_GT(n_missed, 300);
  EXPECT_GT(n_too_far, 100);
}

TEST(RayTravel, ASphereInClosedFormFromOutsideAndNothingFromInside)
{
  const Mesh mesh = test::ball(20.0, 64, 128);
  const geometry::BoxTree tree(mesh);
  // Facets are inside the sphere by at most r (1 - cos(half a facet's angle)).
  constexpr double sagitta_mm = 20.0 * 0.5 * 0.05 * 0.05;
  for (const double x_mm : {0.0, 5.0, -12.0}) {
    const double expected_mm = 30.0 - std::sqrt(400.0 - x_mm * x_mm);
    EXPECT_NEAR(geometry::ray_distance_mm(mesh, tree, {{x_mm, -30, 0.3}, {0, 1, 0}, 60}), expected_mm,
                2 * sagitta_mm);
  }
  EXPECT_EQ(geometry::ray_distance_mm(mesh, tree, {{0, 0, 0}, {0, 1, 0}, 60}), infinity);
  EXPECT_EQ(geometry::ray_distance_mm(mesh, tree, {{20.1, -30, 0}, {0, 1, 0}, 60}), infinity);
}

TEST(RayTravel, RaysThroughEdgesAndCornersMeetASheet)
{
  const Mesh mesh = transformed(test::sheet(10.0, 5), Pose(Eigen::Translation3d(0, 3, 0)));
  const geometry::BoxTree tree(mesh);
  int n_met = 0;
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    const Eigen::Vector3d p_mm = mesh.vertices_mm.row(v).transpose();
    const geometry::Ray down{p_mm + Eigen::Vector3d(0, 4, 0), {0, -1, 0}, 10};
    EXPECT_NEAR(geometry::ray_distance_mm(mesh, tree, down), 4.0, rounding_mm);
    ++n_met;
    // Back faces are not hit.
    EXPECT_EQ(geometry::ray_distance_mm(mesh, tree, {p_mm - Eigen::Vector3d(0, 4, 0), {0, 1, 0}, 10}),
              infinity);
  }
  EXPECT_EQ(n_met, 36);
}

TEST(RayTravel, NothingInTheWayOfAnEmptyMesh)
{
  EXPECT_EQ(geometry::ray_distance_mm({}, {}, {{0, 0, 0}, {0, 1, 0}, 10}), infinity);
}

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

// A ball far from the origin, where single precision has steps of 0.06 mm, and a flat sheet.
TEST(Simplified, StaysWithinItsDistance)
{
  constexpr double radius_mm = 60.0, within_mm = 0.05;
  Mesh ball = test::ball(radius_mm, 150, 300);
  const Eigen::RowVector3d centre_mm(1e6, 0.0, -1e6);
  ball.vertices_mm.rowwise() += centre_mm;
  const std::optional<SimplifiedMesh> fewer = simplified(ball, 10'000, within_mm);
  ASSERT_TRUE(fewer);
  EXPECT_LT(fewer->mesh.triangles.rows(), 0.5 * static_cast<double>(ball.triangles.rows()));
  EXPECT_LE(fewer->largest_mm, within_mm);
  EXPECT_EQ(edge_counts(fewer->mesh).boundary, 0);
  const Eigen::VectorXd off_mm = (fewer->mesh.vertices_mm.rowwise() - centre_mm).rowwise().norm();
  EXPECT_NEAR(off_mm.minCoeff(), radius_mm, 1e-6);  // vertices are those of the ball
  double deepest_mm = 0.0;
  for (Eigen::Index t = 0; t < fewer->mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(fewer->mesh, t);
    deepest_mm = std::max(deepest_mm, radius_mm - ((a + b + c) / 3.0 - centre_mm.transpose()).norm());
  }
  EXPECT_LT(deepest_mm, 2.0 * within_mm);  // with the sagitta of the ball's own triangles

  const Mesh sheet = test::sheet(80.0, 100);
  const std::optional<SimplifiedMesh> flat = simplified(sheet, 5'000, within_mm);
  ASSERT_TRUE(flat);
  EXPECT_NEAR(area_mm2(flat->mesh), area_mm2(sheet), 1e-6);  // its border stays
  EXPECT_FALSE(simplified(sheet, sheet.triangles.rows(), within_mm));
}

}  // namespace vrda::surfaces_test
