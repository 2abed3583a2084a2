#include "cluster/task_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cluster/submission_scenes.hpp"

namespace vrda::task_state_test {

TEST(TaskState, ComesBackAsItWasWritten)
{
  const test::Scratch scratch;
  const Submission submission = test::one_case(3);
  const std::string folder = test::folder_with(scratch, submission);
  const TaskId task{TaskKind::shard, 0, 2};
  EXPECT_FALSE(read_task_state(folder, submission, task));
  for (const TaskPhase phase :
       {TaskPhase::running, TaskPhase::done, TaskPhase::failed, TaskPhase::interrupted}) {
    TaskState state = begun_now(12);
    state.phase = phase;
    state.n_restarts = 3;
    state.slurm_job = "13_2";
    state.exit_code = phase == TaskPhase::running ? 0 : 4;
    state.reason = "a \"reason\"\xff";
    write_task_state(folder, submission, task, state);
    const auto read = read_task_state(folder, submission, task);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->phase, phase);
    EXPECT_EQ(read->host, state.host);
    EXPECT_EQ(read->begun, state.begun);
    EXPECT_EQ(read->n_done_at_begin, 12);
    EXPECT_EQ(read->n_restarts, 3);
    EXPECT_EQ(read->exit_code, state.exit_code);
    EXPECT_EQ(read->slurm_job, "13_2");
    EXPECT_EQ(read->reason, "a \"reason\"\xef\xbf\xbd");
  }
}

TEST(TaskState, ADamagedFileIsNoState)
{
  const test::Scratch scratch;
  const Submission submission = test::one_case(2);
  const std::string folder = test::folder_with(scratch, submission);
  for (const std::string text : {"", "{", "{}", "{\"state\":\"asleep\"}", "[1]"}) {
    scratch.write("submission/tasks/knee.spine.json", text);
    EXPECT_FALSE(read_task_state(folder, submission, {TaskKind::spine, 0, 0})) << text;
  }
  EXPECT_TRUE(read_task_states(folder, submission).empty());
}

TEST(TaskState, AllThatBeganAreFound)
{
  const test::Scratch scratch;
  const Submission submission = test::campaign(3, 2);
  const std::string folder = test::folder_with(scratch, submission);
  const std::vector<TaskId> begun{
      {TaskKind::spine, 0, 0}, {TaskKind::shard, 1, 2}, {TaskKind::merge, 2, 0}, {TaskKind::index, -1, 0}};
  for (const TaskId& task : begun) write_task_state(folder, submission, task, begun_now(0));
  const auto states = read_task_states(folder, submission);
  EXPECT_EQ(states.size(), begun.size());
  for (const TaskId& task : begun) EXPECT_EQ(states.count(task), 1U);
}

TEST(TaskState, AStartIsToldFromAnotherByJobAndRestarts)
{
  const TaskState first = test::state_of(TaskPhase::running, "13_2");
  TaskState again = first, elsewhere = first;
  EXPECT_TRUE(is_same_start(first, again));
  again.n_restarts = 1;
  elsewhere.slurm_job = "14_2";
  EXPECT_FALSE(is_same_start(first, again));
  EXPECT_FALSE(is_same_start(first, elsewhere));
}

TEST(TaskState, TimesAreInUtc)
{
  EXPECT_EQ(utc_text(std::chrono::system_clock::time_point(std::chrono::seconds(86400))),
            "1970-01-02T00:00:00Z");
}

}  // namespace vrda::task_state_test
