#include "tables/tables.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/units.hpp"
#include "support/models.hpp"
#include "support/refusal.hpp"

namespace vrda::tables::flexion_motion_test {

using testing::ElementsAre;

constexpr double angle_rounding_rad = 1e-12;  // degrees to radians and back

test::ModelPlan tilted_plan()
{
  test::ModelPlan plan;
  plan.motion = [](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{0.01 * flexion_deg, -20.0, 0.02 * varus_deg, 0.1 * flexion_deg + varus_deg};
  };
  return plan;
}

store::MotionModel with_zero_varus(store::MotionModel model, const std::vector<double>& varus_deg,
                                   std::size_t hole)
{
  store::ZeroVarus table;
  table.varus_deg = varus_deg;
  table.source.assign(varus_deg.size(), static_cast<std::int8_t>(store::ZeroVarusSource::both_touch));
  table.source[hole] = static_cast<std::int8_t>(store::ZeroVarusSource::none);
  model.zero_varus = table;
  return model;
}

std::vector<double> flexions_left_out(const FlexionMotion& motion)
{
  std::vector<double> flexions;
  for (const OmittedFlexion& out : motion.omitted) flexions.push_back(out.flexion_deg);
  return flexions;
}

InputError::Facts refused(const store::MotionModel& model, const FlexionPlan& plan)
{
  return test::input_error([&] { flexion_motion(model, "knee.h5", plan); });
}

TEST(FlexionMotion, FollowsTheSpineAtTheFlexionsOfTheModel)
{
  const store::MotionModel model = test::model_of(tilted_plan());
  const FlexionMotion motion = flexion_motion(model, "knee.h5", {});
  ASSERT_EQ(motion.frames.size(), model.flexion_deg.size());
  EXPECT_EQ(motion.set, "raw");
  EXPECT_TRUE(motion.omitted.empty());
  const store::Motion poses(model, "raw");
  for (std::size_t i = 0; i < motion.frames.size(); ++i) {
    SCOPED_TRACE(i);
    const FlexionFrame& frame = motion.frames[i];
    EXPECT_EQ(frame.flexion_deg, model.flexion_deg[i]);
    const store::JointPose expected = poses.at({rad_from_deg(frame.flexion_deg), 0.0});
    EXPECT_TRUE(frame.pose.X_reference_moving.isApprox(expected.X_reference_moving, angle_rounding_rad));
    EXPECT_NEAR(frame.clinical.flexion_rad, rad_from_deg(frame.flexion_deg), angle_rounding_rad);
    EXPECT_NEAR(frame.clinical.internal_rotation_rad, rad_from_deg(0.1 * frame.flexion_deg),
                angle_rounding_rad);
    EXPECT_NEAR(time_s(motion, frame, 30.0), frame.flexion_deg / 30.0, 1e-15);
  }
}

TEST(FlexionMotion, NothingIsBridgedOrClamped)
{
  store::MotionModel model = test::model_of(tilted_plan());
  test::unsolve(model, 2, 2);  // 30 degrees, on the spine
  FlexionPlan plan;
  plan.flexion_deg = {-10, 0, 15, 20, 30, 40, 45, 90, 91};
  plan.varus = VarusRule::given;
  const FlexionMotion motion = flexion_motion(model, "knee.h5", plan);
  EXPECT_THAT(flexions_left_out(motion), ElementsAre(-10, 20, 30, 40, 91));
  EXPECT_EQ(motion.omitted[0].reason, "beyond the measured range");
  EXPECT_EQ(motion.omitted[1].reason, "unsolved_cell");
  EXPECT_EQ(motion.frames.size(), 4U);
}

TEST(FlexionMotion, ZeroVarusIsLinearBetweenTheFlexionsThatHaveOne)
{
  const store::MotionModel model = with_zero_varus(test::model_of(tilted_plan()), {0, 1, 2, 2, 0, -1, -2}, 4);
  EXPECT_EQ(default_varus(model, "zero_varus"), VarusRule::zero);
  EXPECT_EQ(default_varus(model, "raw"), VarusRule::spine) << "as it is shown";
  FlexionPlan plan;
  plan.flexion_deg = {7.5, 15, 40, 50, 60, 70, 75, 80};
  plan.varus = VarusRule::zero;
  const FlexionMotion motion = flexion_motion(model, "knee.h5", plan);
  EXPECT_THAT(flexions_left_out(motion), ElementsAre(50, 60, 70));
  EXPECT_EQ(motion.omitted[0].reason, "no zero-varus pose");
  std::vector<double> varus_deg;
  for (const FlexionFrame& frame : motion.frames)
    varus_deg.push_back(deg_from_rad(frame.pose.attitude.varus_rad));
  EXPECT_THAT(varus_deg, testing::Pointwise(testing::DoubleNear(1e-12), {0.5, 1.0, 2.0, -1.0, -4.0 / 3.0}));
}

TEST(FlexionMotion, ARuleThatCannotBeKeptIsRefused)
{
  const store::MotionModel model = test::model_of(tilted_plan());
  EXPECT_EQ(default_varus(model, "zero_varus"), VarusRule::spine);
  FlexionPlan plan;
  plan.varus = VarusRule::zero;
  EXPECT_THAT(refused(model, plan), test::refuses({.field = "--varus", .wanted = "vrda reduce"}));
  plan.varus = VarusRule::given;
  plan.varus_deg = 4.5;
  EXPECT_THAT(refused(model, plan),
              test::refuses({.field = "--varus", .found = "4.5", .wanted = {"-4", "4"}}));
  plan.varus_deg = 0.0;
  plan.set = "degree_7";
  EXPECT_EQ(refused(model, plan).field, "--set");
  EXPECT_EQ(refused(model, plan).wanted, "raw");
  test::ModelPlan free = tilted_plan();
  free.varus_deg = {0};
  free.free_varus_deg = [](double flexion_deg) { return 0.01 * flexion_deg; };
  plan.set = "raw";
  EXPECT_THAT(refused(test::model_of(free), plan), test::refuses({.field = "--varus", .wanted = "free"}));
}

}  // namespace vrda::tables::flexion_motion_test
