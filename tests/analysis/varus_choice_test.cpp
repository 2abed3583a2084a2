#include "analysis/reduce.hpp"

#include <gtest/gtest.h>

#include "support/models.hpp"

namespace vrda::varus_choice_test {

using test::model_of;
using test::ModelPlan;

// Rounding of a root: a product and a quotient of degrees below 10.
constexpr double rounding_deg = 1e-14;

/// One flexion with columns at -4, -2, 0, 2 and 4 degrees and these contacts: B both, m medial, l lateral, x
/// unsolved. `imbalance_mm` per column; the spine is at the middle one.
store::MotionModel row_of(const std::string& marks,
                          const std::vector<double>& imbalance_mm = {4, 2, 0.5, -1, -3})
{
  ModelPlan plan;
  plan.flexion_deg = {30};
  store::MotionModel model = model_of(plan);
  for (Eigen::Index j = 0; j < model.status.cols(); ++j) {
    const char mark = marks[static_cast<std::size_t>(j)];
    const double imbalance = imbalance_mm[static_cast<std::size_t>(j)];
    model.contact_medial(0, j) = mark == 'B' || mark == 'm' ? 1 : 0;
    model.contact_lateral(0, j) = mark == 'B' || mark == 'l' ? 1 : 0;
    model.gap_medial_mm(0, j) = imbalance > 0.0 ? imbalance : 0.0;
    model.gap_lateral_mm(0, j) = imbalance > 0.0 ? 0.0 : -imbalance;
    if (mark == 'x') test::unsolve(model, 0, j);
  }
  return model;
}

analysis::VarusChoice choice_of(const store::MotionModel& model)
{
  return analysis::varus_choices(model, store::Motion(model, "raw")).at(0);
}

TEST(VarusChoice, MeanOfTheFirstAndLastThatTouchWithBoth)
{
  struct Case {
    const char* marks;
    double first_deg, last_deg;
    Eigen::Index before, after;
    double share_after;
  };
  for (const Case& c : {Case{"llBmm", 0, 0, 2, 2, 0.0}, Case{"lBBBm", -2, 2, 2, 2, 0.0},
                        Case{"llBBm", 0, 2, 2, 3, 0.5}, Case{"BBBBB", -4, 4, 2, 2, 0.0},
                        // A hole between columns in contact does not split the run.
                        Case{"lBxBm", -2, 2, 1, 3, 0.5}, Case{"BxxBm", -4, 2, 0, 3, 0.5},
                        // Of two runs the one nearest to the spine at 0.
                        Case{"BllBm", 2, 2, 3, 3, 0.0}, Case{"BlBBm", 0, 2, 2, 3, 0.5}}) {
    SCOPED_TRACE(c.marks);
    const analysis::VarusChoice choice = choice_of(row_of(c.marks));
    EXPECT_EQ(choice.source, store::ZeroVarusSource::both_touch);
    EXPECT_EQ(choice.first_deg, c.first_deg);
    EXPECT_EQ(choice.last_deg, c.last_deg);
    EXPECT_EQ(choice.varus_deg, 0.5 * (c.first_deg + c.last_deg));
    EXPECT_EQ(choice.before, c.before);
    EXPECT_EQ(choice.after, c.after);
    EXPECT_EQ(choice.weight_after, c.share_after);
  }
}

TEST(VarusChoice, ABandAtTheBorderIsCutOff)
{
  for (const char* marks : {"BBlll", "llmBB", "BBBBB", "BxxBm"}) {
    SCOPED_TRACE(marks);
    EXPECT_TRUE(choice_of(row_of(marks)).is_cut_off);
  }
  // A band inside; the band of two that is not at the border; a root; an unsolved border next to the band.
  for (const char* marks : {"lBBBm", "BllBm", "lllmm", "lmBBx"}) {
    SCOPED_TRACE(marks);
    EXPECT_FALSE(choice_of(row_of(marks)).is_cut_off);
  }
}

TEST(VarusChoice, AColumnAMereRoundingAwayIsMeant)
{
  store::MotionModel model = row_of("lBBBm");
  model.varus_deg[2] += 1e-13;
  const analysis::VarusChoice choice = choice_of(model);
  EXPECT_EQ(choice.before, 2);
  EXPECT_EQ(choice.after, 2);
}

TEST(VarusChoice, ElseTheRootOfTheImbalance)
{
  const analysis::VarusChoice choice = choice_of(row_of("lllmm"));
  EXPECT_EQ(choice.source, store::ZeroVarusSource::interpolated);
  // 0.5 mm at 0 degrees, -1 mm at 2.
  EXPECT_NEAR(choice.varus_deg, 2.0 / 3.0, rounding_deg);
  EXPECT_NEAR(choice.weight_after, 1.0 / 3.0, rounding_deg);
  EXPECT_EQ(choice.before, 2);
  EXPECT_EQ(choice.after, 3);
  EXPECT_TRUE(std::isnan(choice.first_deg));
  EXPECT_TRUE(std::isnan(choice.last_deg));
}

TEST(VarusChoice, OfSeveralRootsTheNearestToTheSpine)
{
  // Roots at -3, 1 and 3.
  store::MotionModel model = row_of("lmlml", {1, -1, -1, 1, -1});
  EXPECT_NEAR(choice_of(model).varus_deg, 1.0, rounding_deg);
  model.is_spine.setZero();
  model.is_spine(0, 0) = 1;
  EXPECT_NEAR(choice_of(model).varus_deg, -3.0, rounding_deg);
  // Of two at equal distance the lower.
  EXPECT_NEAR(choice_of(row_of("lmmll", {1, -1, -1, -1, 1})).varus_deg, -3.0, rounding_deg);
  EXPECT_NEAR(choice_of(row_of("lmmml", {-1, 1, 1, -1, -1})).varus_deg, 1.0, rounding_deg);
}

TEST(VarusChoice, ARootOnAColumnIsThatColumn)
{
  const analysis::VarusChoice choice = choice_of(row_of("llllm", {3, 2, 1, 0, -1}));
  EXPECT_EQ(choice.source, store::ZeroVarusSource::interpolated);
  EXPECT_EQ(choice.varus_deg, 2.0);
  EXPECT_EQ(choice.before, 3);
  EXPECT_EQ(choice.after, 3);
}

TEST(VarusChoice, ColumnsWithoutAnImbalanceAreLeftOut)
{
  store::MotionModel model = row_of("lllmm", {4, 2, 1, -1, -3});
  model.gap_medial_mm(0, 2) = std::numeric_limits<double>::quiet_NaN();
  test::unsolve(model, 0, 3);
  // 2 mm at -2 degrees, -3 mm at 4; the pose comes from the solved neighbours, at 0 and 4.
  const analysis::VarusChoice choice = choice_of(model);
  EXPECT_NEAR(choice.varus_deg, 0.4, rounding_deg);
  EXPECT_EQ(choice.before, 2);
  EXPECT_EQ(choice.after, 4);
  EXPECT_NEAR(choice.weight_after, 0.1, rounding_deg);
}

TEST(VarusChoice, NoneWhereNothingChangesSign)
{
  for (const char* marks : {"lllll", "xxxxx", "xxlxx"}) {
    SCOPED_TRACE(marks);
    const analysis::VarusChoice choice = choice_of(row_of(marks, {5, 4, 3, 2, 1}));
    EXPECT_EQ(choice.source, store::ZeroVarusSource::none);
    EXPECT_TRUE(std::isnan(choice.varus_deg));
  }
}

TEST(VarusChoice, AFreeVarusIsTaken)
{
  ModelPlan plan;
  plan.varus_deg = {0};
  plan.free_varus_deg = [](double flexion_deg) { return 1.0 + 0.01 * flexion_deg; };
  store::MotionModel model = model_of(plan);
  model.contact_medial.setZero();
  test::unsolve(model, 2, 0);
  const std::vector<analysis::VarusChoice> choices =
      analysis::varus_choices(model, store::Motion(model, "raw"));
  ASSERT_EQ(choices.size(), 7u);
  EXPECT_EQ(choices[1].source, store::ZeroVarusSource::free);
  EXPECT_EQ(choices[1].varus_deg, 1.0 + 0.01 * 15.0);
  EXPECT_EQ(choices[2].source, store::ZeroVarusSource::none);
}

}  // namespace vrda::varus_choice_test
