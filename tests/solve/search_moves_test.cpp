// The moves that the search reports to its observer.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "solve/stability_search.hpp"
#include "support/meshes.hpp"

namespace vrda::search_moves_test {

// A sheet y = -(x^2 + z^2) / 80 that faces down: a ball pushed up ends in its middle. `narrowing` > 1 makes
// it a trough along X.
Mesh dish(double narrowing = 1.0)
{
  Mesh mesh = test::sheet(60, 30);
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    const double x = mesh.vertices_mm(v, 0), z = mesh.vertices_mm(v, 2);
    mesh.vertices_mm(v, 1) = -(x * x + narrowing * z * z) / 80.0;
  }
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  mesh.normals = vertex_normals(mesh);
  return mesh;
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

TEST(SearchMoves, IterationsNeverFallAndOnlyTouchesCarryContacts)
{
  for (const Watched& w : searches()) {
    int last = 0;
    for (const SearchMove& m : w.moves) {
      EXPECT_GE(m.iteration, last);
      last = m.iteration;
      EXPECT_TRUE(m.in_contact || m.contacts.empty());
      EXPECT_TRUE(m.in_contact || !m.is_cycle);
      EXPECT_TRUE(m.kind == MoveKind::bisect || !m.collides);
    }
    EXPECT_FALSE(w.touches.back().contacts.empty());
  }
}

TEST(SearchMoves, TrialsOfABisectionHalve)
{
  // Trials are consecutive, followed by their motion; each difference is half the previous one.
  int n_halvings = 0;
  for (const Watched& w : searches()) {
    std::vector<double> strides;
    for (std::size_t k = 0; k + 1 < w.moves.size(); ++k) {
      const SearchMove& a = w.moves[k];
      const SearchMove& b = w.moves[k + 1];
      const bool both = a.kind == MoveKind::bisect && b.kind == MoveKind::bisect;
      EXPECT_TRUE(a.kind != MoveKind::bisect || a.iteration == b.iteration);
      if (!both) strides.clear();
      if (!both) continue;
      strides.push_back(a.pose.theta_rad == b.pose.theta_rad
                            ? (b.pose.translation_mm - a.pose.translation_mm).norm()
                            : std::abs(b.pose.theta_rad - a.pose.theta_rad));
      if (strides.size() < 2) continue;
      // Poses of tens of mm have rounding errors of 1e-14 mm.
      EXPECT_NEAR(strides[strides.size() - 2], 2.0 * strides.back(), 1e-12);
      ++n_halvings;
    }
  }
  EXPECT_GT(n_halvings, 20);
}

// A rotation ends there; a long translation there or earlier, at a larger travel along Delta.
TEST(SearchMoves, AMotionEndsAtItsLastFreeTrialOrBefore)
{
  int n_there = 0, n_before = 0;
  for (const Watched& w : searches()) {
    const SearchMove* free = nullptr;
    MovingPose start;
    for (const SearchMove& m : w.moves) {
      if (m.kind == MoveKind::bisect) {
        free = m.collides ? free : &m;
        continue;
      }
      if (free != nullptr) {
        const double trial_mm = (free->pose.translation_mm - start.translation_mm).norm();
        EXPECT_LE((m.pose.translation_mm - start.translation_mm).norm(), trial_mm * (1.0 + 1e-12));
        EXPECT_TRUE(m.kind == MoveKind::translate || is_same(free->pose, m.pose));
        ++(is_same(free->pose, m.pose) ? n_there : n_before);
      }
      free = nullptr;
      start = m.pose;
    }
  }
  EXPECT_GT(n_there, 5);
  EXPECT_GT(n_before, 0);
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

TEST(SearchMoves, StepsAreThoseAfterCycleDetection)
{
  int n_halved = 0;
  for (const Watched& w : searches()) {
    const SearchMove* motion = nullptr;  // the last rotation or translation
    for (const SearchMove& m : w.moves) {
      if (m.kind == MoveKind::rotate || m.kind == MoveKind::translate) motion = &m;
      if (!m.in_contact || motion == nullptr || !m.is_cycle) continue;
      const bool is_turn = motion->kind == MoveKind::rotate;
      const double halved = is_turn ? m.rotation_step_rad : m.translation_step_mm;
      const double before = is_turn ? motion->rotation_step_rad : motion->translation_step_mm;
      EXPECT_EQ(halved, 0.5 * before);
      ++n_halved;
    }
  }
  EXPECT_GT(n_halved, 20);
}

TEST(SearchMoves, ContactsHaveTheCompartmentOfTheMovingTriangle)
{
  const Mesh plate = test::sheet(10, 2);
  std::vector<Compartment> compartments;
  for (Eigen::Index t = 0; t < plate.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(plate, t);
    compartments.push_back(a.z() + b.z() + c.z() < 0 ? Compartment::medial : Compartment::lateral);
  }
  const solve::Joint joint = solve::make_joint({test::ball(3), {}}, {plate, {}}, compartments);
  const Watched w = watch(joint, {{0, -20, 2}, 0});
  ASSERT_EQ(w.result.status, StepStatus::stable);
  const ContactRecord& reported = w.touches.back().contacts.front();
  const ContactRecord& kept = w.result.contacts.front();
  EXPECT_EQ(reported.compartment, kept.compartment);
  EXPECT_EQ(reported.compartment, static_cast<std::int8_t>(Compartment::medial));
  EXPECT_EQ(reported.point_solver_mm, kept.point_solver_mm);
}

TEST(SearchMoves, AContactWithoutTravelIsReported)
{
  const solve::Joint joint = bar_in_trough();
  const Watched first = watch(joint, {{3, -40, 1}, 0.3});
  const Watched again = watch(joint, first.result.pose);
  ASSERT_FALSE(again.moves.empty());
  EXPECT_TRUE(again.moves.front().in_contact);
  EXPECT_TRUE(is_same(again.moves.front().pose, first.result.pose));
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

}  // namespace vrda::search_moves_test
