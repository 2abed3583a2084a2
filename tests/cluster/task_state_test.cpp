#include "cluster/task_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>

#include "cluster/submission_scenes.hpp"
#include "support/process.hpp"

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
    state.n_done_at_end = 20;
    write_task_state(folder, submission, task, state);
    const auto read = read_task_state(folder, submission, task);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->phase, phase);
    EXPECT_EQ(read->process.pid, getpid());
    EXPECT_EQ(read->begun, state.begun);
    EXPECT_EQ(read->begun_at.boot, state.begun_at.boot);
    EXPECT_EQ(read->begun_at.seconds, state.begun_at.seconds);
    EXPECT_EQ(read->n_done_at_begin, 12);
    EXPECT_EQ(read->n_done_at_end, 20);
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

TEST(TaskState, AProcessIsToldFromAnotherOfItsNumber)
{
  ProcessId own = own_process();
  EXPECT_EQ(is_alive(own), true);
  own.started += 1;
  EXPECT_EQ(is_alive(own), false);
  own.host += "-else";
  EXPECT_EQ(is_alive(own), std::nullopt);
  EXPECT_EQ(is_alive({host_name(), 0, 0}), false);
}

// A kernel's clock since the start of the machine does not follow a clock that is set anew.
TEST(TaskState, MomentsAreComparedOnOneMachineOnly)
{
  const Moment begin = now();
  EXPECT_FALSE(begin.boot.empty());
  EXPECT_GE(seconds_between(begin, now()).value(), 0.0);
  EXPECT_DOUBLE_EQ(seconds_between({"a", 10.0}, {"a", 12.5}).value(), 2.5);
  EXPECT_FALSE(seconds_between({"a", 10.0}, {"b", 12.5}));
  EXPECT_FALSE(seconds_between({"a", 10.0}, {"a", 9.0}));
  EXPECT_FALSE(seconds_between({"", 10.0}, {"", 12.0}));
}

TEST(TaskState, TimesAreInUtc)
{
  EXPECT_EQ(utc_text(std::chrono::system_clock::time_point(std::chrono::seconds(86400))),
            "1970-01-02T00:00:00Z");
}

}  // namespace vrda::task_state_test
