#include "solve/equilibrium.hpp"

#include <gtest/gtest.h>

#include "support/meshes.hpp"

namespace vrda {
namespace {

TEST(Equilibrium, ABallUnderAPlateRestsWhereItWasSeeded)
{
  const Joint joint = make_joint({test::box({0, 10, 0}, {100, 20, 100}), {}}, {test::ball(10), {}}, {});
  const Ligaments none;
  EquilibriumSolver solver(joint, none, {});
  const StepRecord r = solver.solve({{}, {{3, -40, 4}, 0.3}, {}, false});
  ASSERT_EQ(r.status, StepStatus::stable);
  EXPECT_NEAR(r.pose.translation_mm.y(), -10, 2e-5);
}

}  // namespace
}  // namespace vrda
