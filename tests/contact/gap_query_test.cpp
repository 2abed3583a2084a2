// The directional gap against bisection with the independent collision test.
#include "geometry/gap_query.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "contact/contacts.hpp"
#include "contact/narrow_phase.hpp"
#include "contact/triangle_closed_forms.hpp"
#include "support/meshes.hpp"

namespace vrda::gap_query_test {

// Below this the collision test is decided by rounding in the narrow phase.
constexpr double resolution_mm = 1e-7;

// The travel between a free and a colliding one at which the objects first collide.
double bisected_travel_mm(const geometry::TreeMesh& reference, const geometry::TreeMesh& moving,
                          const MovingPose& pose, double free_mm, double colliding_mm)
{
  contact::NarrowPhase narrow_phase;
  const auto collides = [&](double travel_mm) {
    MovingPose moved = pose;
    moved.translation_mm.y() += travel_mm;
    return contact::find_collision(reference, moving, moved, narrow_phase).has_value();
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
  const geometry::TreeMesh upper = geometry::make_tree_mesh(bumps), lower = geometry::make_tree_mesh(dents);
  geometry::GapQuery query{geometry::GapTree(bumps), geometry::GapTree(dents)};
  for (int k = 0; k < 100; ++k) {
    const Attitude attitude{unit(random), 0.3 * unit(random)};
    const double x = 8 * unit(random), z = 8 * unit(random);
    const MovingPose pose{{x, -30, z}, 3 * unit(random)};
    query.set_attitude(attitude);
    const double travel = query.travel_mm(pose);

    EXPECT_NEAR(bisected_travel_mm(geometry::rotated_reference(upper, attitude), lower, pose, travel - 5,
                                   travel + 0.01),
                travel, resolution_mm);
  }
}

// Every pair of triangles within the band of each other, by exhaustive search.
std::vector<geometry::TrianglePair> pairs_within(const Mesh& reference, const Mesh& moving,
                                                 const Attitude& attitude, const MovingPose& pose,
                                                 double band_mm)
{
  const geometry::Placement place(pose);
  const Eigen::Matrix3d R = reference_rotation(attitude);
  std::vector<geometry::TrianglePair> near;
  for (std::int32_t r = 0; r < reference.triangles.rows(); ++r) {
    geometry::Corners a = corners(reference, r);
    for (Eigen::Vector3d& p : a) p = R * p;
    for (std::int32_t m = 0; m < moving.triangles.rows(); ++m) {
      const geometry::Corners b = place(corners(moving, m));
      if (test::separation_mm(a, b) <= 0.0 || test::closest_points(a, b).distance_mm <= band_mm)
        near.push_back({r, m});
    }
  }
  return near;
}

TEST(ClosePairs, HoldEveryPairWithinTheBand)
{
  std::mt19937_64 random(47);
  std::uniform_real_distribution<double> unit(-1, 1);
  Mesh bumps = test::ball(10, 10, 14), dents = test::ball(8, 9, 12);
  for (Mesh* mesh : {&bumps, &dents}) {
    for (Eigen::Index v = 0; v < mesh->vertices_mm.rows(); ++v)
      mesh->vertices_mm.row(v) *= 1.0 + 0.1 * unit(random);
  }
  geometry::GapQuery query{geometry::GapTree(bumps), geometry::GapTree(dents)};
  int n_near = 0, n_apart = 0;
  for (int k = 0; k < 60; ++k) {
    // Near contact from any direction, with bands from 1e-3 mm to the size of a facet.
    const double band_mm = k % 3 == 0 ? 1e-3 : (k % 3 == 1 ? 0.05 : 2.0);
    const Attitude attitude{3 * unit(random), 0.3 * unit(random)};
    Eigen::Vector3d direction(unit(random), unit(random), unit(random));
    const MovingPose pose{direction.normalized() * (17.0 + 2.0 * unit(random)), 3 * unit(random)};
    const std::vector<geometry::TrianglePair> wanted = pairs_within(bumps, dents, attitude, pose, band_mm);
    query.set_attitude(attitude);
    const std::vector<geometry::TrianglePair>& found = query.close_pairs(pose, band_mm);
    const std::set<geometry::TrianglePair> all(found.begin(), found.end());
    EXPECT_EQ(all.size(), found.size()) << "each once";
    for (const geometry::TrianglePair& pair : wanted)
      EXPECT_TRUE(all.contains(pair)) << pair.reference << " " << pair.moving;
    ++(wanted.empty() ? n_apart : n_near);
  }
  EXPECT_GT(n_near, 20);
  EXPECT_GT(n_apart, 5);
}

TEST(TravelAtMost, IsNoLessThanTheTravel)
{
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  const geometry::GapTree upper(test::ball(10, 14, 22)), lower(test::ball(8, 13, 20));
  geometry::GapQuery query(upper, lower);
  EXPECT_TRUE(std::isinf(query.travel_upper_bound_mm({{0, -30, 0}, 0}))) << "no hints yet";
  int n_known = 0;
  for (int k = 0; k < 200; ++k) {
    const MovingPose pose{{4 * unit(random), -30, 4 * unit(random)}, 0.3 * unit(random)};
    const int n_queries = query.n_queries();
    const double most_mm = query.travel_upper_bound_mm(pose);
    EXPECT_EQ(query.n_queries(), n_queries);
    EXPECT_GE(most_mm, query.travel_mm(pose));
    n_known += std::isfinite(most_mm) ? 1 : 0;
  }
  EXPECT_GT(n_known, 20);
}

}  // namespace vrda::gap_query_test
