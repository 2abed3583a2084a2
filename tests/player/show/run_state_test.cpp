#include "show/run_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/models.hpp"

namespace vrda::run_state_test {

using testing::ElementsAre;

show::RunStep cell(int flexion, int varus, StepStatus status = StepStatus::stable)
{
  show::RunStep step;
  step.key = {StepKind::row, flexion, varus};
  step.status = status;
  return step;
}

show::RunStep move(bool in_contact)
{
  show::RunStep step = cell(1, 1);
  step.kind = show::RunStepKind::move;
  step.in_contact = in_contact;
  return step;
}

show::RunStep probe(StepKind kind, int varus)
{
  show::RunStep step = cell(0, varus);
  step.key.kind = kind;
  step.kind = show::RunStepKind::probe;
  return step;
}

store::MotionModel model()
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10};
  plan.varus_deg = {-1, 0, 1};
  return store::with_pending_cells(test::model_of(plan));
}

TEST(RunState, ShowsTheStepsChosenAndFillsInTheGridWithAll)
{
  const std::vector<show::RunStep> steps{probe(StepKind::spine_probe, 1), move(false), move(true), cell(0, 1),
                                         cell(0, 0, StepStatus::no_contact)};
  const auto shown = [&](show::StepChoice choice) {
    show::RunState state(model(), choice);
    std::vector<bool> is_shown;
    for (const show::RunStep& step : steps) is_shown.push_back(state.add_step(step));
    EXPECT_EQ(state.n_done(), 2);
    EXPECT_EQ(state.panel().status(0, 0), static_cast<std::int8_t>(StepStatus::no_contact));
    EXPECT_EQ(state.panel().status(0, 1), 0);
    EXPECT_EQ(state.panel().status(1, 1), -1);
    EXPECT_EQ(state.n_shown(), std::count(is_shown.begin(), is_shown.end(), true));
    return is_shown;
  };
  EXPECT_THAT(shown(show::StepChoice::stable), ElementsAre(false, false, false, true, false));
  EXPECT_THAT(shown(show::StepChoice::contact), ElementsAre(true, false, true, true, false));
  EXPECT_THAT(shown(show::StepChoice::all), ElementsAre(true, true, true, true, true));
}

TEST(RunState, SaysWhereTheRunIs)
{
  show::RunState state(model(), show::StepChoice::stable);
  EXPECT_EQ(state.progress_text(), "0/6 attitudes");
  EXPECT_EQ(state.current_attitude(), "");
  state.add_step(cell(1, 2, StepStatus::unbounded));
  EXPECT_EQ(state.progress_text(), "1/6 attitudes");
  EXPECT_EQ(state.current_attitude(), "flexion 10, varus 1");
  // Its number is the index of a start, not a grid cell.
  state.add_step(probe(StepKind::free_spine, 7));
  EXPECT_EQ(state.current_attitude(), "flexion 10, varus 1");
  ASSERT_TRUE(state.panel().current);
  EXPECT_EQ(state.panel().current->varus, 2);
}

TEST(RunState, AFinishedRunShowsTheResult)
{
  show::RunState state(model(), show::StepChoice::stable);
  state.add_step(cell(0, 0));
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10};
  plan.varus_deg = {-1, 0, 1};
  state.finish(test::model_of(plan));
  EXPECT_EQ(state.progress_text(), "6/6 attitudes, finished");
  EXPECT_FALSE(state.shown());
  EXPECT_FALSE(state.panel().current);
}

}  // namespace vrda::run_state_test
