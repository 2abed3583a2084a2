#include "analysis/reduce.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/models.hpp"

namespace vrda::analysis::varus_choice_test {

using test::model_of;
using test::ModelPlan;

// Rounding of a root: a product and a quotient of degrees below 10.
constexpr double rounding_deg = 1e-14;

/// One flexion with columns at -4, -2, 0, 2 and 4 degrees and these contacts: B both, m medial, l lateral, x
/// unsolved. `imbalance_mm` per column (NaN: the medial side faces nothing); the spine is at the middle one.
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
    model.gap_medial_mm(0, j) = imbalance < 0.0 ? 0.0 : imbalance;
    model.gap_lateral_mm(0, j) = imbalance > 0.0 ? 0.0 : -imbalance;
    if (mark == 'x') test::unsolve(model, 0, j);
  }
  return model;
}

VarusChoice choice_of(const store::MotionModel& model)
{
  return varus_choices(model, store::Motion(model, "raw")).at(0);
}

TEST(VarusChoice, ByContactsAndGaps)
{
  using enum store::ZeroVarusSource;
  struct Case {
    const char* marks;
    std::vector<double> imbalance_mm;
    store::ZeroVarusSource source;
    double first_deg, last_deg, varus_deg;
    Eigen::Index before, after;
    double weight_after;
    bool is_cut_off;
  };
  const std::vector<double> falling{4, 2, 0.5, -1, -3};
  for (const Case& c :
       {Case{"llBmm", falling, both_touch, 0, 0, 0, 2, 2, 0.0, false},
        Case{"lBBBm", falling, both_touch, -2, 2, 0, 2, 2, 0.0, false},
        Case{"llBBm", falling, both_touch, 0, 2, 1, 2, 3, 0.5, false},
        Case{"BBBBB", falling, both_touch, -4, 4, 0, 2, 2, 0.0, true},
        // A hole between columns in contact does not split the run.
        Case{"lBxBm", falling, both_touch, -2, 2, 0, 1, 3, 0.5, false},
        Case{"BxxBm", falling, both_touch, -4, 2, -1, 0, 3, 0.5, true},
        // Of two runs the one nearest to the spine at 0; only the border of that one matters.
        Case{"BllBm", falling, both_touch, 2, 2, 2, 3, 3, 0.0, false},
        Case{"BlBBm", falling, both_touch, 0, 2, 1, 2, 3, 0.5, false},
        Case{"llmBB", falling, both_touch, 2, 4, 3, 3, 4, 0.5, true},
        Case{"lmBBx", falling, both_touch, 0, 2, 1, 2, 3, 0.5, false},
        // Without both contacts the root of the imbalance: 0.5 mm at 0 degrees, -1 mm at 2.
        Case{"lllmm", falling, interpolated, nan, nan, 2.0 / 3.0, 2, 3, 1.0 / 3.0, false},
        Case{"llllm", {3, 2, 1, 0, -1}, interpolated, nan, nan, 2, 3, 3, 0.0, false},
        // 2 mm at -2 degrees, -3 mm at 4: columns without gaps count for the pose only, unsolved ones not.
        Case{"lllxm", {4, 2, nan, -1, -3}, interpolated, nan, nan, 0.4, 2, 4, 0.1, false},
        // Nothing changes its sign.
        Case{"lllll", {5, 4, 3, 2, 1}, none, nan, nan, nan, 0, 0, 0.0, false},
        Case{"xxxxx", falling, none, nan, nan, nan, 0, 0, 0.0, false},
        Case{"xxlxx", falling, none, nan, nan, nan, 0, 0, 0.0, false}}) {
    SCOPED_TRACE(c.marks);
    const VarusChoice choice = choice_of(row_of(c.marks, c.imbalance_mm));
    EXPECT_EQ(choice.source, c.source);
    EXPECT_THAT(choice.first_deg, testing::NanSensitiveDoubleEq(c.first_deg));
    EXPECT_THAT(choice.last_deg, testing::NanSensitiveDoubleEq(c.last_deg));
    EXPECT_THAT(choice.varus_deg, testing::NanSensitiveDoubleNear(c.varus_deg, rounding_deg));
    EXPECT_EQ(choice.before, c.before);
    EXPECT_EQ(choice.after, c.after);
    EXPECT_NEAR(choice.weight_after, c.weight_after, rounding_deg);
    EXPECT_EQ(choice.is_cut_off, c.is_cut_off);
  }
}

TEST(VarusChoice, AColumnAMereRoundingAwayIsMeant)
{
  store::MotionModel model = row_of("lBBBm");
  model.varus_deg[2] += 1e-13;
  const VarusChoice choice = choice_of(model);
  EXPECT_EQ(choice.before, 2);
  EXPECT_EQ(choice.after, 2);
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

TEST(VarusChoice, AFreeVarusIsTaken)
{
  ModelPlan plan;
  plan.varus_deg = {0};
  plan.free_varus_deg = [](double flexion_deg) { return 1.0 + 0.01 * flexion_deg; };
  store::MotionModel model = model_of(plan);
  model.contact_medial.setZero();
  test::unsolve(model, 2, 0);
  const std::vector<VarusChoice> choices = varus_choices(model, store::Motion(model, "raw"));
  ASSERT_EQ(choices.size(), 7u);
  EXPECT_EQ(choices[1].source, store::ZeroVarusSource::free);
  EXPECT_EQ(choices[1].varus_deg, 1.0 + 0.01 * 15.0);
  EXPECT_EQ(choices[2].source, store::ZeroVarusSource::none);
}

}  // namespace vrda::analysis::varus_choice_test
