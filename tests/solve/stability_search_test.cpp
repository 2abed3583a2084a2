// The moves that the search reports to its observer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/units.hpp"
#include "solve/pins.hpp"
#include "solve/stability_search.hpp"
#include "support/directional_gap.hpp"
#include "support/meshes.hpp"

namespace vrda::stability_search_test {

// A sheet y = -(x^2 + z^2) / 80 that faces down: a ball pushed up ends in its middle. `narrowing` > 1 makes
// it a trough along X.
Mesh dish(double narrowing = 1.0)
{
  return test::ceiling(60, 30, [&](double x, double z) { return -(x * x + narrowing * z * z) / 80.0; });
}

// A dish with a thin fin as an obstruction: its searches bisect.
solve::Joint ball_and_fin()
{
  Mesh scene = dish();
  append(scene, test::box({5, -10, 0}, {0.2, 20, 40}));
  return solve::make_joint({scene, {}}, {test::ball(2, 8, 16), {}}, {});
}

// A bar under a trough: its searches rotate.
solve::Joint bar_in_trough()
{
  return solve::make_joint({dish(4.0), {}}, {test::box({0, 0, 0}, {24, 2, 3}), {}}, {});
}

struct Watched {
  SearchOptions options;
  StepRecord result;
  std::vector<SearchMove> moves;
  std::vector<SearchMove> touches;  ///< the moves in contact
};

Watched watch(const solve::Joint& joint, const MovingPose& seed, const SearchOptions& options = {})
{
  Watched w;
  w.options = options;
  w.result =
      solve::find_stable_pose(joint, {}, seed, options, [&](const SearchMove& m) { w.moves.push_back(m); });
  std::copy_if(w.moves.begin(), w.moves.end(), std::back_inserter(w.touches),
               [](const SearchMove& m) { return m.in_contact; });
  return w;
}

// Searches from many seeds in both scenes, all of which end stable.
std::vector<Watched> searches()
{
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<Watched> all;
  for (const solve::Joint& joint : {ball_and_fin(), bar_in_trough()}) {
    for (int k = 0; k < 12; ++k) {
      all.push_back(watch(joint, {{16 * unit(random), -40, 16 * unit(random)}, unit(random)}));
    }
  }
  return all;
}

int count(const Watched& w, MoveKind kind)
{
  return static_cast<int>(
      std::count_if(w.moves.begin(), w.moves.end(), [&](const SearchMove& m) { return m.kind == kind; }));
}

bool is_same(const MovingPose& a, const MovingPose& b)
{
  return a.translation_mm == b.translation_mm && a.theta_rad == b.theta_rad;
}

TEST(SearchMoves, EachIterationTouchesOnceAndMovesOnceButTheLast)
{
  int n_turns = 0, n_bisections = 0;
  for (const Watched& w : searches()) {
    ASSERT_EQ(w.result.status, StepStatus::stable);
    ASSERT_EQ(w.touches.size(), static_cast<std::size_t>(w.result.iterations));
    for (std::size_t k = 0; k < w.touches.size(); ++k) {
      EXPECT_EQ(w.touches[k].iteration, static_cast<int>(k) + 1);
      EXPECT_EQ(w.touches[k].kind, MoveKind::approach);
    }
    EXPECT_EQ(count(w, MoveKind::rotate) + count(w, MoveKind::translate), w.result.iterations - 1);
    EXPECT_GT(w.moves.size(), w.touches.size());
    EXPECT_TRUE(is_same(w.touches.back().pose, w.result.pose));
    EXPECT_TRUE(w.moves.back().in_contact);
    n_turns += count(w, MoveKind::rotate);
    n_bisections += count(w, MoveKind::bisect);
  }
  EXPECT_GT(n_turns, 20);
  EXPECT_GT(n_bisections, 20);
}

TEST(SearchMoves, ACycleIsAPoseSeenBeforeWithinBothResolutions)
{
  int n_cycles = 0, n_new = 0;
  for (const Watched& w : searches()) {
    std::vector<MovingPose> seen;  // new poses only: with those of cycles the search could creep
    for (const SearchMove& m : w.touches) {
      const bool was_here = std::any_of(seen.begin(), seen.end(), [&](const MovingPose& p) {
        return (p.translation_mm - m.pose.translation_mm).norm() < w.options.translation_resolution_mm &&
               std::abs(p.theta_rad - m.pose.theta_rad) < w.options.rotation_resolution_rad;
      });
      EXPECT_EQ(m.is_cycle, was_here);
      if (!was_here) seen.push_back(m.pose);
      (was_here ? n_cycles : n_new) += 1;
    }
  }
  EXPECT_GT(n_cycles, 20);
  EXPECT_GT(n_new, 20);
}

TEST(SearchMoves, TheRetreatBelongsToNoIteration)
{
  const Watched w = watch(bar_in_trough(), {{1, -0.5, 1}, 0});
  EXPECT_EQ(w.moves.front().kind, MoveKind::retreat);
  EXPECT_EQ(w.moves.front().iteration, 0);
  EXPECT_EQ(count(w, MoveKind::retreat), 1);
}

TEST(SearchMoves, WithoutContactThereIsNoMove)
{
  const Watched w = watch(bar_in_trough(), {{200, -40, 0}, 0});
  EXPECT_EQ(w.result.status, StepStatus::no_contact);
  EXPECT_TRUE(w.moves.empty());
}

TEST(SearchMoves, TheLimitEndsWithAMotion)
{
  SearchOptions options;
  options.max_steps = 3;
  const Watched w = watch(ball_and_fin(), {{-16, -40, 0}, 0}, options);
  ASSERT_EQ(w.result.status, StepStatus::iteration_limit);
  EXPECT_EQ(w.touches.size(), 3u);
  EXPECT_EQ(w.moves.back().kind, MoveKind::translate);
  EXPECT_TRUE(is_same(w.moves.back().pose, w.result.pose));
}

TEST(SearchMoves, AnObserverChangesNothing)
{
  const solve::Joint joint = ball_and_fin();
  const MovingPose seed{{14, -40, 3}, 0.2};
  const StepRecord alone = solve::find_stable_pose(joint, {}, seed, {});
  const Watched w = watch(joint, seed);
  EXPECT_TRUE(is_same(alone.pose, w.result.pose));
  EXPECT_EQ(alone.queries, w.result.queries);
  EXPECT_EQ(alone.iterations, w.result.iterations);
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

TEST(StabilitySearch, NoFreePoseBelowIsNoClearance)
{
  Mesh shelves;
  for (int k = 0; k < 40; ++k) append(shelves, test::ceiling(30, 2, [k](double, double) { return -k; }));
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
  EXPECT_FALSE(r.is_in_contact[0]);
  EXPECT_TRUE(r.is_in_contact[1]);
  EXPECT_NEAR(r.gap_mm[0] - r.gap_mm[1], 0.4, 1e-9);
  EXPECT_LE(r.gap_mm[1], options.translation_resolution_mm);
  EXPECT_FALSE(r.theta_determined);
}

}  // namespace vrda::stability_search_test
