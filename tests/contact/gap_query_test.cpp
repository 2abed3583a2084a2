// The directional gap against bisection with the independent collision test.
// Invariance of the result: exchange of the objects, numbering of triangles and vertices.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "contact/contacts.hpp"
#include "contact/narrow_phase.hpp"
#include "geometry/gap_query.hpp"
#include "support/directional_gap.hpp"
#include "support/meshes.hpp"
#include "support/triangle_distance.hpp"

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
      if (test::triangle_distance_mm(a, b) <= band_mm) near.push_back({r, m});
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

constexpr int n_poses = 1500;

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high)
  {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  std::vector<Eigen::Index> permutation(Eigen::Index n)
  {
    std::vector<Eigen::Index> order(static_cast<std::size_t>(n));
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    std::shuffle(order.begin(), order.end(), engine_);
    return order;
  }

 private:
  std::mt19937_64 engine_;
};

Mesh renumbered(const Mesh& mesh, Random& random)
{
  Mesh result = mesh;
  const std::vector<Eigen::Index> vertex = random.permutation(mesh.vertices_mm.rows());
  for (Eigen::Index v = 0; v < mesh.vertices_mm.rows(); ++v) {
    result.vertices_mm.row(vertex[static_cast<std::size_t>(v)]) = mesh.vertices_mm.row(v);
    result.normals.row(vertex[static_cast<std::size_t>(v)]) = mesh.normals.row(v);
  }
  const std::vector<Eigen::Index> triangle = random.permutation(mesh.triangles.rows());
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Index first = static_cast<Eigen::Index>(random.between(0.0, 2.999));
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto old = static_cast<std::size_t>(mesh.triangles(t, (first + k) % 3));
      result.triangles(triangle[static_cast<std::size_t>(t)], k) = static_cast<std::int32_t>(vertex[old]);
    }
  }
  return result;
}

// A ball and a box, so that faces, edges and corners all come into contact.
struct Objects {
  Mesh box = test::box({0, 0, 0}, {20, 12, 16});
  Mesh ball = test::ball(9.0, 10, 17);
};

// Near the first contact from below: within 1e-7 to 10 mm of it, on either side.
MovingPose near_touch(const geometry::TreeMesh& reference, const geometry::TreeMesh& moving, Random& random)
{
  MovingPose pose{{random.between(-12, 12), -40, random.between(-12, 12)}, random.between(-3, 3)};
  const geometry::Gap gap = test::directional_gap(reference, moving.mesh, moving.tree, pose);
  const double off_mm = std::pow(10.0, random.between(-7.0, 1.0));
  pose.translation_mm.y() += gap.travel_mm + (random.between(-1, 1) < 0.0 ? -off_mm : off_mm);
  return pose;
}

MovingPose exchanged(const MovingPose& pose)
{
  const MovingPose back{Eigen::Vector3d::Zero(), -pose.theta_rad};
  return {-geometry::Placement(back)(pose.translation_mm), -pose.theta_rad};
}

TEST(CollisionInvariance, ExchangeAndNumberingChangeNothing)
{
  Random random(71);
  contact::NarrowPhase narrow_phase;
  const Objects objects;
  const geometry::TreeMesh moving = geometry::make_tree_mesh(objects.ball),
                           other_moving = geometry::make_tree_mesh(renumbered(objects.ball, random));
  const geometry::TreeMesh box = geometry::make_tree_mesh(objects.box),
                           other_box = geometry::make_tree_mesh(renumbered(objects.box, random));
  int n_colliding = 0;
  for (int k = 0; k < n_poses; ++k) {
    SCOPED_TRACE(k);
    const Attitude attitude{random.between(-3, 3), random.between(-1.5, 1.5)};
    const geometry::TreeMesh reference = geometry::rotated_reference(box, attitude),
                             other_reference = geometry::rotated_reference(other_box, attitude);
    const MovingPose pose = near_touch(reference, moving, random);
    const bool collides = contact::find_collision(reference, moving, pose, narrow_phase).has_value();
    EXPECT_EQ(contact::find_collision(moving, reference, exchanged(pose), narrow_phase).has_value(),
              collides);
    EXPECT_EQ(contact::find_collision(other_reference, other_moving, pose, narrow_phase).has_value(),
              collides);
    n_colliding += collides ? 1 : 0;
  }
  EXPECT_GT(n_colliding, n_poses / 4);
  EXPECT_LT(n_colliding, 3 * n_poses / 4);
}

TEST(ContactInvariance, NumberingChangesNoPointNormalOrDistance)
{
  Random random(72);
  contact::NarrowPhase narrow_phase;
  const Objects objects;
  const contact::Collider moving = contact::make_collider(objects.ball),
                          other_moving = contact::make_collider(renumbered(objects.ball, random));
  const contact::Collider box = contact::make_collider(objects.box),
                          other_box = contact::make_collider(renumbered(objects.box, random));
  int n_touching = 0;
  for (int k = 0; k < n_poses; ++k) {
    SCOPED_TRACE(k);
    const Attitude attitude{random.between(-3, 3), random.between(-1.5, 1.5)};
    const geometry::TreeMesh reference = geometry::rotated_reference(box.tree_mesh, attitude),
                             other_reference = geometry::rotated_reference(other_box.tree_mesh, attitude);
    const MovingPose pose = near_touch(reference, moving.tree_mesh, random);
    const auto contacts = contact::find_contacts({reference, box.features, moving}, pose, narrow_phase, {});
    const auto other =
        contact::find_contacts({other_reference, other_box.features, other_moving}, pose, narrow_phase, {});
    ASSERT_EQ(contacts.size(), other.size());
    for (const contact::Contact& c : contacts) {
      EXPECT_TRUE(std::any_of(other.begin(), other.end(), [&](const contact::Contact& o) {
        return (c.point_mm - o.point_mm).norm() + (c.application_mm - o.application_mm).norm() +
                   (c.normal - o.normal).norm() + std::abs(c.distance_mm - o.distance_mm) <
               1e-9;
      }));
    }
    n_touching += contacts.empty() ? 0 : 1;
  }
  EXPECT_GT(n_touching, n_poses / 4);
}

}  // namespace vrda::gap_query_test
