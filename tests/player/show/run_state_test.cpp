#include "show/run_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/models.hpp"

namespace vrda::show::run_state_test {

using testing::ElementsAre;

RunStep cell(int flexion, int varus, StepStatus status = StepStatus::stable)
{
  RunStep step;
  step.key = {StepKind::row, flexion, varus};
  step.status = status;
  return step;
}

RunStep move(bool in_contact)
{
  RunStep step = cell(1, 1);
  step.kind = RunStepKind::move;
  step.in_contact = in_contact;
  return step;
}

RunStep probe(StepKind kind, int varus)
{
  RunStep step = cell(0, varus);
  step.key.kind = kind;
  step.kind = RunStepKind::probe;
  return step;
}

store::MotionModel model()
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10};
  plan.varus_deg = {-1, 0, 1};
  return store::with_pending_cells(test::model_of(plan));
}

// Shows the steps chosen and fills in the grid with all.
TEST(RunState, ChosenSteps)
{
  const std::vector<RunStep> steps{probe(StepKind::spine_probe, 1), move(false), move(true), cell(0, 1),
                                   cell(0, 0, StepStatus::no_contact)};
  const auto shown = [&](StepChoice choice) {
    RunState state(model(), choice);
    std::vector<bool> is_shown;
    for (const RunStep& step : steps) is_shown.push_back(state.add_step(step));
    EXPECT_EQ(state.n_done(), 2);
    EXPECT_EQ(state.grid().status(0, 0), static_cast<std::int8_t>(StepStatus::no_contact));
    EXPECT_EQ(state.grid().status(0, 1), 0);
    EXPECT_EQ(state.grid().status(1, 1), -1);
    EXPECT_EQ(state.n_shown(), std::count(is_shown.begin(), is_shown.end(), true));
    return is_shown;
  };
  EXPECT_THAT(shown(StepChoice::stable), ElementsAre(false, false, false, true, false));
  EXPECT_THAT(shown(StepChoice::contact), ElementsAre(true, false, true, true, false));
  EXPECT_THAT(shown(StepChoice::all), ElementsAre(true, true, true, true, true));
}

TEST(RunState, SaysWhereTheRunIs)
{
  RunState state(model(), StepChoice::stable);
  EXPECT_EQ(state.progress_text(), "0/6 attitudes");
  EXPECT_EQ(state.current_attitude(), "");
  state.add_step(cell(1, 2, StepStatus::unbounded));
  EXPECT_EQ(state.progress_text(), "1/6 attitudes");
  EXPECT_EQ(state.current_attitude(), "flexion 10, varus 1");
  // Its number is the index of a start, not a grid cell.
  state.add_step(probe(StepKind::free_spine, 7));
  EXPECT_EQ(state.current_attitude(), "flexion 10, varus 1");
  ASSERT_TRUE(state.grid().current);
  EXPECT_EQ(state.grid().current->varus, 2);
}

}  // namespace vrda::show::run_state_test
