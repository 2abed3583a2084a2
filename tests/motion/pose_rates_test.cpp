// Derivatives of the poses of every set.
#include <gtest/gtest.h>

#include <cmath>

#include "core/units.hpp"
#include "motion/poses.hpp"
#include "motion/support/models.hpp"

namespace vrda::pose_rates_test {

using test::model_of;
using test::ModelPlan;

constexpr double step_rad = 2e-6;
// Central differences err by step^2 / 6 of the third derivative and by the rounding of a pose (1e-12 mm) over
// the step. The former is largest by varus, four degrees of which are the unit of the polynomials: below
// 18 * 15 / rad_from_deg(4)^3, or 1e6 mm.
constexpr double difference_tolerance = step_rad * step_rad / 6.0 * 1e6 + 1e-12 / step_rad;
// Rounding of products of a dozen numbers of some hundreds.
constexpr double rounding = 1e-10;

Attitude attitude_deg(double flexion_deg, double varus_deg)
{
  return {rad_from_deg(flexion_deg), rad_from_deg(varus_deg)};
}

motion::PoseCoordinates knee_like(double flexion_deg, double varus_deg)
{
  const double u = flexion_deg / 90.0, v = varus_deg / 4.0;
  return {4.0 * u * u - v, -20.0 + 3.0 * u * v, 2.0 * u - v * v, 15.0 * u * u * u - 5.0 * v};
}

store::GridD wavy_travel(const store::MotionModel& model)
{
  store::GridD travel(model.status.rows(), model.status.cols());
  for (Eigen::Index k = 0; k < travel.size(); ++k) travel.data()[k] = 1e-3 * static_cast<double>(k * k % 7);
  return travel;
}

/// A model with all sets: raw, smoothed, recontacted, zero-varus.
store::MotionModel full_model(const std::string& side, bool is_turning)
{
  ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {43.0, 51.0, -75.0};
  plan.delta = Eigen::Vector3d(0.1, 1.0, 0.2).normalized();
  plan.motion = knee_like;
  if (is_turning) {
    plan.turning_delta = [](double flexion_deg) {
      return Eigen::Vector3d(0.1 + 0.004 * flexion_deg, 1.0, -0.3).normalized();
    };
  }
  store::MotionModel model = model_of(plan);
  test::add_smoothed(model, 3, [](int i, int j) {
    return motion::PoseCoordinates{1.0 + i - j, -20.0 + 2.0 * i * j, 3.0 - j, 8.0 / (1.0 + i + j)};
  });
  model.smoothed.front().recontact_mm = wavy_travel(model);
  store::ZeroVarus table;
  for (const double f : model.flexion_deg) {
    table.source.push_back(static_cast<std::int8_t>(store::ZeroVarusSource::both_touch));
    table.varus_deg.push_back(-1.0 + 0.0005 * f * f);
    table.tx_mm.push_back(-0.001 * f * f);
    table.ty_mm.push_back(-20.0 + 0.01 * f);
    table.tz_mm.push_back(std::sqrt(f));
    table.theta_deg.push_back(12.0 - 0.1 * f);
  }
  model.zero_varus = table;
  return model;
}

/// Free varus: the raw set follows the solved varus, the smoothed set its own surface.
store::MotionModel free_model()
{
  ModelPlan plan;
  plan.varus_deg = {0};
  plan.delta = Eigen::Vector3d(0.0, 1.0, 0.1).normalized();
  plan.motion = knee_like;
  plan.free_varus_deg = [](double flexion_deg) { return -1.0 + 0.001 * flexion_deg * flexion_deg; };
  store::MotionModel model = model_of(plan);
  test::add_smoothed(model, 2, [](int i, int) {
    return motion::PoseCoordinates{1.0 * i, -20.0, 3.0, 8.0 * i};
  });
  store::SmoothedSurface varus = model.smoothed.front().surfaces.front();
  varus.name = "varus";
  model.smoothed.front().surfaces.push_back(varus);
  return model;
}

motion::PoseCoordinates numbers_of(const motion::JointPose& pose, const store::MotionModel& model)
{
  const Eigen::Vector3d t = pose.X_world_moving * model.rotation_centre_mm;
  return {t.x(), t.y(), t.z(), pose.theta_rad};
}

/// Compares `rate` with central differences of the poses.
void expect_slope(const store::MotionModel& model, const motion::JointPose& pose,
                  const motion::PoseRate& rate, const std::pair<motion::JointPose, motion::JointPose>& around)
{
  const motion::PoseCoordinates before = numbers_of(around.first, model),
                                after = numbers_of(around.second, model);
  for (std::size_t number = 0; number < 4; ++number) {
    EXPECT_NEAR(rate.coordinates[number], (after[number] - before[number]) / (2.0 * step_rad),
                difference_tolerance)
        << number;
  }
  const double varus_rise = around.second.attitude.varus_rad - around.first.attitude.varus_rad;
  EXPECT_NEAR(rate.varus, varus_rise / (2.0 * step_rad), difference_tolerance);
  for (const Eigen::Vector3d& p_moving_mm : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(100, -200, 150)}) {
    const Eigen::Vector3d p_mm = pose.X_reference_moving * p_moving_mm;
    const Eigen::Vector3d slope =
        (around.second.X_reference_moving * p_moving_mm - around.first.X_reference_moving * p_moving_mm) /
        (2.0 * step_rad);
    EXPECT_LT((rate.twist.angular.cross(p_mm) + rate.twist.linear_mm - slope).norm(), difference_tolerance);
  }
}

void expect_zero(const motion::PoseRate& rate)
{
  EXPECT_EQ(rate.coordinates, motion::PoseCoordinates{});
  EXPECT_EQ(rate.varus, 0.0);
  EXPECT_EQ(rate.twist.angular, Eigen::Vector3d::Zero());
  EXPECT_EQ(rate.twist.linear_mm, Eigen::Vector3d::Zero());
}

TEST(PoseRates, AgreeWithDifferencesForEverySetSideAndDelta)
{
  for (const std::string side : {"right", "left"}) {
    for (const bool is_turning : {false, true}) {
      const store::MotionModel model = full_model(side, is_turning);
      for (const std::string& set : motion::set_names(model)) {
        SCOPED_TRACE(side + " " + set);
        const motion::Motion motion(model, set);
        for (const Attitude& at : {attitude_deg(7, -3.1), attitude_deg(33, 0.4), attitude_deg(88, 3.9)}) {
          const double f = at.flexion_rad, v = at.varus_rad;
          const motion::JointRate rate = motion.rate_at(at);
          ASSERT_EQ(rate.pose.status, motion::PoseStatus::solved);
          // Bitwise equal to at().
          EXPECT_EQ(rate.pose.X_reference_moving.matrix(), motion.at(at).X_reference_moving.matrix());
          EXPECT_TRUE(rate.is_flexion_free);
          EXPECT_EQ(rate.is_varus_free, set != "zero_varus");
          expect_slope(model, rate.pose, rate.by_flexion,
                       {motion.at({f - step_rad, v}), motion.at({f + step_rad, v})});
          // For zero_varus both poses are equal, so their difference is 0.
          expect_slope(model, rate.pose, rate.by_varus,
                       {motion.at({f, v - step_rad}), motion.at({f, v + step_rad})});
        }
      }
    }
  }
}

TEST(PoseRates, OfAFreeVarusFollowTheVarusFound)
{
  const store::MotionModel model = free_model();
  for (const std::string set : {"raw", "degree_2"}) {
    SCOPED_TRACE(set);
    const motion::Motion motion(model, set);
    for (const double flexion_deg : {4.0, 37.0, 89.0}) {
      const double f = rad_from_deg(flexion_deg);
      const motion::JointRate rate = motion.rate_at({f, 0.0});
      expect_slope(model, rate.pose, rate.by_flexion,
                   {motion.at({f - step_rad, 0.0}), motion.at({f + step_rad, 0.0})});
      EXPECT_NE(rate.by_flexion.varus, 0.0);
      expect_zero(rate.by_varus);
    }
  }
}

TEST(PoseRates, OfThePolynomialsAreTheirDerivatives)
{
  store::MotionModel model = model_of({});
  // x = P_2(u) P_1(v) = (3 u^2 - 1) v / 2 mm, theta = 10 degrees P_1(u)
  test::add_smoothed(model, 3, [](int i, int j) {
    return motion::PoseCoordinates{i == 2 && j == 1 ? 1.0 : 0.0, 0.0, 0.0, i == 1 && j == 0 ? 10.0 : 0.0};
  });
  const double u = 60.0 / 45.0 - 1.0, v = 1.0 / 4.0;
  const double u_rate = deg_from_rad(1.0) / 45.0, v_rate = deg_from_rad(1.0) / 4.0;
  const motion::JointRate rate = motion::Motion(model, "degree_3").rate_at(attitude_deg(60, 1));
  EXPECT_NEAR(rate.by_flexion.coordinates[0], 3.0 * u * v * u_rate, rounding);
  EXPECT_NEAR(rate.by_varus.coordinates[0], 0.5 * (3.0 * u * u - 1.0) * v_rate, rounding);
  EXPECT_NEAR(rate.by_flexion.coordinates[3], rad_from_deg(10.0) * u_rate, rounding);
  EXPECT_NEAR(rate.by_varus.coordinates[3], 0.0, rounding);
  EXPECT_EQ(rate.by_varus.varus, 1.0);
}

TEST(PoseRates, OfABodyThatStaysIsTheTurnOfTheReferenceReversed)
{
  // X_reference_moving = Rz(-flexion) Rx(varus) about the centre: it rotates about -Z and Rz(-flexion) X.
  ModelPlan plan;
  plan.rotation_centre_mm = {10, 20, 30};
  const motion::JointRate rate = motion::Motion(model_of(plan), "raw").rate_at(attitude_deg(90, 3));
  EXPECT_LT((rate.by_flexion.twist.angular + Eigen::Vector3d::UnitZ()).norm(), rounding);
  EXPECT_LT((rate.by_varus.twist.angular + Eigen::Vector3d::UnitY()).norm(), rounding);
  // The centre does not move.
  for (const motion::Twist& twist : {rate.by_flexion.twist, rate.by_varus.twist})
    EXPECT_LT((twist.angular.cross(plan.rotation_centre_mm) + twist.linear_mm).norm(), rounding);
}

TEST(PoseRates, AreThoseOfBothCellsAtANode)
{
  const store::MotionModel model = full_model("right", false);
  const motion::Motion motion(model, "raw");
  const double f = rad_from_deg(45), v = rad_from_deg(2);
  const motion::JointRate here = motion.rate_at({f, v});
  for (const double side : {-1.0, 1.0}) {
    const motion::JointRate beside = motion.rate_at({f + side * step_rad, v + side * step_rad});
    for (std::size_t number = 0; number < 4; ++number) {
      // First derivatives are continuous; second ones are below 1e4.
      EXPECT_NEAR(here.by_flexion.coordinates[number], beside.by_flexion.coordinates[number], 2e4 * step_rad);
      EXPECT_NEAR(here.by_varus.coordinates[number], beside.by_varus.coordinates[number], 2e4 * step_rad);
    }
  }
}

TEST(PoseRates, AreZeroAlongAClampedAngleAndThoseFromWithinAtAnEnd)
{
  const store::MotionModel model = full_model("left", true);
  for (const std::string& set : motion::set_names(model)) {
    SCOPED_TRACE(set);
    const motion::Motion motion(model, set);
    const motion::JointRate beyond = motion.rate_at(attitude_deg(95, 1));
    EXPECT_TRUE(beyond.pose.is_flexion_clamped);
    EXPECT_FALSE(beyond.is_flexion_free);
    expect_zero(beyond.by_flexion);
    const motion::JointRate sideways = motion.rate_at(attitude_deg(50, 9));
    EXPECT_TRUE(sideways.pose.is_varus_clamped);
    EXPECT_FALSE(sideways.is_varus_free);
    expect_zero(sideways.by_varus);
    EXPECT_NE(sideways.by_flexion.coordinates, motion::PoseCoordinates{});
    const double end_rad = motion.last_flexion_rad(), v = rad_from_deg(1);
    const motion::JointRate at_end = motion.rate_at({end_rad, v});
    EXPECT_FALSE(at_end.pose.is_flexion_clamped);
    const motion::PoseCoordinates before = numbers_of(motion.at({end_rad - step_rad, v}), model);
    const motion::PoseCoordinates last = numbers_of(at_end.pose, model);
    for (std::size_t number = 0; number < 4; ++number) {
      // One-sided differences err by half the second derivative, below 1e4, times the step.
      EXPECT_NEAR(at_end.by_flexion.coordinates[number], (last[number] - before[number]) / step_rad,
                  1e4 * step_rad);
    }
  }
}

TEST(PoseRates, AreZeroWithoutAPoseAndWhereAnAxisHasOneValue)
{
  store::MotionModel model = full_model("right", false);
  test::unsolve(model, 2, 2);
  const motion::JointRate unsolved = motion::Motion(model, "raw").rate_at(attitude_deg(33, 0.5));
  EXPECT_EQ(unsolved.pose.status, motion::PoseStatus::unsolved_cell);
  expect_zero(unsolved.by_flexion);
  expect_zero(unsolved.by_varus);
  ModelPlan one;
  one.flexion_deg = {30};
  one.motion = knee_like;
  const motion::JointRate single = motion::Motion(model_of(one), "raw").rate_at(attitude_deg(30, 1));
  EXPECT_EQ(single.pose.status, motion::PoseStatus::solved);
  expect_zero(single.by_flexion);
  EXPECT_NE(single.by_varus.coordinates, motion::PoseCoordinates{});
}

}  // namespace vrda::pose_rates_test
