#include "solve/stability_search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/units.hpp"

namespace vrda::prediction_test {

contact::Contact contact(const Eigen::Vector3d& point, const Eigen::Vector3d& direction)
{
  return {point, point, direction.normalized(), 0.0, {}};
}

TEST(PredictRotation, ACoupleTurnsAboutItsMiddle)
{
  // Reactions along +X at z = +1 and along -X at z = -1: torque about +Y.
  const solve::RotationPrediction r =
      solve::predict_rotation({contact({0, 0, 1}, {1, -1, 0}), contact({0, 0, -1}, {-1, -1, 0})});
  EXPECT_EQ(r.sign, 1);
  EXPECT_EQ(r.centre_mm, Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(solve::predict_rotation({contact({0, 0, 1}, {-1, -1, 0}), contact({0, 0, -1}, {1, -1, 0})}).sign,
            -1);
}

TEST(PredictRotation, FewerThanTwoContactsAndParallelPushesNeverTurn)
{
  EXPECT_EQ(solve::predict_rotation({}).sign, 0);
  EXPECT_EQ(solve::predict_rotation({contact({0, 0, 1}, {1, -1, 0})}).sign, 0);
  // Both push along +X: every point qualifies, but their mean fails the verification.
  EXPECT_EQ(solve::predict_rotation({contact({0, 0, 1}, {1, -1, 0}), contact({0, 0, -1}, {1, -1, 0})}).sign,
            0);
}

TEST(PredictRotation, QualifyingPointsBecomeTheCentre)
{
  // Three forces; only about the first and the last point do the other moments agree (thesis figure 7).
  const std::vector<contact::Contact> contacts = {
      contact({0, 0, 0}, {1, -1, 0}), contact({0, 0, 3}, {1, -1, 0}), contact({1, 0, -0.5}, {0, -1, -1})};
  const solve::RotationPrediction r = solve::predict_rotation(contacts);
  EXPECT_EQ(r.sign, 1);
  EXPECT_EQ(r.centre_mm, Eigen::Vector3d(0.5, 0, -0.25));
}

TEST(PredictRotation, NormalsThroughOneAxisNeverTurn)
{
  std::vector<contact::Contact> contacts;
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(1, 0, 0.3), Eigen::Vector3d(-0.4, 0.2, 1),
                                   Eigen::Vector3d(0.1, 0, -1), Eigen::Vector3d(0.0, 1.0, 0.0)}) {
    contacts.push_back(contact(p, Eigen::Vector3d(0, -2, 0) - p));
  }
  EXPECT_EQ(solve::predict_rotation(contacts).sign, 0);
}

TEST(PredictRotation, ReactionsActWhereTheirNormalsWereTaken)
{
  // At the points on the reference they would be a couple; at their points of application they share one
  // axis.
  std::vector<contact::Contact> contacts = {contact({0, 0, 1}, {1, -1, 0}), contact({0, 0, -1}, {-1, -1, 0})};
  for (contact::Contact& c : contacts) c.application_mm = Eigen::Vector3d::Zero();
  EXPECT_EQ(solve::predict_rotation(contacts).sign, 0);
  EXPECT_EQ(solve::mean_point(contacts), Eigen::Vector3d(0, 0, 0));
}

TEST(PredictTranslation, MeansOverTheFourHalfAxesRemoveDuplicates)
{
  // Thesis figure 9: duplicates of one direction do not make the result longer.
  const contact::Contact push_x = contact({0, 0, 0}, {1, -1, 0});
  const contact::Contact push_z = contact({0, 0, 0}, {0, -1, 1});
  EXPECT_EQ(solve::predict_translation({push_x}), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(solve::predict_translation({push_x, push_x, push_x}), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(solve::predict_translation({push_x, push_z}), Eigen::Vector3d(1, 0, 1));
  EXPECT_EQ(solve::predict_translation({push_x, contact({1, 1, 1}, {-3, -1, 0})}), Eigen::Vector3d(0, 0, 0));
}

TEST(PredictTranslation, SlopesDoNotMatterAndNormalsAlongDeltaContributeNone)
{
  EXPECT_EQ(solve::predict_translation({contact({0, 0, 0}, {0.01, -1, 0})}), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(solve::predict_translation({contact({0, 0, 0}, {0, -1, 0})}), Eigen::Vector3d(0, 0, 0));
  EXPECT_EQ(solve::predict_translation({}), Eigen::Vector3d(0, 0, 0));
}

TEST(PredictRotation, ANormalThroughTheCentreForbidsTheTurn)
{
  // Two opposite forces on one line and a third beside it, all through one axis: the mean of the first two is
  // on their line, where only the third would have a moment.
  const std::vector<contact::Contact> contacts = {
      contact({1, 0, 0}, {-1, -1, 0}), contact({-2, 0, 0}, {1, -1, 0}), contact({0, 0, 1}, {0, -1, -1})};
  EXPECT_EQ(solve::predict_rotation(contacts).sign, 0);
}

TEST(PredictAscent, OneSlopeIsFollowedStraightUp)
{
  const solve::Ascent climb = solve::predict_ascent({contact({0, 0, 0}, {3, -10, 4})});
  EXPECT_NEAR(climb.rise, 0.5, 1e-15);
  EXPECT_TRUE(climb.direction.isApprox(Eigen::Vector3d(0.6, 0, 0.8), 1e-15));
}

TEST(PredictAscent, InAValleyFollowsItsFloor)
{
  // Two flanks inclined towards each other and towards +Z: the thesis's average would halve its step here.
  const solve::Ascent climb =
      solve::predict_ascent({contact({0, 0, 0}, {5, -1, 0.2}), contact({1, 0, 0}, {-3, -1, 0.2})});
  EXPECT_NEAR(climb.rise, 0.2, 1e-15);
  EXPECT_TRUE(climb.direction.isApprox(Eigen::Vector3d(0, 0, 1), 1e-14));
}

TEST(PredictAscent, BalancedReactionsHaveNoAscent)
{
  EXPECT_EQ(solve::predict_ascent({}).rise, 0.0);
  EXPECT_EQ(solve::predict_ascent({contact({0, 0, 0}, {0, -1, 0}), contact({0, 0, 0}, {1, -1, 0})}).rise,
            0.0);
  EXPECT_EQ(solve::predict_ascent({contact({0, 0, 0}, {1, -1, 0}), contact({0, 0, 0}, {-2, -1, 0})}).rise,
            0.0);
  EXPECT_EQ(solve::predict_ascent({contact({0, 0, 0}, {1, -1, 0.1}), contact({0, 0, 0}, {-1, -1, 1}),
                                   contact({0, 0, 0}, {-1, -1, -1})})
                .rise,
            0.0);
}

// No unit direction rises faster: compared with a scan of the circle.
TEST(PredictAscent, IsTheBestOfAllDirections)
{
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  int n_ways = 0, n_none = 0;
  for (int k = 0; k < 500; ++k) {
    std::vector<contact::Contact> contacts;
    for (int n = 0; n < 1 + k % 5; ++n)
      contacts.push_back(contact({0, 0, 0}, {unit(random), -0.1 - std::abs(unit(random)), unit(random)}));
    double best = 0.0;
    for (int step = 0; step < 3600; ++step) {
      const SinCos at = sin_cos(2.0 * pi * step / 3600.0);
      double rise = std::numeric_limits<double>::infinity();
      for (const contact::Contact& c : contacts)
        rise = std::min(rise, (c.normal.x() * at.cos + c.normal.z() * at.sin) / -c.normal.y());
      best = std::max(best, rise);
    }
    const solve::Ascent climb = solve::predict_ascent(contacts);
    // Slopes of up to 15 change by 0.015 between two directions of the scan, 0.1 degrees apart.
    EXPECT_NEAR(climb.rise, best, 0.015);
    EXPECT_GE(climb.rise, best - 1e-12);
    ++(climb.rise > 0.0 ? n_ways : n_none);
  }
  EXPECT_GT(n_ways, 100);
  EXPECT_GT(n_none, 100);
}

TEST(PredictAscent, ACoupleRotatesOnlyWithALever)
{
  // Moments of 3 mm per mm along Delta, forces balanced: with a lever of 6 mm one mm of motion rotates by 1/6
  // rad.
  const std::vector<contact::Contact> couple = {contact({1, 0, 3}, {1, -1, 0}),
                                                contact({1, 0, -3}, {-1, -1, 0})};
  EXPECT_EQ(solve::predict_ascent(couple).rise, 0.0);
  const solve::Ascent climb = solve::predict_ascent(couple, 6.0);
  EXPECT_NEAR(climb.rise, 0.5, 1e-15);
  EXPECT_NEAR(climb.turn_rad_per_mm, 1.0 / 6.0, 1e-15);
  EXPECT_LT(climb.direction.norm(), 1e-15);
  EXPECT_EQ(climb.centre_mm, Eigen::Vector3d(1, 0, 0));
}

// By duality: every contact allows at least the rise, and no tried motion of unit length allows more.
TEST(PredictAscent, IsTheBestOfAllMotions)
{
  constexpr double lever_mm = 2.0;
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> unit(-1, 1);
  int n_ways = 0, n_none = 0, n_crowds = 0;
  for (int k = 0; k < 600; ++k) {
    std::vector<contact::Contact> contacts;
    for (int n = 0; n < 1 + k % 12; ++n) {
      contacts.push_back(contact({3 * unit(random), 0, 3 * unit(random)},
                                 {unit(random) + 0.5, -0.1 - std::abs(unit(random)), unit(random)}));
    }
    const Eigen::Vector3d middle = solve::mean_point(contacts);
    const auto rise_of = [&](const Eigen::Vector3d& way, double turn_rad) {
      double rise = std::numeric_limits<double>::infinity();
      for (const contact::Contact& c : contacts)
        rise = std::min(rise,
                        (c.normal.dot(way) + solve::moment_about_mm(c, middle) * turn_rad) / -c.normal.y());
      return rise;
    };
    const solve::Ascent climb = solve::predict_ascent(contacts, lever_mm);
    double best = 0.0;
    for (int trial = 0; trial < 2000; ++trial) {
      const Eigen::Vector3d motion = Eigen::Vector3d(unit(random), unit(random), unit(random)).normalized();
      best = std::max(best, rise_of({motion.x(), 0.0, motion.z()}, motion.y() / lever_mm));
    }
    // The nearest-point search is accurate to a share of 1e-7.
    EXPECT_LE(best, climb.rise + 1e-6);
    EXPECT_GE(rise_of(climb.direction, climb.turn_rad_per_mm), climb.rise - 1e-6);
    ++(climb.rise > 0.0 ? n_ways : n_none);
    n_crowds += climb.rise > 0.0 && contacts.size() > 4 ? 1 : 0;
  }
  EXPECT_GT(n_ways, 150);
  EXPECT_GT(n_none, 150);
  EXPECT_GT(n_crowds, 50);
}

// Contacts whose slopes in x, moment and z are the given ones. Each acts on its line of action; points are
// moved along these lines until their mean, the centre of rotation, is the origin.
std::vector<contact::Contact> contacts_of_slopes(const std::vector<Eigen::Vector3d>& slopes, double lever_mm)
{
  std::vector<contact::Contact> contacts;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread = Eigen::Vector3d::UnitY().asDiagonal();
  for (const Eigen::Vector3d& slope : slopes) {
    const Eigen::Vector3d along(slope.x(), 0, slope.z());
    contacts.push_back(
        contact(slope.y() * lever_mm * along.cross(Eigen::Vector3d::UnitY()) / along.squaredNorm(),
                {slope.x(), -1, slope.z()}));
    sum += contacts.back().application_mm;
    spread += along * along.transpose();
  }
  const Eigen::Vector3d shift = spread.inverse() * sum;
  for (std::size_t k = 0; k < slopes.size(); ++k) {
    const Eigen::Vector3d along(slopes[k].x(), 0, slopes[k].z());
    contacts[k].application_mm -= along * along.dot(shift);
  }
  return contacts;
}

// The corners in a plane near the origin surround its foot and no slope is below the plane, so the rise is
// the plane's distance. The last corner brings the estimate nearer by less than a squared distance's
// rounding.
TEST(PredictAscent, FindsASmallRiseAmongSteepSlopes)
{
  constexpr double lever_mm = 2.0;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int k = 0; k < 20000; ++k) {
    const Eigen::Vector3d normal = Eigen::Vector3d(unit(random), unit(random), unit(random)).normalized();
    const Eigen::Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
    const double distance = std::pow(10.0, -3.0 + unit(random)), turned = unit(random);
    std::vector<Eigen::Vector3d> slopes;
    for (int corner = 0; corner < 3; ++corner) {
      const SinCos at = sin_cos(2.0 * pi * corner / 3.0 + turned);
      slopes.push_back(distance * normal + (0.6 + 0.5 * unit(random)) * (at.cos * u + at.sin * v));
    }
    for (int n = 0; n < k % 8; ++n)
      slopes.push_back((distance + std::pow(10.0, -9.0 + unit(random))) * normal + unit(random) * u +
                       unit(random) * v);
    std::shuffle(slopes.begin(), slopes.end(), random);
    EXPECT_NEAR(solve::predict_ascent(contacts_of_slopes(slopes, lever_mm), lever_mm).rise, distance, 1e-9);
  }
}

}  // namespace vrda::prediction_test
