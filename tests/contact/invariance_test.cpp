// Invariance of the result: exchange of the objects, numbering of triangles and vertices.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "contact/contacts.hpp"
#include "support/directional_gap.hpp"
#include "support/meshes.hpp"

namespace vrda::invariance_test {

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

}  // namespace vrda::invariance_test
