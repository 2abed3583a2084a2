#include <gtest/gtest.h>

#include "core/units.hpp"
#include "store/motion.hpp"
#include "support/allocation_count.hpp"
#include "support/models.hpp"

namespace vrda::allocation_test {

TEST(MotionAllocation, AnEvaluationAllocatesNothing)
{
  VRDA_REQUIRE_ALLOCATION_COUNT();
  test::ModelPlan plan;
  plan.turning_delta = [](double flexion_deg) {
    return Eigen::Vector3d(0.001 * flexion_deg, 1.0, 0.0).normalized();
  };
  store::MotionModel model = test::model_of(plan);
  test::unsolve(model, 1, 1);
  test::add_smoothed(model, 6, [](int i, int j) {
    return store::PoseCoordinates{i + 1.0, j + 1.0, 1.0, 2.0};
  });
  model.smoothed.front().recontact_mm = store::GridD::Constant(model.status.rows(), model.status.cols(), 0.1);
  const std::vector<double> column(model.flexion_deg.size(), 1.0);
  store::ZeroVarus table;
  table.source.assign(column.size(), static_cast<std::int8_t>(store::ZeroVarusSource::free));
  table.varus_deg = table.tx_mm = table.ty_mm = table.tz_mm = table.theta_deg = column;
  model.zero_varus = table;
  for (const std::string& set : store::set_names(model)) {
    const store::Motion motion(model, set);
    const long before = test::allocations_of_program();
    double sum = 0.0;
    int n_solved = 0;
    for (int k = 0; k < 1000; ++k) {
      const double flexion_rad = rad_from_deg(0.11 * k - 5.0);
      const store::JointPose pose =
          motion.at({flexion_rad, motion.balanced_varus_rad(flexion_rad) + rad_from_deg(0.01 * k - 6.0)});
      sum += pose.X_reference_moving.linear().trace();
      n_solved += pose.status == store::PoseStatus::solved ? 1 : 0;
    }
    EXPECT_EQ(test::allocations_of_program() - before, 0) << set;
    EXPECT_GT(n_solved, 700);
    EXPECT_GT(sum, 0.0);
  }
  // The counter works.
  const long before = test::allocations_of_program();
  ::operator delete(::operator new(1));
  EXPECT_GE(test::allocations_of_program() - before, 1);
}

}  // namespace vrda::allocation_test
