// The directional gap against the bisection of the boolean collision, which knows nothing of it.
#include "proximity/gap_query.hpp"

#include <gtest/gtest.h>

#include <random>

#include "contact/contacts.hpp"
#include "support/meshes.hpp"

namespace vrda {
namespace {

// Below this the boolean answer is the narrow phase's rounding.
constexpr double resolution_mm = 1e-7;

// The height between a free and a colliding one at which the objects first collide.
double bisected_travel_mm(const TreeMesh& reference, const TreeMesh& moving, const MovingPose& pose,
                          double free_mm, double colliding_mm)
{
  NarrowPhase narrow_phase;
  const auto collides = [&](double travel_mm) {
    MovingPose moved = pose;
    moved.translation_mm.y() += travel_mm;
    return find_collision(reference, moving, moved, narrow_phase).has_value();
  };
  EXPECT_FALSE(collides(free_mm));
  EXPECT_TRUE(collides(colliding_mm));
  while (colliding_mm - free_mm > 0.1 * resolution_mm) {
    const double middle = 0.5 * (free_mm + colliding_mm);
    (collides(middle) ? colliding_mm : free_mm) = middle;
  }
  return free_mm;
}

TEST(GapAgainstCollision, TheTravelIsWhereBisectionEnds)
{
  std::mt19937_64 random(31);
  std::uniform_real_distribution<double> unit(-1, 1);
  Mesh bumps = test::ball(10, 14, 22), dents = test::ball(8, 13, 20);
  for (Mesh* mesh : {&bumps, &dents}) {
    for (Eigen::Index v = 0; v < mesh->vertices_mm.rows(); ++v) {
      mesh->vertices_mm.row(v) *= 1.0 + 0.1 * unit(random);
    }
  }
  const TreeMesh upper = make_tree_mesh(bumps), lower = make_tree_mesh(dents);
  GapQuery query{GapTree(bumps), GapTree(dents)};
  for (int k = 0; k < 100; ++k) {
    const Attitude attitude{unit(random), 0.3 * unit(random)};
    const double x = 8 * unit(random), z = 8 * unit(random);
    const MovingPose pose{{x, -30, z}, 3 * unit(random)};
    query.set_attitude(attitude);
    const double travel = query.travel_mm(pose);

    EXPECT_NEAR(bisected_travel_mm(turned(upper, attitude), lower, pose, travel - 5, travel + 0.01), travel,
                resolution_mm);
  }
}

}  // namespace
}  // namespace vrda
