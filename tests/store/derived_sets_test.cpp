// Sets derived from the raw surfaces: recontacted, with their own varus, zero-varus.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/text.hpp"
#include "core/units.hpp"
#include "store/motion.hpp"
#include "support/models.hpp"

namespace vrda::derived_sets_test {

using test::model_of;
using test::ModelPlan;

// Rounding of rotation products applied to coordinates of hundreds of mm.
constexpr double rounding = 1e-11;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Attitude attitude_deg(double flexion_deg, double varus_deg)
{
  return {rad_from_deg(flexion_deg), rad_from_deg(varus_deg)};
}

Eigen::Vector3d turning_delta(double flexion_deg)
{
  return Eigen::Vector3d(0.1 + 0.004 * flexion_deg, 1.0, -0.3).normalized();
}

ModelPlan plan_of(const std::string& side)
{
  ModelPlan plan;
  plan.side = side;
  plan.rotation_centre_mm = {430.0, 510.0, side == "left" ? -75.0 : 75.0};
  return plan;
}

// Degree two in each angle, which the patches reproduce.
double travel_mm(double flexion_deg, double varus_deg)
{
  return 0.3 - 0.0001 * flexion_deg * flexion_deg + 0.02 * varus_deg * flexion_deg - 0.05 * varus_deg;
}

/// A set "degree_1_recontacted" with travel_mm at every attitude.
store::MotionModel recontacted_model(const ModelPlan& plan)
{
  store::MotionModel model = model_of(plan);
  test::add_smoothed(model, 1, [](int i, int j) {
    return store::PoseCoordinates{1.0 * i, -20.0, 3.0 + j, 8.0};
  });
  store::GridD travel(model.status.rows(), model.status.cols());
  for (Eigen::Index i = 0; i < travel.rows(); ++i) {
    for (Eigen::Index j = 0; j < travel.cols(); ++j) {
      travel(i, j) = travel_mm(plan.flexion_deg[static_cast<std::size_t>(i)],
                               plan.varus_deg[static_cast<std::size_t>(j)]);
    }
  }
  model.smoothed.front().recontact_mm = travel;
  return model;
}

TEST(RecontactedSet, IsShiftedByTheTravelAlongDeltaAtAndBetweenTheNodes)
{
  for (const std::string side : {"right", "left"}) {
    ModelPlan plan = plan_of(side);
    plan.turning_delta = turning_delta;
    const store::MotionModel model = recontacted_model(plan);
    const store::Motion plain(model, "degree_1"), recontacted(model, "degree_1_recontacted");
    for (const Attitude& at : {attitude_deg(0, -4), attitude_deg(90, 4), attitude_deg(45, 0),
                               attitude_deg(37, 1.3), attitude_deg(81, -3.9)}) {
      const store::JointPose a = plain.at(at), b = recontacted.at(at);
      const double expected_mm = travel_mm(deg_from_rad(at.flexion_rad), deg_from_rad(at.varus_rad));
      EXPECT_EQ(b.status, store::PoseStatus::solved);
      EXPECT_EQ(a.theta_rad, b.theta_rad);
      const Eigen::Vector3d shift = b.X_world_moving.translation() - a.X_world_moving.translation();
      EXPECT_LT((shift - expected_mm * recontacted.delta(at.flexion_rad)).norm(), rounding);
    }
  }
}

TEST(RecontactedSet, HasNoAnswerBesideAnAttitudeWithoutContact)
{
  store::MotionModel model = recontacted_model(plan_of("right"));
  (*model.smoothed.front().recontact_mm)(2, 1) = nan;  // 30 degrees, varus -2
  const store::Motion recontacted(model, "degree_1_recontacted");
  EXPECT_EQ(recontacted.at(attitude_deg(33, -1)).status, store::PoseStatus::unsolved_cell);
  EXPECT_EQ(recontacted.at(attitude_deg(46, -1)).status, store::PoseStatus::solved);
  EXPECT_EQ(store::Motion(model, "degree_1").at(attitude_deg(33, -1)).status, store::PoseStatus::solved);
}

/// Free varus, 0.5 - 2 P_1 + 3 P_2 degrees in the smoothed set.
store::MotionModel own_varus_model()
{
  ModelPlan plan;
  plan.varus_deg = {0};
  plan.free_varus_deg = [](double flexion_deg) { return 0.1 * flexion_deg; };
  store::MotionModel model = model_of(plan);
  test::add_smoothed(model, 2, [](int i, int) { return store::PoseCoordinates{1.0 * i, -20.0, 3.0, 8.0}; });
  store::SmoothedSet& set = model.smoothed.front();
  store::SmoothedSurface varus = set.surfaces.front();
  varus.name = "varus";
  for (Eigen::Index k = 0; k < set.exponents.rows(); ++k) {
    const double by_degree[3] = {0.5, -2.0, 3.0};
    varus.coefficients[static_cast<std::size_t>(k)] =
        set.exponents(k, 1) == 0 ? by_degree[set.exponents(k, 0)] : 0.0;
  }
  set.surfaces.push_back(varus);
  return model;
}

TEST(SmoothedSet, WithAVarusSurfaceHasItsVarus)
{
  const store::MotionModel model = own_varus_model();
  const store::Motion smoothed(model, "degree_2"), raw(model, "raw");
  for (const double flexion_deg : {0.0, 10.0, 45.0, 77.0, 90.0}) {
    const double u = flexion_deg / 45.0 - 1.0;
    const double expected_rad = rad_from_deg(0.5 - 2.0 * u + 1.5 * (3.0 * u * u - 1.0));
    const store::JointPose pose = smoothed.at(attitude_deg(flexion_deg, 0));
    EXPECT_NEAR(pose.attitude.varus_rad, expected_rad, rounding);
    EXPECT_TRUE(pose.is_varus_clamped);
    EXPECT_EQ(smoothed.balanced_varus_rad(rad_from_deg(flexion_deg)), pose.attitude.varus_rad);
    EXPECT_NEAR(raw.at(attitude_deg(flexion_deg, 0)).attitude.varus_rad, rad_from_deg(0.1 * flexion_deg),
                rounding);
    // The reference is rotated to that varus.
    EXPECT_LT((pose.X_world_reference.linear() - reference_rotation(pose.attitude)).norm(), rounding);
  }
  EXPECT_TRUE(smoothed.is_varus_free());
  EXPECT_NEAR(smoothed.last_varus_rad(), rad_from_deg(5.5), rounding);  // at 0 degrees
}

store::ZeroVarus table_of(const store::MotionModel& model)
{
  store::ZeroVarus table;
  for (const double f : model.flexion_deg) {
    table.source.push_back(static_cast<std::int8_t>(store::ZeroVarusSource::both_touch));
    table.varus_deg.push_back(-1.0 + 0.0005 * f * f);
    table.tx_mm.push_back(-0.001 * f * f);
    table.ty_mm.push_back(-20.0 + 0.01 * f);
    table.tz_mm.push_back(1.0);
    table.theta_deg.push_back(12.0 - 0.1 * f);
  }
  return table;
}

TEST(ZeroVarusSet, KnowsFlexionAloneAndReproducesSurfacesOfDegreeTwo)
{
  store::MotionModel model = model_of(plan_of("left"));
  model.zero_varus = table_of(model);
  const store::Motion motion(model, "zero_varus");
  EXPECT_TRUE(motion.is_varus_free());
  for (const double f : {0.0, 15.0, 22.0, 61.0, 90.0}) {
    const store::JointPose pose = motion.at(attitude_deg(f, 2.0));
    EXPECT_EQ(pose.status, store::PoseStatus::solved);
    EXPECT_TRUE(pose.is_varus_clamped);
    EXPECT_NEAR(pose.attitude.varus_rad, rad_from_deg(-1.0 + 0.0005 * f * f), rounding);
    EXPECT_NEAR(pose.theta_rad, rad_from_deg(12.0 - 0.1 * f), rounding);
    const Eigen::Vector3d expected_mm(-0.001 * f * f, -20.0 + 0.01 * f, 1.0);
    EXPECT_LT((pose.X_world_moving * model.rotation_centre_mm - expected_mm).norm(), rounding);
    EXPECT_EQ(motion.balanced_varus_rad(rad_from_deg(f)), pose.attitude.varus_rad);
  }
  EXPECT_TRUE(motion.at(attitude_deg(95, 0)).is_flexion_clamped);
  EXPECT_NEAR(motion.first_varus_rad(), rad_from_deg(-1.0), rounding);
}

TEST(ZeroVarusSet, BridgesNoHole)
{
  store::MotionModel model = model_of({});
  model.zero_varus = table_of(model);
  model.zero_varus->source[3] = static_cast<std::int8_t>(store::ZeroVarusSource::none);  // 45 degrees
  model.zero_varus->tx_mm[3] = model.zero_varus->varus_deg[3] = nan;
  const store::Motion motion(model, "zero_varus");
  EXPECT_EQ(motion.at(attitude_deg(45, 0)).status, store::PoseStatus::unsolved_cell);
  EXPECT_EQ(motion.at(attitude_deg(40, 0)).status, store::PoseStatus::unsolved_cell);
  EXPECT_EQ(motion.at(attitude_deg(60, 0)).status, store::PoseStatus::solved);
  EXPECT_FALSE(std::isnan(motion.balanced_varus_rad(rad_from_deg(45))));
}

TEST(SetNames, ShowFirstWhatNeitherOverlapsNorGapes)
{
  store::MotionModel model = recontacted_model({});
  test::add_smoothed(model, 4, [](int, int) { return store::PoseCoordinates{}; });
  model.zero_varus = table_of(model);
  EXPECT_EQ(store::set_names(model),
            (std::vector<std::string>{"degree_4", "degree_1_recontacted", "degree_1", "raw", "zero_varus"}));
  for (const std::string& name : store::set_names(model)) {
    EXPECT_EQ(store::Motion(model, name).at({}).status, store::PoseStatus::solved);
  }
  EXPECT_THROW(store::Motion(model, "degree_4_recontacted"), InternalError);
  // A table without poses is not a motion.
  model.zero_varus->source.assign(model.flexion_deg.size(),
                                  static_cast<std::int8_t>(store::ZeroVarusSource::none));
  EXPECT_EQ(store::set_names(model).back(), "raw");
  EXPECT_THROW(store::Motion(model, "zero_varus"), InternalError);
}

// Everything that names no set follows it; without it, files before 1.10 keep what they showed.
TEST(DefaultMotion, IsTheModelsIfItStillHasTheSet)
{
  store::MotionModel model = recontacted_model({});
  EXPECT_EQ(store::default_motion(model).set, "degree_1_recontacted");
  model.default_motion = store::DefaultMotion{"raw", "why"};
  EXPECT_EQ(store::default_motion(model).set, "raw");
  EXPECT_EQ(store::default_motion(model).reason, "why");
  EXPECT_EQ(store::chosen_set(model, "knee.h5", ""), "raw");
  EXPECT_EQ(store::chosen_set(model, "knee.h5", "degree_1"), "degree_1");
  model.default_motion->set = "degree_9";
  EXPECT_EQ(store::default_motion(model).set, "degree_1_recontacted");
  EXPECT_EQ(store::default_motion(model).reason, "");
}

}  // namespace vrda::derived_sets_test
