// Clinical curves beyond the ranges of one pose's numbers.
#include "model/coordinates.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"

namespace vrda::clinical_test {

constexpr double rounding = 1e-12;
// An angle whose sine is 1 within rounding is known to the root of it.
constexpr double near_lock = 1e-7;

TEST(Unwrapped, within_half_a_turn)
{
  const std::vector<double> turned = unwrapped({3.0, -3.0, nan, -2.5, 3.1});
  EXPECT_EQ(turned[0], 3.0);
  EXPECT_NEAR(turned[1], 2 * pi - 3.0, rounding);
  EXPECT_TRUE(std::isnan(turned[2]));
  EXPECT_NEAR(turned[3], 2 * pi - 2.5, rounding);
  EXPECT_NEAR(turned[4], 3.1, rounding);
  EXPECT_NEAR(unwrapped({179.0, -179.0}, 360.0)[1], 181.0, rounding);
  EXPECT_EQ(nearest_turn(0.2, 0.1), 0.2);  // the same bits
}

/// The pose of these numbers, of a right joint or of its mirror image.
Pose posed(double flexion_deg, double varus_deg, double internal_deg, Side side)
{
  const double other = side == Side::left ? -1.0 : 1.0;
  Pose X = Pose::Identity();
  X.linear() = rotation_z(-rad_from_deg(flexion_deg)) * rotation_x(other * rad_from_deg(varus_deg)) *
               rotation_y(other * rad_from_deg(internal_deg));
  X.translation() = Eigen::Vector3d(3.0, -2.0, other * 5.0);
  return X;
}

// Closed form: numbers that grow steadily come back, past half a turn, a whole one and gimbal lock.
TEST(ContinuousCoordinates, past_branches)
{
  struct Row {
    double first[3], step[3];  // flexion, varus, internal
    int n_locked;
  };
  for (const Row& row : {Row{{10, 1, 174.05}, {1, 0, 1}, 0}, Row{{-175, 2, -170}, {-3, 0, -30}, 0},
                         Row{{10, 85, 5}, {0, 1, 0}, 16}, Row{{10, -85, 5}, {1, -1, 1}, 16},
                         Row{{10, 1, 5}, {7, 0.1, 3}, 0}}) {
    for (const Side side : {Side::right, Side::left}) {
      SCOPED_TRACE(row.first[1]);
      ContinuousCoordinates along(side, Eigen::Vector3d::Zero());
      for (int k = 0; k <= 20; ++k) {
        const double f = row.first[0] + k * row.step[0], v = row.first[1] + k * row.step[1],
                     i = row.first[2] + k * row.step[2];
        const Pose X = posed(f, v, i, side);
        const ClinicalCoordinates c = along.next(X);
        EXPECT_NEAR(c.flexion_rad, rad_from_deg(f), near_lock) << k;
        EXPECT_NEAR(c.varus_rad, rad_from_deg(v), near_lock) << k;
        EXPECT_NEAR(c.internal_rotation_rad, rad_from_deg(i), near_lock) << k;
        // Along the floating axis (cos f, -sin f, 0), without a jump.
        EXPECT_NEAR(c.anterior_mm, 3.0 * std::cos(rad_from_deg(f)) + 2.0 * std::sin(rad_from_deg(f)), 1e-6);
      }
      EXPECT_EQ(along.n_locked(), row.n_locked);
    }
  }
}

TEST(ContinuousCoordinates, bits_of_one_pose)
{
  const Pose X = posed(30, 4, -10, Side::left);
  ContinuousCoordinates along(Side::left, {1, 2, 3});
  along.next(posed(20, 3, -8, Side::left));
  const ClinicalCoordinates found = along.next(X), one = clinical_coordinates(X, Side::left, {1, 2, 3});
  EXPECT_EQ(found.flexion_rad, one.flexion_rad);
  EXPECT_EQ(found.varus_rad, one.varus_rad);
  EXPECT_EQ(found.internal_rotation_rad, one.internal_rotation_rad);
  EXPECT_EQ(found.anterior_mm, one.anterior_mm);
}

}  // namespace vrda::clinical_test
