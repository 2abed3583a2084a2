#include "store/curve_figures.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/units.hpp"
#include "support/models.hpp"

namespace vrda::curve_figures_test {

using testing::NanSensitiveDoubleEq;

// Maximum minus minimum would hide the sign, the place and the speed of the change.
TEST(CurveFigures, MatchTheClosedForms)
{
  struct Row {
    const char* what;
    std::vector<double> flexion_deg, value_deg;
    store::CurveFigures expected;
  };
  const Row rows[] = {
      {"line", {0, 30, 90}, {2, -1, -7}, {0, 90, -9, -9, 90, -0.5, 0, 5}},
      {"external, then back", {0, 10, 20, 40}, {1, -9, -3, 3}, {0, 40, 2, -10, 10, -5, 0, 5}},
      {"jump within the window", {0, 1, 2, 3}, {0, 0, 8, 8}, {0, 3, 8, 8, 2, 8, 1, 2}},
      {"jump beside a corner", {0, 20, 22, 40}, {0, 0, 4, 13}, {0, 40, 13, 13, 40, 5.5, 20, 25}},
      {"a hole is bridged", {0, 5, 10}, {0, nan, 4}, {0, 10, 4, 4, 10, 2, 0, 5}},
      {"frames: no change over flexion", {0, 20, 10}, {0, 6, 5}, {0, 10, 5, 6, 20, nan, nan, nan}},
      {"one value", {0, 5}, {nan, 3}, {}},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.what);
    const store::CurveFigures f = store::curve_figures({row.flexion_deg, row.value_deg});
    EXPECT_THAT(f.first_deg, NanSensitiveDoubleEq(row.expected.first_deg));
    EXPECT_THAT(f.last_deg, NanSensitiveDoubleEq(row.expected.last_deg));
    EXPECT_THAT(f.net_deg, NanSensitiveDoubleEq(row.expected.net_deg));
    EXPECT_THAT(f.peak_deg, NanSensitiveDoubleEq(row.expected.peak_deg));
    EXPECT_THAT(f.peak_at_deg, NanSensitiveDoubleEq(row.expected.peak_at_deg));
    EXPECT_THAT(f.change_deg, NanSensitiveDoubleEq(row.expected.change_deg));
    EXPECT_THAT(f.change_from_deg, NanSensitiveDoubleEq(row.expected.change_from_deg));
    EXPECT_THAT(f.change_to_deg, NanSensitiveDoubleEq(row.expected.change_to_deg));
  }
}

// A hole is no jump; the step of 4 degrees is.
TEST(SpineJump, IsBetweenSolvedNeighbours)
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20, 30, 40};
  plan.varus_deg = {0};
  plan.motion = [](double flexion_deg, double) {
    return store::PoseCoordinates{0, 0, 0, flexion_deg < 15 ? 20.0 : flexion_deg < 35 ? 0.0 : 4.0};
  };
  store::MotionModel model = test::model_of(plan);
  EXPECT_NEAR(store::spine_jump(model).change_deg, 20.0, 1e-12);
  test::unsolve(model, 1, 0);
  const store::SpineJump jump = store::spine_jump(model);
  EXPECT_NEAR(jump.change_deg, 4.0, 1e-12);
  EXPECT_EQ(jump.from_deg, 30.0);
  EXPECT_EQ(jump.to_deg, 40.0);
  EXPECT_EQ(store::text_of(jump), "theta jumps by 4 degrees between flexion 30 and 40 of the spine");
  model.theta_deg(4, 0) = 3.0;
  EXPECT_EQ(store::text_of(store::spine_jump(model)), "");
}

}  // namespace vrda::curve_figures_test
