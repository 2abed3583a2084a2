#include "solve/stability_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "core/units.hpp"
#include "support/directional_gap.hpp"
#include "support/meshes.hpp"

namespace vrda::stability_search_test {

// A sheet y = height(x, z) with normals down or up.
Mesh surface(double size_mm, int n, bool faces_down, const std::function<double(double, double)>& height)
{
  Mesh mesh = test::sheet(size_mm, n);
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    mesh.vertices_mm(v, 1) = height(mesh.vertices_mm(v, 0), mesh.vertices_mm(v, 2));
  }
  if (faces_down) mesh.triangles.col(1).swap(mesh.triangles.col(2));
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

// The underside of a dish: highest in the middle, where a ball pushed up ends.
Mesh dish()
{
  return surface(60, 30, true, [](double x, double z) { return -(x * x + z * z) / 80.0; });
}

solve::Joint ball_in_dish()
{
  return solve::make_joint({dish(), {}}, {test::ball(6, 16, 32), {}}, {});
}

void expect_clean_contact(const solve::Joint& joint, const StepRecord& r, const SearchOptions& options)
{
  contact::NarrowPhase narrow_phase;
  EXPECT_FALSE(
      contact::find_collision(joint.reference.tree_mesh, joint.moving.tree_mesh, r.pose, narrow_phase)
          .has_value());
  EXPECT_LE(test::directional_gap(joint.reference.tree_mesh, joint.moving.tree_mesh.mesh,
                                  joint.moving.tree_mesh.tree, r.pose)
                .travel_mm,
            options.translation_resolution_mm);
}

TEST(StabilitySearch, ABallEndsInTheMiddleOfADishFromAnywhere)
{
  const solve::Joint joint = ball_in_dish();
  const SearchOptions options;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int k = 0; k < 25; ++k) {
    const MovingPose seed{{20 * unit(random), -40, 20 * unit(random)}, unit(random)};
    const StepRecord r = solve::find_stable_pose(joint, {}, seed, options);
    SCOPED_TRACE(testing::Message() << seed.translation_mm.transpose());
    ASSERT_EQ(r.status, StepStatus::stable);
    // The facets of ball and dish are 2 mm wide and 1 to 2 degrees apart: a polygonal optimum is within one
    // facet.
    EXPECT_LT(std::abs(r.pose.translation_mm.x()), 1.0);
    EXPECT_LT(std::abs(r.pose.translation_mm.z()), 1.0);
    EXPECT_FALSE(r.contacts.empty());
    EXPECT_GT(r.iterations, 0);
    expect_clean_contact(joint, r, options);
  }
}

TEST(StabilitySearch, AGrooveTurnsUntilBothPinsLieInIt)
{
  // Two downward spikes at (10, 0, 1) and (-10, 0, -1); the groove along X must rotate by -atan(0.1).
  Mesh spikes = test::box({0, 10, 0}, {30, 2, 10});
  for (const double side : {1.0, -1.0}) {
    Mesh spike;
    spike.vertices_mm.resize(4, 3);
    spike.vertices_mm << 10 * side, 0, side, 10 * side - 1, 5, side - 1, 10 * side + 1, 5, side - 1,
        10 * side, 5, side + 1;
    spike.triangles.resize(4, 3);
    spike.triangles << 0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2;
    spike.normals = vertex_normals(spike);
    append(spikes, spike);
  }
  const Mesh groove = surface(40, 2, false, [](double, double z) { return 0.3 * std::abs(z); });
  const solve::Joint joint = solve::make_joint({spikes, {}}, {groove, {}}, {});
  const SearchOptions options;
  for (const double theta : {0.0, 0.2, -0.3}) {
    const StepRecord r = solve::find_stable_pose(joint, {}, {{0, -20, 0}, theta}, options);
    SCOPED_TRACE(theta);
    ASSERT_EQ(r.status, StepStatus::stable);
    // Both spikes end within twice the translation resolution of the bottom line: 0.2 mm over 10 mm.
    EXPECT_NEAR(r.pose.theta_rad, -std::atan(0.1), 0.02);
    EXPECT_EQ(r.contacts.size(), 2u);
    expect_clean_contact(joint, r, options);
  }
}

TEST(StabilitySearch, LeavesTheReferenceBehind)
{
  const StepRecord r = solve::find_stable_pose(ball_in_dish(), {}, {{100, -40, 0}, 0}, {});
  EXPECT_EQ(r.status, StepStatus::no_contact);
  EXPECT_TRUE(r.contacts.empty());
}

TEST(StabilitySearch, NoFreePoseBelowIsNoClearance)
{
  Mesh shelves;
  for (int k = 0; k < 40; ++k) append(shelves, surface(30, 2, true, [k](double, double) { return -k; }));
  const solve::Joint joint = solve::make_joint({shelves, {}}, {test::ball(2), {}}, {});
  EXPECT_EQ(solve::find_stable_pose(joint, {}, {{0, -15.5, 0}, 0}, {}).status, StepStatus::no_clearance);
}

TEST(StabilitySearch, ATiltedThinPlateIsBackedOutOf)
{
  // A plate of 100 mm at 10 degrees extends 9 mm down on one side: the limit must depend on the attitude, not
  // on the thickness.
  const solve::Joint joint =
      solve::make_joint({test::box({0, 0.5, 0}, {100, 1, 100}), {}}, {test::ball(6, 16, 32), {}}, {});
  const StepRecord r = solve::find_stable_pose(joint, {rad_from_deg(10), 0}, {{-10, -3, 0}, 0}, {});
  EXPECT_NE(r.status, StepStatus::no_clearance);
}

TEST(StabilitySearch, AResolutionBelowRoundingStillEnds)
{
  SearchOptions options;
  options.translation_resolution_mm = options.rotation_resolution_rad = 1e-300;
  options.max_steps = 30;
  const StepRecord r = solve::find_stable_pose(ball_in_dish(), {}, {{4, -20, 0}, 0}, options);
  EXPECT_LE(r.iterations, 30);
  EXPECT_NE(r.status, StepStatus::pending);
}

TEST(StabilitySearch, EveryVariantOfPointsAndNormalsComesToRest)
{
  const solve::Joint joint = ball_in_dish();
  for (const ContactPoints points : {ContactPoints::exact, ContactPoints::triangle_centre}) {
    for (const ContactNormals normals :
         {ContactNormals::least_curvature, ContactNormals::reference, ContactNormals::moving}) {
      SearchOptions options;
      options.points = points;
      options.normals = normals;
      const StepRecord r = solve::find_stable_pose(joint, {}, {{6, -30, -4}, 0}, options);
      ASSERT_EQ(r.status, StepStatus::stable);
      expect_clean_contact(joint, r, options);
    }
  }
}

TEST(StabilitySearch, AnOverlappingSeedBacksOutFirst)
{
  const solve::Joint joint = ball_in_dish();
  const StepRecord r = solve::find_stable_pose(joint, {}, {{1, -4, 1}, 0}, {});
  ASSERT_EQ(r.status, StepStatus::stable);
  expect_clean_contact(joint, r, {});
}

TEST(StabilitySearch, TheLimitIsAStatus)
{
  SearchOptions options;
  options.max_steps = 3;
  const StepRecord r = solve::find_stable_pose(ball_in_dish(), {}, {{20, -40, 0}, 0}, options);
  EXPECT_EQ(r.status, StepStatus::iteration_limit);
  EXPECT_EQ(r.iterations, 3);
}

TEST(StabilitySearch, SameInputSameBits)
{
  const solve::Joint joint = ball_in_dish();
  const MovingPose seed{{7, -40, -11}, 0.1};
  const StepRecord a = solve::find_stable_pose(joint, {0.2, 0.05}, seed, {});
  const StepRecord b = solve::find_stable_pose(joint, {0.2, 0.05}, seed, {});
  EXPECT_EQ(a.pose.translation_mm, b.pose.translation_mm);
  EXPECT_EQ(a.pose.theta_rad, b.pose.theta_rad);
  EXPECT_EQ(a.queries, b.queries);
}

TEST(StabilitySearch, EveryMotionIsReported)
{
  int n_slides = 0, n_approaches = 0, last = 0;
  const SearchObserver watch = [&](const SearchMove& move) {
    n_slides += move.kind == MoveKind::translate ? 1 : 0;
    n_approaches += move.kind == MoveKind::approach ? 1 : 0;
    EXPECT_GE(move.iteration, last);
    last = move.iteration;
  };
  const StepRecord r = solve::find_stable_pose(ball_in_dish(), {}, {{15, -40, 0}, 0}, {}, watch);
  EXPECT_GT(n_slides, 10) << "15 mm in steps of 1 mm";
  EXPECT_GT(n_approaches, 10);
  EXPECT_EQ(last, r.iterations);
}

TEST(StabilitySearch, TheFirstApproachIsReportedInStrides)
{
  std::vector<double> heights_mm;
  const SearchObserver watch = [&](const SearchMove& move) {
    if (move.iteration == 1 && move.kind == MoveKind::approach)
      heights_mm.push_back(move.pose.translation_mm.y());
  };
  SearchOptions options;
  options.approach_step_mm = 10.0;
  solve::find_stable_pose(ball_in_dish(), {}, {{0, -40, 0}, 0}, options, watch);
  // The ball's top starts 34 mm below the dish.
  ASSERT_EQ(heights_mm.size(), 4u);
  EXPECT_DOUBLE_EQ(heights_mm[0], -30.0);
  EXPECT_DOUBLE_EQ(heights_mm[2], -10.0);
}

TEST(StabilitySearch, ThinPartsAreNotPassedInOneStep)
{
  // A thin vertical fin obstructs the ball's path to the middle; steps of 10 mm must stop at it.
  Mesh scene = dish();
  append(scene, test::box({5, -10, 0}, {0.2, 20, 40}));
  std::vector<std::int32_t> component(static_cast<std::size_t>(scene.triangles.rows()), 0);
  std::fill(component.end() - 12, component.end(), 1);
  const solve::Joint joint = solve::make_joint({scene, component}, {test::ball(1, 8, 16), {}}, {});
  SearchOptions options;
  options.translation_step_mm = 10.0;
  const StepRecord r = solve::find_stable_pose(joint, {}, {{12, -40, 0}, 0}, options);
  ASSERT_EQ(r.status, StepStatus::stable);
  EXPECT_GT(r.pose.translation_mm.x(), 5.1);
}

TEST(StabilitySearch, CompartmentsReportTheirGapsAndFlags)
{
  // A flat plate under two downward spikes, the medial one (z < 0) 0.4 mm higher.
  const auto spike = [](double z, double y) {
    Mesh mesh;
    mesh.vertices_mm.resize(4, 3);
    mesh.vertices_mm << 0, y, z, -1, y + 5, z - 1, 1, y + 5, z - 1, 0, y + 5, z + 1;
    mesh.triangles.resize(4, 3);
    mesh.triangles << 0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2;
    mesh.normals = vertex_normals(mesh);
    return mesh;
  };
  Mesh reference = spike(-10.2, 0.4);
  append(reference, spike(10.2, 0.0));
  const Mesh plate = test::sheet(40, 4);
  std::vector<Compartment> compartments;
  for (Eigen::Index t = 0; t < plate.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(plate, t);
    compartments.push_back(a.z() + b.z() + c.z() < 0 ? Compartment::medial : Compartment::lateral);
  }
  const solve::Joint joint = solve::make_joint({reference, {}}, {plate, {}}, compartments);
  const SearchOptions options;
  const StepRecord r = solve::find_stable_pose(joint, {}, {{0.3, -20, 0.1}, 0}, options);
  ASSERT_EQ(r.status, StepStatus::stable);
  EXPECT_FALSE(r.contact_medial);
  EXPECT_TRUE(r.contact_lateral);
  EXPECT_NEAR(r.gap_medial_mm - r.gap_lateral_mm, 0.4, 1e-9);
  EXPECT_LE(r.gap_lateral_mm, options.translation_resolution_mm);
  EXPECT_FALSE(r.theta_determined);
}

}  // namespace vrda::stability_search_test
