#include "core/units.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace vrda::trig_test {

// One unit in the last place of a result near 1, doubled for the reference's own rounding.
constexpr double two_ulp = 4.5e-16;

TEST(Trig, sine_and_cosine)
{
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> angle(-50.0, 50.0);
  for (int k = 0; k < 200000; ++k) {
    const double x = angle(random);
    EXPECT_NEAR(sine(x), std::sin(x), two_ulp);
    EXPECT_NEAR(cosine(x), std::cos(x), two_ulp);
  }
}

TEST(Trig, arcs)
{
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> side(-3.0, 3.0);
  for (int k = 0; k < 200000; ++k) {
    const double x = side(random), y = side(random);
    EXPECT_NEAR(arc_tangent2(y, x), std::atan2(y, x), 2 * two_ulp);
    EXPECT_NEAR(arc_sine(x / 3.0), std::asin(x / 3.0), two_ulp);
    EXPECT_NEAR(arc_cosine(x / 3.0), std::acos(x / 3.0), 2 * two_ulp);
  }
}

TEST(Trig, axes_and_signs)
{
  EXPECT_EQ(sine(0.0), 0.0);
  EXPECT_EQ(cosine(0.0), 1.0);
  EXPECT_EQ(arc_tangent2(0.0, 1.0), 0.0);
  EXPECT_EQ(arc_tangent2(0.0, -1.0), std::acos(-1.0));
  EXPECT_EQ(arc_tangent2(1.0, 0.0), std::acos(0.0));
  EXPECT_EQ(arc_tangent2(-1.0, 0.0), -std::acos(0.0));
  EXPECT_EQ(arc_sine(1.0), std::acos(0.0));
  for (const double x : {0.1, 1.0, 2.0, 40.0}) {
    EXPECT_EQ(sine(-x), -sine(x));
    EXPECT_EQ(cosine(-x), cosine(x));
    EXPECT_EQ(arc_tangent2(-x, 0.7), -arc_tangent2(x, 0.7));
  }
}

TEST(Trig, OfNaNAndInfinityAreNaN)
{
  EXPECT_TRUE(std::isnan(sine(std::numeric_limits<double>::quiet_NaN())));
  EXPECT_TRUE(std::isnan(cosine(std::numeric_limits<double>::infinity())));
}

}  // namespace vrda::trig_test
