// Distances and closest points by Bullet compared with the closed forms, on all pairs of triangles near
// contact.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>

#include "contact/contacts.hpp"
#include "contact/scenes.hpp"
#include "contact/triangle_closed_forms.hpp"
#include "support/real_knees.hpp"

namespace vrda::closest_points_test {

constexpr double band_mm = 0.2;
constexpr double agreed_mm = 1e-6;
constexpr int n_attitudes = 25;
constexpr int n_touches_an_attitude = 2;

// How far a point is from a triangle's plane and beyond its edges.
double off_triangle_mm(const geometry::Corners& t, const Eigen::Vector3d& p)
{
  const Eigen::Vector3d n = (t[1] - t[0]).cross(t[2] - t[0]).normalized();
  double most = std::abs(n.dot(p - t[0]));
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d along = (t[(k + 1) % 3] - t[k]).normalized();
    most = std::max(most, -n.dot(along.cross(p - t[k])));
  }
  return most;
}

struct Tally {
  int n_pairs = 0;
  int n_near = 0;  // within 1e-3 mm, where the moving triangle is backed off
  int n_overlapping = 0;
  int n_same_points = 0;
  double largest_error_mm = 0.0;
};

void compare(const geometry::Corners& r, const geometry::Corners& m, contact::NarrowPhase& narrow_phase,
             Tally& tally)
{
  const double separation_mm = test::separation_mm(r, m);
  const contact::TriangleDistance found = narrow_phase.measure(r, m);
  EXPECT_EQ(narrow_phase.overlap(r, m), found.is_overlapping);
  if (found.is_overlapping || separation_mm <= 0.0) {
    EXPECT_TRUE(found.is_overlapping == (separation_mm <= 0.0) || std::abs(separation_mm) < 1e-9)
        << separation_mm;
    ++tally.n_overlapping;
    return;
  }
  const test::ClosestPoints expected = test::closest_points(r, m);
  tally.largest_error_mm =
      std::max(tally.largest_error_mm, std::abs(found.distance_mm - expected.distance_mm));
  // Two points on the triangles at the smallest distance are closest points, unique or not.
  EXPECT_LT(off_triangle_mm(r, found.p_reference_mm), agreed_mm);
  EXPECT_LT(off_triangle_mm(m, found.p_moving_mm), agreed_mm);
  EXPECT_NEAR((found.p_moving_mm - found.p_reference_mm).norm(), expected.distance_mm, agreed_mm);
  const bool same = (found.p_reference_mm - expected.p_reference_mm).norm() < agreed_mm &&
                    (found.p_moving_mm - expected.p_moving_mm).norm() < agreed_mm;
  ++tally.n_pairs;
  tally.n_near += expected.distance_mm < 1e-3 ? 1 : 0;
  tally.n_same_points += same ? 1 : 0;
}

Tally compared(const std::string& scene, unsigned seed)
{
  const test::TwoObjects objects = test::two_objects(scene);
  std::mt19937_64 random(seed);
  contact::NarrowPhase narrow_phase;
  Tally tally;
  for (int k = 0; k < n_attitudes; ++k) {
    const test::TestAttitude sample = test::random_attitude(objects, n_touches_an_attitude, random);
    for (const auto& [pose, zone] : sample.poses) {
      const geometry::Placement place(pose);
      if (zone == test::Zone::deep || zone == test::Zone::anywhere) continue;
      geometry::visit_close_pairs(
          sample.reference.tree, objects.moving.tree, place, band_mm,
          [&](const geometry::TrianglePair& pair) {
            const geometry::Corners r = corners(sample.reference.mesh, pair.reference),
                                    m = place(corners(objects.moving.mesh, pair.moving));
            if (!contact::is_certainly_separated(r, m, band_mm)) compare(r, m, narrow_phase, tally);
            return false;
          });
    }
  }
  return tally;
}

void expect_agreement(const std::string& scene, unsigned seed)
{
  const Tally tally = compared(scene, seed);
  std::cout << scene << ": " << tally.n_pairs << " pairs, " << tally.n_near << " within 1e-3 mm, "
            << tally.n_overlapping << " overlapping; largest error " << tally.largest_error_mm
            << " mm; points equal for " << tally.n_same_points << '\n';
  EXPECT_GT(tally.n_pairs, 500);
  EXPECT_GT(tally.n_near, 50);
  EXPECT_LT(tally.largest_error_mm, agreed_mm);
}

class RealKneePairs : public testing::TestWithParam<std::string> {};

TEST(ClosestPairs, OfTheGenericKneeAreThoseOfTheClosedForms)
{
  expect_agreement("GenericKnee", 601);
}

TEST_P(RealKneePairs, AreThoseOfTheClosedForms)
{
  VRDA_REQUIRE_REAL_KNEES();
  expect_agreement(GetParam(), 602);
}

INSTANTIATE_TEST_SUITE_P(Oracle, RealKneePairs, testing::ValuesIn(test::real_knee_scenes()),
                         [](const auto& scene) {
                           std::string name = scene.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace vrda::closest_points_test
