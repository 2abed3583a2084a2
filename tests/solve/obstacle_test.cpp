#include "solve/obstacle.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "solve/pins.hpp"
#include "support/meshes.hpp"

namespace vrda::obstacle_test {

// Central differences of 1e-5: travels of 10 mm carry 1e-15 of rounding each, second differences of a sine
// 1e-10 of itself.
constexpr double h = 1e-5;
constexpr double of_differences = 1e-7;

struct Scene {
  Mesh reference = test::ball(30, 7, 13);
  Mesh moving = test::ball(12, 6, 11);
  Grip grip{{3, 0, -2}, 15};
  double flexion_rad = 0.3;
};

// Features of a small ball under a large one, with everything turned a little.
std::vector<GapFeature> features_at(const Scene& scene, const Place& place)
{
  const GapTree reference(scene.reference), moving(scene.moving);
  GapQuery query(reference, moving);
  query.set_attitude({scene.flexion_rad, place.varus_rad});
  return query.features(pose_at(place, scene.grip), 3.0).features;
}

Place random_place(std::mt19937_64& random)
{
  std::uniform_real_distribution<double> unit(-1, 1);
  return {{15 * unit(random), -45, 15 * unit(random)}, unit(random), 0.3 * unit(random)};
}

Place nudged(Place place, Eigen::Index coordinate, double by)
{
  if (coordinate < 3) place.pivot_mm(coordinate) += by;
  if (coordinate == about_y) place.theta_rad += by;
  if (coordinate == about_varus) place.varus_rad += by;
  return place;
}

Clearance clearance_at(const Scene& scene, const Obstacle& o, const Place& place)
{
  return clearance(o, place, Rotations(place, scene.flexion_rad));
}

TEST(Obstacle, IsTheFeatureItWasMadeOf)
{
  const Scene scene;
  std::mt19937_64 random(1);
  std::map<Obstacle::Kind, int> n;
  for (int k = 0; k < 60; ++k) {
    const Place place = random_place(random);
    const Rotations rotations(place, scene.flexion_rad);
    for (const GapFeature& f : features_at(scene, place)) {
      const Obstacle o = obstacle_of(f, {scene.reference, scene.moving, scene.grip}, place, rotations);
      const Clearance c = clearance(o, place, rotations);
      EXPECT_NEAR(c.travel_mm, f.travel_mm, 1e-9);
      EXPECT_LT((c.gradient.head<3>().normalized() - f.normal).norm(), 1e-6);
      ++n[o.kind];
    }
  }
  for (const auto kind :
       {Obstacle::Kind::face_of_reference, Obstacle::Kind::face_of_moving, Obstacle::Kind::edges})
    EXPECT_GT(n[kind], 20);
}

TEST(Obstacle, DerivativesMatchDifferences)
{
  const Scene scene;
  std::mt19937_64 random(2);
  for (int k = 0; k < 40; ++k) {
    const Place place = random_place(random);
    const Rotations rotations(place, scene.flexion_rad);
    for (const GapFeature& f : features_at(scene, place)) {
      const Obstacle o = obstacle_of(f, {scene.reference, scene.moving, scene.grip}, place, rotations);
      const Clearance c = clearance(o, place, rotations);
      // Second derivatives are those of a pose where it touches.
      const Place touching = nudged(place, along_y, c.travel_mm);
      const Matrix5d bend = clearance_bend(o, Rotations(touching, scene.flexion_rad));
      for (Eigen::Index i = 0; i < n_coordinates; ++i) {
        const auto at = [&](const Place& p, double by) { return clearance_at(scene, o, nudged(p, i, by)); };
        const double scale = 1.0 + c.gradient.norm() * c.gradient.norm();
        EXPECT_NEAR((at(place, h).travel_mm - at(place, -h).travel_mm) / (2 * h), c.gradient(i),
                    of_differences * scale * 40);
        const Vector5d change = (at(touching, h).gradient - at(touching, -h).gradient) / (2 * h);
        EXPECT_LT((change - bend.col(i)).norm(), of_differences * scale * (40 + bend.norm()));
      }
    }
  }
}

TEST(Obstacle, AFeatureStaysExactWhereItsFaceIs)
{
  // A vertex under a large flat face: its travel after any motion is the gap query's.
  Scene scene;
  scene.reference = test::box({0, 20, 0}, {200, 10, 200});
  scene.moving = test::pin({5, 2, -3});
  std::mt19937_64 random(3);
  const Place place = random_place(random);
  const GapFeature f = features_at(scene, place).front();
  const Obstacle o =
      obstacle_of(f, {scene.reference, scene.moving, scene.grip}, place, Rotations(place, scene.flexion_rad));
  for (int k = 0; k < 50; ++k) {
    Place other = random_place(random);
    other.varus_rad = place.varus_rad + 0.02 * other.varus_rad;
    const std::vector<GapFeature> now = features_at(scene, other);
    ASSERT_FALSE(now.empty());
    EXPECT_NEAR(clearance_at(scene, o, other).travel_mm, now.front().travel_mm, 1e-9);
  }
}

TEST(Obstacle, AnUprightOneNeverTouches)
{
  Obstacle o;
  o.reference_mm = Eigen::Vector3d(0, 1, 0);
  o.moving_mm = Eigen::Vector3d::Zero();
  o.reference_direction = Eigen::Vector3d::UnitX();
  o.moving_direction = Eigen::Vector3d::UnitY();
  EXPECT_TRUE(std::isinf(clearance(o, {}, Rotations({}, 0.0)).travel_mm));
  EXPECT_EQ(clearance_bend(o, Rotations({}, 0.0)).norm(), 0.0);
}

}  // namespace vrda::obstacle_test
