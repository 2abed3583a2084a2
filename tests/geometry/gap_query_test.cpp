// Minimum travels: against brute force, and invariances.
#include "geometry/gap_query.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/gap_scenes.hpp"
#include "geometry/instruction_set.hpp"
#include "support/directional_gap.hpp"
#include "support/meshes.hpp"

namespace vrda::gap_query_test {

using test::GapBodies;
using test::GapRandom;

// Heights of some 30 mm, each a sum of a few products; a sliver's slope may amplify errors a hundredfold.
constexpr double rounding_mm = 1e-11;

double travel_of(const Mesh& reference, const Mesh& moving, const MovingPose& pose,
                 const Attitude& attitude = {})
{
  geometry::GapQuery query{geometry::GapTree(reference), geometry::GapTree(moving)};
  query.set_attitude(attitude);
  return query.travel_mm(pose);
}

// Infinities compare equal.
void expect_same(double a, double b, double tolerance)
{
  EXPECT_EQ(std::isfinite(a), std::isfinite(b));
  EXPECT_NEAR(std::isfinite(a) ? a : 0.0, std::isfinite(b) ? b : 0.0, tolerance);
}

TEST(GapQuery, AgreesWithEveryPairOfTrianglesWhateverTheEarlierQueries)
{
  GapRandom random(11);
  int n_finite = 0, n_infinite = 0;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    const geometry::GapTree reference(bodies.reference), moving(bodies.moving);
    geometry::GapQuery warm(reference, moving);
    for (int k = 0; k < 20; ++k) {
      const Attitude attitude = random.attitude();
      const MovingPose pose = random.pose(15, bodies.depth_mm);
      warm.set_attitude(attitude);
      const double travel = warm.travel_mm(pose);
      geometry::GapQuery cold(reference, moving);
      cold.set_attitude(attitude);
      EXPECT_EQ(travel, cold.travel_mm(pose));
      EXPECT_EQ(test::bits_of(warm.features(pose, 0.1)), test::bits_of(cold.features(pose, 0.1)));
      expect_same(travel, test::dense_gap_mm(bodies, attitude, pose), rounding_mm);
      n_finite += std::isfinite(travel) ? 1 : 0;
      n_infinite += std::isfinite(travel) ? 0 : 1;
    }
  }
  EXPECT_GT(n_finite, 60);
  EXPECT_GT(n_infinite, 5);
}

TEST(GapQuery, FarFromTheOriginTheFloatBoundsStillHold)
{
  GapRandom random(14);
  int n_finite = 0;
  for (GapBodies& bodies : test::gap_bodies(random)) {
    // The reference rotates about a distant origin; the moving object follows.
    const Eigen::RowVector3d far(40, -600, 75);
    bodies.reference.vertices_mm.rowwise() += far;
    bodies.moving.vertices_mm.rowwise() -= 2 * far;
    geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    for (int k = 0; k < 10; ++k) {
      const Attitude attitude{0.1 * random.unit(), 0.1 * random.unit()};
      MovingPose pose = random.pose(3, bodies.depth_mm - 5);
      pose.theta_rad = 0.01 * random.unit();
      pose.translation_mm +=
          reference_rotation(attitude) * far.transpose() + rotation_y(pose.theta_rad) * (2 * far).transpose();
      query.set_attitude(attitude);
      const double travel = query.travel_mm(pose);
      // Twenty times the coordinates.
      expect_same(travel, test::dense_gap_mm(bodies, attitude, pose), 20 * rounding_mm);
      n_finite += std::isfinite(travel) ? 1 : 0;
    }
  }
  EXPECT_GT(n_finite, 40);
}

TEST(GapQuery, EveryInstructionSetGivesTheSameBits)
{
  const std::vector<geometry::InstructionSet> sets = geometry::instruction_sets();
  const geometry::InstructionSet before = geometry::instruction_set();
  std::vector<std::vector<double>> answers;
  for (const geometry::InstructionSet set : sets) {
    geometry::set_instruction_set(set);
    GapRandom random(15);
    std::vector<double> all;
    for (const GapBodies& bodies : test::gap_bodies(random)) {
      geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
      for (int k = 0; k < 200; ++k) {
        query.set_attitude(random.attitude());
        const MovingPose pose = random.pose(10, bodies.depth_mm);
        const std::vector<double> bits = test::bits_of(query.features(pose, 0.2));
        all.insert(all.end(), bits.begin(), bits.end());
        all.push_back(query.next_contact(pose).travel_mm);
      }
    }
    answers.push_back(all);
  }
  geometry::set_instruction_set(before);
  EXPECT_GT(answers.front().size(), 10000U);
  for (const std::vector<double>& other : answers) EXPECT_EQ(answers.front(), other);
}

TEST(GapQuery, NumberingChangesNothing)
{
  GapRandom random(16);
  int n_finite = 0;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    geometry::GapQuery other{geometry::GapTree(random.renumbered(bodies.reference)),
                             geometry::GapTree(random.renumbered(bodies.moving))};
    for (int k = 0; k < 20; ++k) {
      const Attitude attitude = random.attitude();
      const MovingPose pose = random.pose(10, bodies.depth_mm);
      query.set_attitude(attitude);
      other.set_attitude(attitude);
      const double travel = query.travel_mm(pose);
      expect_same(travel, other.travel_mm(pose), rounding_mm);
      EXPECT_EQ(query.features(pose, 0.1).features.size(), other.features(pose, 0.1).features.size());
      n_finite += std::isfinite(travel) ? 1 : 0;
    }
  }
  EXPECT_GT(n_finite, 60);
}

TEST(GapQuery, TurningAndShiftingTheWholeSceneChangesNothing)
{
  GapRandom random(17);
  int n_finite = 0;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    for (int k = 0; k < 10; ++k) {
      const MovingPose pose = random.pose(8, bodies.depth_mm);
      const double angle = 3 * random.unit();
      const Eigen::Vector3d shift(20 * random.unit(), 20 * random.unit(), 20 * random.unit());
      Pose X = Pose::Identity();
      X.linear() = rotation_y(angle);
      X.translation() = shift;
      const MovingPose moved{X * pose.translation_mm, pose.theta_rad + angle};
      const double travel = travel_of(bodies.reference, bodies.moving, pose);
      expect_same(travel, travel_of(transformed(bodies.reference, X), bodies.moving, moved), rounding_mm);
      n_finite += std::isfinite(travel) ? 1 : 0;
    }
  }
  EXPECT_GT(n_finite, 30);
}

TEST(GapQuery, MoreTrianglesNeverGiveMoreRoom)
{
  GapRandom random(18);
  int n_less = 0, n_same = 0;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    const std::vector<std::int32_t> some = [&] {
      std::vector<std::int32_t> rows;
      for (std::int32_t t = 0; t < bodies.reference.triangles.rows(); t += 2) rows.push_back(t);
      return rows;
    }();
    geometry::GapQuery all{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    geometry::GapQuery part{geometry::GapTree(bodies.reference, some), geometry::GapTree(bodies.moving)};
    for (int k = 0; k < 20; ++k) {
      const MovingPose pose = random.pose(8, bodies.depth_mm);
      const double travel = all.travel_mm(pose), travel_of_part = part.travel_mm(pose);
      EXPECT_LE(travel, travel_of_part);
      n_less += travel < travel_of_part ? 1 : 0;
      n_same += travel == travel_of_part ? 1 : 0;
    }
  }
  EXPECT_GT(n_less, 10);
  EXPECT_GT(n_same, 10);
}

TEST(GapQuery, TravelFallsOneForOneAndGoesNegative)
{
  const Mesh upper = test::box({0, 10, 0}, {4, 4, 4}), lower = test::box({0, 0, 0}, {2, 2, 2});
  for (const double y : {-30.0, 0.0, 7.0, 7.5, 12.0}) {
    // Top of the moving box at y + 1, underside of the reference at 8.
    EXPECT_NEAR(travel_of(upper, lower, {{0.3, y, -0.2}, 0.4}), 7.0 - y, rounding_mm);
  }
}

TEST(GapQuery, TouchHasTheBitsOfThePlainWalkFromAnywhere)
{
  GapRandom random(19);
  int n_free = 0, n_infinite = 0, n_inside = 0;
  for (const GapBodies& bodies : test::gap_bodies(random)) {
    const geometry::TreeMesh reference = geometry::make_tree_mesh(bodies.reference),
                             moving = geometry::make_tree_mesh(bodies.moving);
    geometry::GapQuery query{geometry::GapTree(bodies.reference), geometry::GapTree(bodies.moving)};
    for (int k = 0; k < 60; ++k) {
      const Attitude attitude = random.attitude();
      // From well below to well above, and sideways beyond the rim.
      MovingPose pose = random.pose(14, bodies.depth_mm);
      pose.translation_mm.y() += 25 * (1 + random.unit());
      query.set_attitude(attitude);
      const geometry::Gap plain = test::directional_gap(geometry::rotated_reference(reference, attitude),
                                                        moving.mesh, moving.tree, pose);
      const geometry::Gap found = query.next_contact(pose);
      EXPECT_EQ(found.travel_mm, plain.travel_mm);
      EXPECT_EQ(found.pair, plain.pair);
      n_infinite += std::isfinite(plain.travel_mm) ? 0 : 1;
      n_inside += std::isfinite(plain.travel_mm) && query.travel_mm(pose) < 0.0 ? 1 : 0;
      n_free += std::isfinite(plain.travel_mm) && query.travel_mm(pose) >= 0.0 ? 1 : 0;
    }
  }
  EXPECT_GT(n_free, 30);
  EXPECT_GT(n_inside, 30);
  EXPECT_GT(n_infinite, 30);
}

TEST(GapQuery, NothingFacesAnEmptyTree)
{
  const Mesh ball = test::ball(5);
  const std::vector<std::int32_t> none;
  geometry::GapQuery query{geometry::GapTree(ball), geometry::GapTree(ball, none)};
  query.set_attitude({0.3, 0.1});
  EXPECT_TRUE(std::isinf(query.travel_mm({})));
  EXPECT_TRUE(query.features({}, 1.0).features.empty());
  EXPECT_TRUE(std::isinf(geometry::GapQuery(geometry::GapTree(), geometry::GapTree(ball)).travel_mm({})));
  EXPECT_TRUE(geometry::GapTree().is_empty());
  EXPECT_TRUE(geometry::GapTree(ball, none).is_empty());
  EXPECT_FALSE(geometry::GapTree(ball).is_empty());
  EXPECT_EQ(query.n_queries(), 2);
}

}  // namespace vrda::gap_query_test
