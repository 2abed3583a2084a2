#include "motion/raw_surfaces.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "core/trig.hpp"
#include "core/units.hpp"
#include "motion/support/models.hpp"

namespace vrda::raw_surfaces_test {

using test::model_of;
using test::ModelPlan;

// A dozen products and sums of numbers up to a hundred.
constexpr double rounding = 1e-12;

Attitude attitude_deg(double flexion_deg, double varus_deg)
{
  return {rad_from_deg(flexion_deg), rad_from_deg(varus_deg)};
}

/// Degree two in each angle, all products present.
PoseNumbers biquadratic(double flexion_deg, double varus_deg)
{
  const double u = flexion_deg / 90.0, v = varus_deg / 4.0;
  return {1.0 + u + v + u * v, -20.0 + 3.0 * u * u - v * v, u * u * v * v - 2.0 * u * v * v,
          15.0 * u - 4.0 * u * u * v};
}

/// Not a polynomial, so that nothing is exact by accident.
PoseNumbers wavy(double flexion_deg, double varus_deg)
{
  const double u = rad_from_deg(flexion_deg), v = rad_from_deg(varus_deg);
  return {sine(2.0 * u + v), cosine(u - 7.0 * v), sine(u * v), 20.0 * cosine(3.0 * u)};
}

TEST(RawSurfaces, GridValuesAreReproducedToTheLastBit)
{
  ModelPlan plan;
  plan.motion = wavy;
  const MotionModel model = model_of(plan);
  const RawSurfaces surfaces = raw_surfaces(model);
  for (const double flexion_deg : plan.flexion_deg) {
    for (const double varus_deg : plan.varus_deg) {
      const RawSample found = sample(surfaces, attitude_deg(flexion_deg, varus_deg));
      const PoseNumbers expected = wavy(flexion_deg, varus_deg);
      ASSERT_TRUE(found.is_solved);
      for (std::size_t number = 0; number < 3; ++number) EXPECT_EQ(found.numbers[number], expected[number]);
      EXPECT_EQ(found.numbers[3], rad_from_deg(expected[3]));
    }
  }
}

TEST(RawSurfaces, SurfacesOfDegreeTwoInEachAngleAreReproducedBetweenTheCells)
{
  ModelPlan plan;
  plan.flexion_deg = {0, 10, 25, 30, 52, 90};  // uneven steps
  plan.varus_deg = {-4, -1, 0.5, 4};
  plan.motion = biquadratic;
  const RawSurfaces surfaces = raw_surfaces(model_of(plan));
  for (double flexion_deg = 0.0; flexion_deg <= 90.0; flexion_deg += 3.7) {
    for (double varus_deg = -4.0; varus_deg <= 4.0; varus_deg += 0.61) {
      const RawSample found = sample(surfaces, attitude_deg(flexion_deg, varus_deg));
      const PoseNumbers expected = biquadratic(flexion_deg, varus_deg);
      ASSERT_TRUE(found.is_solved);
      for (std::size_t number = 0; number < 3; ++number) {
        EXPECT_NEAR(found.numbers[number], expected[number], rounding);
      }
      EXPECT_NEAR(found.numbers[3], rad_from_deg(expected[3]), rounding);
    }
  }
}

TEST(RawSurfaces, SlopesAreContinuousAcrossCells)
{
  ModelPlan plan;
  plan.motion = wavy;
  const RawSurfaces surfaces = raw_surfaces(model_of(plan));
  constexpr double step_rad = 1e-6;
  // Difference quotients err by half the second derivative (below 100) times the step, twice.
  constexpr double tolerance = 100.0 * step_rad;
  for (const double varus_deg : {-3.0, -2.0, 1.3}) {
    const Attitude node = attitude_deg(45, varus_deg);
    const PoseNumbers here = sample(surfaces, node).numbers;
    const PoseNumbers before = sample(surfaces, {node.flexion_rad - step_rad, node.varus_rad}).numbers;
    const PoseNumbers after = sample(surfaces, {node.flexion_rad + step_rad, node.varus_rad}).numbers;
    for (std::size_t number = 0; number < 4; ++number) {
      EXPECT_NEAR((here[number] - before[number]) / step_rad, (after[number] - here[number]) / step_rad,
                  tolerance);
    }
  }
}

TEST(RawSurfaces, AttitudesBesideAnUnsolvedCellHaveNoAnswerAndOthersStayExact)
{
  ModelPlan plan;
  plan.varus_deg = {-6, -4, -2, 0, 2, 4, 6};  // a parabola's worth of columns on each side of the hole
  plan.motion = biquadratic;
  MotionModel model = model_of(plan);
  test::unsolve(model, 3, 3);  // 45 degrees, varus 0
  const RawSurfaces surfaces = raw_surfaces(model);
  for (const Attitude& beside :
       {attitude_deg(45, 0), attitude_deg(40, 0), attitude_deg(50, 1), attitude_deg(31, -1)}) {
    EXPECT_FALSE(sample(surfaces, beside).is_solved);
  }
  // On the far edges of the patches around the hole, and in the patches next to those.
  for (const Attitude& away :
       {attitude_deg(30, 0), attitude_deg(30, 1), attitude_deg(60, 0), attitude_deg(45, 2),
        attitude_deg(45, -2), attitude_deg(20, 0), attitude_deg(70, 1), attitude_deg(50, 3)}) {
    const RawSample found = sample(surfaces, away);
    ASSERT_TRUE(found.is_solved) << away.flexion_rad << " " << away.varus_rad;
    const PoseNumbers expected = biquadratic(deg_from_rad(away.flexion_rad), deg_from_rad(away.varus_rad));
    for (std::size_t number = 0; number < 3; ++number)
      EXPECT_NEAR(found.numbers[number], expected[number], rounding);
  }
}

TEST(RawSurfaces, ANodeMissedByRoundingNeedsNoneOfItsNeighbours)
{
  ModelPlan plan;
  plan.motion = biquadratic;
  MotionModel model = model_of(plan);
  test::unsolve(model, 2, 2);
  test::unsolve(model, 4, 2);
  const RawSurfaces surfaces = raw_surfaces(model);
  for (const double off_rad : {-1e-15, 1e-15}) {
    const RawSample found = sample(surfaces, {rad_from_deg(45) + off_rad, off_rad});
    EXPECT_TRUE(found.is_solved);
    EXPECT_EQ(found.numbers[1], model.ty_mm(3, 2));
  }
}

TEST(RawSurfaces, ASingleColumnIsInterpolatedInFlexionAlone)
{
  ModelPlan plan;
  plan.varus_deg = {0};
  plan.motion = biquadratic;
  const RawSurfaces surfaces = raw_surfaces(model_of(plan));
  const RawSample found = sample(surfaces, attitude_deg(33, 0));
  ASSERT_TRUE(found.is_solved);
  EXPECT_NEAR(found.numbers[1], biquadratic(33, 0)[1], rounding);
}

TEST(RawSurfaces, AMisshapenModelIsABrokenPromise)
{
  MotionModel descending = model_of({});
  descending.flexion_deg[2] = descending.flexion_deg[1];
  EXPECT_THROW(raw_surfaces(descending), InternalError);
  MotionModel small = model_of({});
  small.ty_mm.resize(2, 2);
  EXPECT_THROW(raw_surfaces(small), InternalError);
}

}  // namespace vrda::raw_surfaces_test
