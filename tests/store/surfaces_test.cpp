#include "store/motion.hpp"

#include <gtest/gtest.h>

#include "core/text.hpp"
#include "core/units.hpp"
#include "support/models.hpp"

namespace vrda::surfaces_test {

using test::model_of;
using test::ModelPlan;

// Rounding of a dozen products and sums of numbers up to a hundred.
constexpr double rounding = 1e-12;

Attitude attitude_deg(double flexion_deg, double varus_deg)
{
  return {rad_from_deg(flexion_deg), rad_from_deg(varus_deg)};
}

/// Degree two in each angle with all product terms.
store::PoseCoordinates biquadratic(double flexion_deg, double varus_deg)
{
  const double u = flexion_deg / 90.0, v = varus_deg / 4.0;
  return {1.0 + u + v + u * v, -20.0 + 3.0 * u * u - v * v, u * u * v * v - 2.0 * u * v * v,
          15.0 * u - 4.0 * u * u * v};
}

/// Not a polynomial, so that nothing is exact by accident.
store::PoseCoordinates wavy(double flexion_deg, double varus_deg)
{
  const double u = rad_from_deg(flexion_deg), v = rad_from_deg(varus_deg);
  return {sine(2.0 * u + v), cosine(u - 7.0 * v), sine(u * v), 20.0 * cosine(3.0 * u)};
}

TEST(RawSurfaces, GridValuesAreReproducedToTheLastBit)
{
  ModelPlan plan;
  plan.motion = wavy;
  const store::MotionModel model = model_of(plan);
  const store::RawSurfaces surfaces = store::raw_surfaces(model);
  for (const double flexion_deg : plan.flexion_deg) {
    for (const double varus_deg : plan.varus_deg) {
      const store::RawSample found = store::sample(surfaces, attitude_deg(flexion_deg, varus_deg));
      const store::PoseCoordinates expected = wavy(flexion_deg, varus_deg);
      ASSERT_TRUE(found.is_solved);
      for (std::size_t number = 0; number < 3; ++number) EXPECT_EQ(found.values[number], expected[number]);
      EXPECT_EQ(found.values[3], rad_from_deg(expected[3]));
    }
  }
}

TEST(RawSurfaces, SurfacesOfDegreeTwoInEachAngleAreReproducedBetweenTheCells)
{
  ModelPlan plan;
  plan.flexion_deg = {0, 10, 25, 30, 52, 90};  // uneven steps
  plan.varus_deg = {-4, -1, 0.5, 4};
  plan.motion = biquadratic;
  const store::RawSurfaces surfaces = store::raw_surfaces(model_of(plan));
  for (double flexion_deg = 0.0; flexion_deg <= 90.0; flexion_deg += 3.7) {
    for (double varus_deg = -4.0; varus_deg <= 4.0; varus_deg += 0.61) {
      const store::RawSample found = store::sample(surfaces, attitude_deg(flexion_deg, varus_deg));
      const store::PoseCoordinates expected = biquadratic(flexion_deg, varus_deg);
      ASSERT_TRUE(found.is_solved);
      for (std::size_t number = 0; number < 3; ++number) {
        EXPECT_NEAR(found.values[number], expected[number], rounding);
      }
      EXPECT_NEAR(found.values[3], rad_from_deg(expected[3]), rounding);
    }
  }
}

TEST(RawSurfaces, SlopesAreContinuousAcrossCells)
{
  ModelPlan plan;
  plan.motion = wavy;
  const store::RawSurfaces surfaces = store::raw_surfaces(model_of(plan));
  constexpr double step_rad = 1e-6;
  // Difference quotients err by half the second derivative (below 100) times the step, twice.
  constexpr double tolerance = 100.0 * step_rad;
  for (const double varus_deg : {-3.0, -2.0, 1.3}) {
    const Attitude node = attitude_deg(45, varus_deg);
    const store::PoseCoordinates here = store::sample(surfaces, node).values;
    const store::PoseCoordinates before =
        store::sample(surfaces, {node.flexion_rad - step_rad, node.varus_rad}).values;
    const store::PoseCoordinates after =
        store::sample(surfaces, {node.flexion_rad + step_rad, node.varus_rad}).values;
    for (std::size_t number = 0; number < 4; ++number) {
      EXPECT_NEAR((here[number] - before[number]) / step_rad, (after[number] - here[number]) / step_rad,
                  tolerance);
    }
  }
}

TEST(RawSurfaces, AttitudesBesideAnUnsolvedCellHaveNoAnswerAndOthersStayExact)
{
  ModelPlan plan;
  plan.varus_deg = {-6, -4, -2, 0, 2, 4, 6};  // enough columns for a parabola on each side of the hole
  plan.motion = biquadratic;
  store::MotionModel model = model_of(plan);
  test::unsolve(model, 3, 3);  // 45 degrees, varus 0
  const store::RawSurfaces surfaces = store::raw_surfaces(model);
  for (const Attitude& beside :
       {attitude_deg(45, 0), attitude_deg(40, 0), attitude_deg(50, 1), attitude_deg(31, -1)}) {
    EXPECT_FALSE(store::sample(surfaces, beside).is_solved);
  }
  // On the far edges of the patches around the hole, and in the patches next to those.
  for (const Attitude& away :
       {attitude_deg(30, 0), attitude_deg(30, 1), attitude_deg(60, 0), attitude_deg(45, 2),
        attitude_deg(45, -2), attitude_deg(20, 0), attitude_deg(70, 1), attitude_deg(50, 3)}) {
    const store::RawSample found = store::sample(surfaces, away);
    ASSERT_TRUE(found.is_solved) << away.flexion_rad << " " << away.varus_rad;
    const store::PoseCoordinates expected =
        biquadratic(deg_from_rad(away.flexion_rad), deg_from_rad(away.varus_rad));
    for (std::size_t number = 0; number < 3; ++number)
      EXPECT_NEAR(found.values[number], expected[number], rounding);
  }
}

TEST(RawSurfaces, ANodeMissedByRoundingNeedsNoneOfItsNeighbours)
{
  ModelPlan plan;
  plan.motion = biquadratic;
  store::MotionModel model = model_of(plan);
  test::unsolve(model, 2, 2);
  test::unsolve(model, 4, 2);
  const store::RawSurfaces surfaces = store::raw_surfaces(model);
  for (const double off_rad : {-1e-15, 1e-15}) {
    const store::RawSample found = store::sample(surfaces, {rad_from_deg(45) + off_rad, off_rad});
    EXPECT_TRUE(found.is_solved);
    EXPECT_EQ(found.values[1], model.ty_mm(3, 2));
  }
}

constexpr double few_operations = 1e-13;  // a handful of operations on numbers near one

TEST(SmoothedSurfaces, AgreeWithTheLegendrePolynomialsWrittenOut)
{
  store::MotionModel model = test::model_of({});
  // x = P_3(u), y = P_2(u) P_1(v), z = P_0, theta = 10 degrees P_2(v)
  test::add_smoothed(model, 3, [](int i, int j) {
    return store::PoseCoordinates{i == 3 && j == 0 ? 1.0 : 0.0, i == 2 && j == 1 ? 1.0 : 0.0,
                                  i + j == 0 ? 1.0 : 0.0, i == 0 && j == 2 ? 10.0 : 0.0};
  });
  const store::SmoothedSurfaces surfaces = store::smoothed_surfaces(model, model.smoothed.front());
  for (const double flexion_deg : {0.0, 7.0, 45.0, 81.5, 90.0}) {
    for (const double varus_deg : {-4.0, -1.5, 0.0, 4.0}) {
      const store::PoseAndVarus found =
          store::evaluate(surfaces, {rad_from_deg(flexion_deg), rad_from_deg(varus_deg)});
      const double u = flexion_deg / 45.0 - 1.0, v = varus_deg / 4.0;
      EXPECT_NEAR(found[0], 0.5 * (5.0 * u * u * u - 3.0 * u), few_operations);
      EXPECT_NEAR(found[1], 0.5 * (3.0 * u * u - 1.0) * v, few_operations);
      EXPECT_NEAR(found[2], 1.0, few_operations);
      EXPECT_NEAR(found[3], rad_from_deg(10.0) * 0.5 * (3.0 * v * v - 1.0), few_operations);
    }
  }
}

TEST(SmoothedSurfaces, AgreeWithTheEvaluationOfTheStore)
{
  store::MotionModel model = test::model_of({});
  test::add_smoothed(model, 6, [](int i, int j) {
    return store::PoseCoordinates{1.0 / (i + 1), 0.5 - j, 0.1 * i * j, 2.0 + i};
  });
  const store::SmoothedSet& set = model.smoothed.front();
  const store::SmoothedSurfaces surfaces = store::smoothed_surfaces(model, set);
  const store::AxisRanges ranges = store::axis_ranges(model.flexion_deg, model.varus_deg);
  for (const double flexion_deg : {3.0, 50.0, 88.0}) {
    const store::PoseAndVarus found =
        store::evaluate(surfaces, {rad_from_deg(flexion_deg), rad_from_deg(-3.0)});
    for (std::size_t number = 0; number < 4; ++number) {
      const double expected = store::evaluate(set, set.surfaces[number], ranges, flexion_deg, -3.0);
      EXPECT_NEAR(found[number], number == 3 ? rad_from_deg(expected) : expected, 28 * few_operations);
    }
  }
}

}  // namespace vrda::surfaces_test
