#include "store/motion.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/text.hpp"

namespace vrda::evaluate_smoothed_test {

/// A dozen operations on numbers near 1.
constexpr double rounding = 1e-14;

TEST(Legendre, MatchesTheClosedForms)
{
  for (const double u : {-1.0, -0.3, 0.0, 0.5, 1.0, 1.1}) {
    SCOPED_TRACE(u);
    const store::LegendreTable P = store::legendre(u, 4);
    EXPECT_EQ(P.value[0], 1.0);
    EXPECT_EQ(P.value[1], u);
    EXPECT_NEAR(P.value[2], (3 * u * u - 1) / 2, rounding);
    EXPECT_NEAR(P.value[3], (5 * u * u * u - 3 * u) / 2, rounding);
    EXPECT_NEAR(P.value[4], (35 * u * u * u * u - 30 * u * u + 3) / 8, rounding);
  }
}

TEST(Legendre, IsOneAtOneForEveryDegree)
{
  const store::LegendreTable P = store::legendre(1.0, store::max_smoothed_degree);
  for (int n = 0; n <= store::max_smoothed_degree; ++n) EXPECT_NEAR(P.value[n], 1.0, rounding);
  EXPECT_THROW(store::legendre(0.0, store::max_smoothed_degree + 1), InternalError);
  EXPECT_THROW(store::legendre(0.0, -1), InternalError);
}

TEST(UnitCoordinate, MapsTheEndsExactly)
{
  const store::AxisRange range{0.1, 120.3};
  EXPECT_EQ(store::unit_coordinate(0.1, range), -1.0);
  EXPECT_EQ(store::unit_coordinate(120.3, range), 1.0);
  EXPECT_NEAR(store::unit_coordinate(60.2, range), 0.0, rounding);
  EXPECT_EQ(store::unit_coordinate(17.0, {30.0, 30.0}), 0.0);
}

store::SmoothedSet quadratic_set()
{
  store::SmoothedSet set;
  set.degree = 2;
  set.exponents.resize(6, 2);
  set.exponents << 0, 0, 1, 0, 0, 1, 2, 0, 1, 1, 0, 2;
  set.surfaces.resize(1);
  set.surfaces[0].coefficients = {1.0, 2.0, -3.0, 0.5, 0.25, -0.75};
  return set;
}

TEST(EvaluateSmoothed, ClosedForm)
{
  const store::SmoothedSet set = quadratic_set();
  const store::AxisRanges ranges{{0.0, 90.0}, {-10.0, 10.0}};
  for (const double flexion_deg : {0.0, 12.5, 45.0, 90.0, 95.0}) {
    for (const double varus_deg : {-10.0, 0.0, 3.0, 10.0}) {
      const double u = flexion_deg / 45.0 - 1.0, v = varus_deg / 10.0;
      EXPECT_NEAR(store::evaluate(set, set.surfaces[0], ranges, flexion_deg, varus_deg),
                  1.0 + 2.0 * u - 3.0 * v + 0.25 * (3 * u * u - 1) + 0.25 * u * v - 0.375 * (3 * v * v - 1),
                  10 * rounding);
    }
  }
}

// Its polynomials are those at 0.
TEST(EvaluateSmoothed, OneValue)
{
  const store::SmoothedSet set = quadratic_set();
  const store::AxisRanges ranges{{0.0, 90.0}, {0.0, 0.0}};
  EXPECT_NEAR(store::evaluate(set, set.surfaces[0], ranges, 45.0, 7.0), 1.0 - 0.25 + 0.375, rounding);
  EXPECT_THROW(store::axis_ranges({}, {0.0}), InternalError);
}

}  // namespace vrda::evaluate_smoothed_test
