#include "motion/smoothed_surfaces.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/units.hpp"
#include "motion/support/models.hpp"

namespace vrda::smoothed_surfaces_test {

constexpr double rounding = 1e-13;  // a handful of operations on numbers near one

TEST(SmoothedSurfaces, AgreeWithTheLegendrePolynomialsWrittenOut)
{
  MotionModel model = test::model_of({});
  // x = P_3(u), y = P_2(u) P_1(v), z = P_0, theta = 10 degrees P_2(v)
  test::add_smoothed(model, 3, [](int i, int j) {
    return PoseNumbers{i == 3 && j == 0 ? 1.0 : 0.0, i == 2 && j == 1 ? 1.0 : 0.0, i + j == 0 ? 1.0 : 0.0,
                       i == 0 && j == 2 ? 10.0 : 0.0};
  });
  const SmoothedSurfaces surfaces = smoothed_surfaces(model, model.smoothed.front());
  for (const double flexion_deg : {0.0, 7.0, 45.0, 81.5, 90.0}) {
    for (const double varus_deg : {-4.0, -1.5, 0.0, 4.0}) {
      const PoseAndVarus found = evaluate(surfaces, {rad_from_deg(flexion_deg), rad_from_deg(varus_deg)});
      const double u = flexion_deg / 45.0 - 1.0, v = varus_deg / 4.0;
      EXPECT_NEAR(found[0], 0.5 * (5.0 * u * u * u - 3.0 * u), rounding);
      EXPECT_NEAR(found[1], 0.5 * (3.0 * u * u - 1.0) * v, rounding);
      EXPECT_NEAR(found[2], 1.0, rounding);
      EXPECT_NEAR(found[3], rad_from_deg(10.0) * 0.5 * (3.0 * v * v - 1.0), rounding);
    }
  }
}

TEST(SmoothedSurfaces, EveryPolynomialIsOneAtTheUpperEndAndAlternatesAtTheLower)
{
  // P_n(1) = 1 and P_n(-1) = (-1)^n, up to the highest degree there is.
  MotionModel model = test::model_of({});
  test::add_smoothed(model, largest_smoothed_degree, [](int i, int j) {
    return PoseNumbers{j == 0 ? i + 1.0 : 0.0, 0.0, 0.0, 0.0};
  });
  const SmoothedSurfaces surfaces = smoothed_surfaces(model, model.smoothed.front());
  double sum = 0.0, alternating = 0.0;
  for (int i = 0; i <= largest_smoothed_degree; ++i) {
    sum += i + 1.0;
    alternating += (i % 2 == 0 ? 1.0 : -1.0) * (i + 1.0);
  }
  EXPECT_NEAR(evaluate(surfaces, {rad_from_deg(90.0), 0.0})[0], sum, 1e-11);
  EXPECT_NEAR(evaluate(surfaces, {0.0, 0.0})[0], alternating, 1e-11);
}

TEST(SmoothedSurfaces, AgreeWithTheEvaluationOfTheStore)
{
  MotionModel model = test::model_of({});
  test::add_smoothed(model, 6, [](int i, int j) {
    return PoseNumbers{1.0 / (i + 1), 0.5 - j, 0.1 * i * j, 2.0 + i};
  });
  const SmoothedSet& set = model.smoothed.front();
  const SmoothedSurfaces surfaces = smoothed_surfaces(model, set);
  const AxisRanges ranges = axis_ranges(model.flexion_deg, model.varus_deg);
  for (const double flexion_deg : {3.0, 50.0, 88.0}) {
    const PoseAndVarus found = evaluate(surfaces, {rad_from_deg(flexion_deg), rad_from_deg(-3.0)});
    for (std::size_t number = 0; number < 4; ++number) {
      const double expected = evaluate(set, set.surfaces[number], ranges, flexion_deg, -3.0).value;
      EXPECT_NEAR(found[number], number == 3 ? rad_from_deg(expected) : expected, 28 * rounding);
    }
  }
}

TEST(SmoothedSurfaces, AMisshapenSetIsABrokenPromise)
{
  MotionModel model = test::model_of({});
  test::add_smoothed(model, 2, [](int, int) { return PoseNumbers{}; });
  SmoothedSet nameless = model.smoothed.front();
  nameless.surfaces[1].name = "t";
  EXPECT_THROW(smoothed_surfaces(model, nameless), InternalError);
  SmoothedSet cut = model.smoothed.front();
  cut.surfaces[2].coefficients.pop_back();
  EXPECT_THROW(smoothed_surfaces(model, cut), InternalError);
  SmoothedSet wild = model.smoothed.front();
  wild.exponents(1, 1) = largest_smoothed_degree + 1;
  EXPECT_THROW(smoothed_surfaces(model, wild), InternalError);
}

}  // namespace vrda::smoothed_surfaces_test
