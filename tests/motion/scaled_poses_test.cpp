// Poses of a model of another size (store/scaled_model.hpp).
#include <gtest/gtest.h>

#include "core/units.hpp"
#include "motion/poses.hpp"
#include "motion/support/models.hpp"
#include "store/scaled_model.hpp"

namespace vrda::scaled_poses_test {

constexpr double factor = 1.07;
constexpr double rounding_mm = 1e-9;  // of numbers up to 200 mm, some tens of operations

test::ModelPlan plan_of_size(double size)
{
  test::ModelPlan plan;
  plan.rotation_centre_mm = size * Eigen::Vector3d(12, -30, 7);
  plan.motion = [size](double flexion_deg, double varus_deg) {
    return PoseNumbers{size * 0.02 * flexion_deg, size * (0.3 * varus_deg - 0.05 * flexion_deg),
                       size * -0.1 * varus_deg, 0.1 * flexion_deg + varus_deg};
  };
  return plan;
}

MotionModel model_of_size(double size)
{
  MotionModel model = test::model_of(plan_of_size(size));
  test::add_smoothed(model, 2, [size](int i, int j) {
    const double one = 1.0 / (1 + i + 2 * j);
    return PoseNumbers{size * one, -2.0 * size * one, 0.5 * size * one, 3.0 * one};
  });
  return model;
}

TEST(ScaledPoses, AreThoseOfAJointMadeAtThatSize)
{
  const MotionModel scaled = scaled_model(model_of_size(1.0), factor), made = model_of_size(factor);
  for (const std::string set : {"raw", "degree_2"}) {
    SCOPED_TRACE(set);
    const Motion of_scaled(scaled, set), of_made(made, set);
    for (double flexion_deg = 0.0; flexion_deg <= 90.0; flexion_deg += 7.0) {
      const Attitude at{rad_from_deg(flexion_deg), rad_from_deg(1.3)};
      const JointPose a = of_scaled.at(at), b = of_made.at(at);
      EXPECT_TRUE(a.X_reference_moving.matrix().isApprox(b.X_reference_moving.matrix(), 1e-12));
      EXPECT_LT((a.X_reference_moving.translation() - b.X_reference_moving.translation()).norm(),
                rounding_mm);
      EXPECT_LT((a.X_world_moving.translation() - b.X_world_moving.translation()).norm(), rounding_mm);
      EXPECT_NEAR(a.theta_rad, b.theta_rad, 1e-12);
    }
  }
}

}  // namespace vrda::scaled_poses_test
