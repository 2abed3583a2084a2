#include <gtest/gtest.h>

#include <map>
#include <random>

#include "core/text.hpp"
#include "solve/contact_constraint.hpp"
#include "solve/pins.hpp"
#include "solve/potential.hpp"
#include "solve/sweep.hpp"
#include "support/meshes.hpp"

namespace vrda::contact_constraint_test {

// Central differences of 1e-5: travels of 10 mm have rounding errors of 1e-15, second differences of a sine
// relative errors of 1e-10.
constexpr double h = 1e-5;
constexpr double of_differences = 1e-7;

struct Scene {
  Mesh reference = test::ball(30, 7, 13);
  Mesh moving = test::ball(12, 6, 11);
  solve::RotationScale scale{{3, 0, -2}, 15};
  double flexion_rad = 0.3;
};

// Features of a small ball under a large one, both rotated.
std::vector<geometry::GapFeature> features_at(const Scene& scene, const solve::Configuration& configuration)
{
  const geometry::GapTree reference(scene.reference), moving(scene.moving);
  geometry::GapQuery query(reference, moving);
  query.set_attitude({scene.flexion_rad, configuration.varus_rad});
  return query.features(solve::pose_at(configuration, scene.scale), 3.0).features;
}

solve::Configuration random_configuration(std::mt19937_64& random)
{
  std::uniform_real_distribution<double> unit(-1, 1);
  return {{15 * unit(random), -45, 15 * unit(random)}, unit(random), 0.3 * unit(random)};
}

solve::Configuration displaced(solve::Configuration configuration, Eigen::Index coordinate, double by)
{
  if (coordinate < 3) configuration.pivot_mm(coordinate) += by;
  if (coordinate == about_y) configuration.theta_rad += by;
  if (coordinate == about_varus) configuration.varus_rad += by;
  return configuration;
}

solve::Clearance clearance_at(const Scene& scene, const solve::ContactConstraint& constraint,
                              const solve::Configuration& configuration)
{
  return solve::clearance(constraint, configuration, solve::Rotations(configuration, scene.flexion_rad));
}

// Both surfaces rounded: every kind of constraint occurs.
Scene rounded_scene()
{
  Scene scene;
  scene.reference.offset_mm.assign(static_cast<std::size_t>(scene.reference.triangles.rows()), 2.0);
  scene.moving.offset_mm.assign(static_cast<std::size_t>(scene.moving.triangles.rows()), 1.0);
  return scene;
}

// Each may be inside the other.
Scene soft_scene()
{
  Scene scene;
  for (Mesh* mesh : {&scene.reference, &scene.moving}) {
    mesh->overlap_mm.assign(static_cast<std::size_t>(mesh->triangles.rows()), 1.0);
    *mesh = inward_limit(*mesh);
  }
  return scene;
}

using Kind = solve::ContactConstraint::Kind;
using KindCounts = std::map<Kind, int>;

KindCounts expect_features(const Scene& scene)
{
  std::mt19937_64 random(1);
  KindCounts n;
  for (int k = 0; k < 60; ++k) {
    const solve::Configuration configuration = random_configuration(random);
    const solve::Rotations rotations(configuration, scene.flexion_rad);
    for (const geometry::GapFeature& f : features_at(scene, configuration)) {
      const solve::ContactConstraint constraint = solve::contact_constraint_of(
          f, {scene.reference, scene.moving, scene.scale}, configuration, rotations);
      const solve::Clearance c = solve::clearance(constraint, configuration, rotations);
      EXPECT_NEAR(c.travel_mm, f.travel_mm, 1e-9);
      EXPECT_LT((c.gradient.head<3>().normalized() - f.normal).norm(), 1e-6);
      ++n[constraint.kind];
    }
  }
  return n;
}

TEST(ContactConstraint, EqualsItsFeature)
{
  KindCounts n = expect_features(Scene());
  for (const Kind kind : {Kind::face_of_reference, Kind::face_of_moving, Kind::edges}) EXPECT_GT(n[kind], 20);
}

TEST(ContactConstraint, EqualsItsRoundedFeature)
{
  KindCounts n = expect_features(rounded_scene());
  for (const Kind kind : {Kind::face_of_reference, Kind::face_of_moving, Kind::edges, Kind::reference_edge,
                          Kind::moving_edge, Kind::vertices})
    EXPECT_GT(n[kind], 0);
}

// Where the force acts, both rounded surfaces meet: the distance along the normal is 0 and its derivative
// over a twist is that of the travel, times the slope.
TEST(ContactConstraint, ADistanceIsZeroAtTheEndOfTheTravel)
{
  const Scene scene = rounded_scene();
  std::mt19937_64 random(3);
  int n = 0;
  for (int k = 0; k < 20; ++k) {
    const solve::Configuration configuration = random_configuration(random);
    const solve::Rotations rotations(configuration, scene.flexion_rad);
    for (const geometry::GapFeature& f : features_at(scene, configuration)) {
      const solve::ContactConstraint constraint = solve::contact_constraint_of(
          f, {scene.reference, scene.moving, scene.scale}, configuration, rotations);
      const solve::Configuration touching = displaced(configuration, along_y, f.travel_mm);
      const solve::SolverPosition at{{scene.flexion_rad, touching.varus_rad},
                                     solve::pose_at(touching, scene.scale)};
      const solve::FeatureDistance d = solve::FeatureMeter(at, scene.scale.pivot_mm)(constraint);
      EXPECT_NEAR(d.distance_mm, 0.0, 1e-9);
      EXPECT_LT((d.normal - f.normal).norm(), 1e-9);
      const solve::Clearance c = clearance_at(scene, constraint, touching);
      EXPECT_LT((d.wrench.tail<3>() / d.normal.y() + c.gradient.head<3>()).norm(), 1e-6);
      EXPECT_LT((d.point_mm -
                 solve::contact_point_mm(constraint, touching, solve::Rotations(touching, scene.flexion_rad)))
                    .norm(),
                1e-9);
      ++n;
    }
  }
  EXPECT_GT(n, 50);
}

void expect_derivatives(const Scene& scene)
{
  std::mt19937_64 random(2);
  for (int k = 0; k < 40; ++k) {
    const solve::Configuration configuration = random_configuration(random);
    const solve::Rotations rotations(configuration, scene.flexion_rad);
    for (const geometry::GapFeature& f : features_at(scene, configuration)) {
      const solve::ContactConstraint constraint = solve::contact_constraint_of(
          f, {scene.reference, scene.moving, scene.scale}, configuration, rotations);
      const solve::Clearance c = solve::clearance(constraint, configuration, rotations);
      // The Hessian is exact at contact.
      const solve::Configuration touching = displaced(configuration, along_y, c.travel_mm);
      const Matrix5d hessian =
          solve::clearance_hessian(constraint, touching, solve::Rotations(touching, scene.flexion_rad));
      for (Eigen::Index i = 0; i < n_coordinates; ++i) {
        const auto at = [&](const solve::Configuration& p, double by) {
          return clearance_at(scene, constraint, displaced(p, i, by));
        };
        const double scale = 1.0 + c.gradient.norm() * c.gradient.norm();
        EXPECT_NEAR((at(configuration, h).travel_mm - at(configuration, -h).travel_mm) / (2 * h),
                    c.gradient(i), of_differences * scale * 40);
        const Vector5d change = (at(touching, h).gradient - at(touching, -h).gradient) / (2 * h);
        EXPECT_LT((change - hessian.col(i)).norm(), of_differences * scale * (40 + hessian.norm()));
      }
    }
  }
}

TEST(ContactConstraint, DerivativesMatchDifferences)
{
  expect_derivatives(Scene());
  expect_derivatives(rounded_scene());
  expect_derivatives(soft_scene());
}

TEST(ContactConstraint, IsExactUnderItsFace)
{
  // A vertex under a large flat face: its travel equals that of the gap query after any motion.
  Scene scene;
  scene.reference = test::box({0, 20, 0}, {200, 10, 200});
  scene.moving = test::pin({5, 2, -3});
  std::mt19937_64 random(3);
  const solve::Configuration configuration = random_configuration(random);
  const geometry::GapFeature f = features_at(scene, configuration).front();
  const solve::ContactConstraint constraint =
      solve::contact_constraint_of(f, {scene.reference, scene.moving, scene.scale}, configuration,
                                   solve::Rotations(configuration, scene.flexion_rad));
  for (int k = 0; k < 50; ++k) {
    solve::Configuration other = random_configuration(random);
    other.varus_rad = configuration.varus_rad + 0.02 * other.varus_rad;
    const std::vector<geometry::GapFeature> now = features_at(scene, other);
    ASSERT_FALSE(now.empty());
    EXPECT_NEAR(clearance_at(scene, constraint, other).travel_mm, now.front().travel_mm, 1e-9);
  }
}

TEST(ContactConstraint, ParallelToDeltaHasInfiniteTravel)
{
  solve::ContactConstraint constraint;
  constraint.reference_mm = Eigen::Vector3d(0, 1, 0);
  constraint.moving_mm = Eigen::Vector3d::Zero();
  constraint.reference_direction = Eigen::Vector3d::UnitX();
  constraint.moving_direction = Eigen::Vector3d::UnitY();
  EXPECT_TRUE(std::isinf(solve::clearance(constraint, {}, solve::Rotations(Attitude{}, 0.0)).travel_mm));
  EXPECT_EQ(solve::clearance_hessian(constraint, {}, solve::Rotations(Attitude{}, 0.0)).norm(), 0.0);
}

// Twice volume over area of the thinnest component; of an open sheet its edges.
TEST(Joint, ThinnestPart)
{
  // A plate of 100 x 2 x 100: 40000 / 20800.
  solve::SolverBody body{test::box({0, 0, 0}, {100, 2, 100}), std::vector<std::int32_t>(12, 0)};
  EXPECT_NEAR(solve::thinnest_part_mm(body), 40000.0 / 20800.0, 1e-12);
  append(body.mesh, test::box({0, 50, 0}, {3, 3, 3}));
  body.component.insert(body.component.end(), 12, 1);
  EXPECT_NEAR(solve::thinnest_part_mm(body), 1.0, 1e-12);
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
  EXPECT_EQ(first_triangle(joint.compartment_gap[1]), 3);
  EXPECT_GE(first_triangle(joint.compartment_gap[0]), 0);
  EXPECT_NE(first_triangle(joint.compartment_gap[0]), 3);
  EXPECT_NE(first_triangle(joint.compartment_gap[0]), 4);
  EXPECT_DOUBLE_EQ(solve::extent_along_delta_mm(joint.moving.tree_mesh.mesh), 1.0);
}

}  // namespace vrda::contact_constraint_test
