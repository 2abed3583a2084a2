#include "run/status.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/files.hpp"
#include "run/sharded_case.hpp"

namespace vrda::status_test {

namespace fs = std::filesystem;
using test::merge;
using test::shard;
using test::spine;
using testing::HasSubstr;

class Status : public test::ShardedCase {
 protected:
  void run_locally(const run::TaskId& task)
  {
    seen_.states[task] = test::state_of(run::TaskStatus::running, "");
    seen_.locked.insert(task);
  }
};

TEST_F(Status, FollowsFromQueueAndStateFile)
{
  struct Row {
    const char* name;
    std::optional<run::TaskStatus> phase;  // of the task's state file, of job 13_1
    const char* queue;                     // null: never submitted; "": purged
    run::TaskStatus standing;
    const char* reason;
  };
  const std::vector<Row> rows{
      {"never submitted", {}, nullptr, run::TaskStatus::waiting, ""},
      {"in the queue", {}, "PENDING", run::TaskStatus::queued, "Priority"},
      {"in the queue again", run::TaskStatus::interrupted, "PENDING", run::TaskStatus::queued, "Priority"},
      {"just begun", {}, "RUNNING", run::TaskStatus::running, ""},
      {"running", run::TaskStatus::running, "RUNNING", run::TaskStatus::running, ""},
      {"out of time", run::TaskStatus::running, "TIMEOUT", run::TaskStatus::failed, "TIMEOUT (Priority)"},
      {"node lost", run::TaskStatus::running, "NODE_FAIL", run::TaskStatus::failed, "NODE_FAIL (Priority)"},
      {"out of memory", run::TaskStatus::running, "OUT_OF_MEMORY", run::TaskStatus::failed,
       "OUT_OF_MEMORY (Priority)"},
      {"cancelled", {}, "CANCELLED", run::TaskStatus::failed, "CANCELLED (Priority)"},
      {"cancelled, in order", run::TaskStatus::interrupted, "CANCELLED", run::TaskStatus::interrupted,
       "CANCELLED (Priority)"},
      {"failed", run::TaskStatus::failed, "FAILED", run::TaskStatus::failed, "its own reason"},
      {"about to end", run::TaskStatus::done, "COMPLETING", run::TaskStatus::done, ""},
      {"too many unsolved", run::TaskStatus::done, "FAILED", run::TaskStatus::done, ""},
      {"done, its state not yet seen", {}, "COMPLETED", run::TaskStatus::done, ""},
      {"done, an older state seen", run::TaskStatus::running, "COMPLETED", run::TaskStatus::done, ""},
      {"failed, whatever Slurm says", run::TaskStatus::failed, "COMPLETED", run::TaskStatus::failed,
       "its own reason"},
      {"done and forgotten", run::TaskStatus::done, "", run::TaskStatus::done, ""},
      {"failed and forgotten", run::TaskStatus::failed, "", run::TaskStatus::failed, "its own reason"},
      {"interrupted and forgotten", run::TaskStatus::interrupted, "", run::TaskStatus::interrupted, ""},
      {"gone", run::TaskStatus::running, "", run::TaskStatus::lost, "Slurm has no record of the job"},
      {"never begun and gone",
       {},
       "",
       run::TaskStatus::lost,
       "Slurm has no record of the job, and it never started"},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    seen_ = {};
    const run::TaskId task{run::TaskKind::merge, 0, 0};
    if (row.phase) {
      const bool is_failed = *row.phase == run::TaskStatus::failed;
      seen_.states[task] = test::state_of(*row.phase, "13_1", is_failed ? "its own reason" : "");
    }
    if (row.queue != nullptr) seen_.slurm[task] = {"13_1", {"13", 1, row.queue, "n2", "Priority"}};
    const run::TaskView view = view_of(task);
    EXPECT_STREQ(name_of(view.status), name_of(row.standing));
    EXPECT_EQ(view.reason, row.reason);
  }
}

TEST_F(Status, TheStateOfAnEarlierJobIsIgnored)
{
  seen_.states[merge] = test::state_of(run::TaskStatus::failed, "13", "of old");
  seen_.slurm[merge] = {"20", {"20", 0, "TIMEOUT", "n1", ""}};
  EXPECT_EQ(view_of(merge).reason, "TIMEOUT");
  seen_.slurm[merge].row = {};
  EXPECT_EQ(view_of(merge).status, run::TaskStatus::lost);
  // Repeated since by a local process.
  seen_.slurm[merge].row = {"20", 0, "TIMEOUT", "n1", ""};
  seen_.states[merge] = test::state_of(run::TaskStatus::done, "");
  EXPECT_EQ(view_of(merge).status, run::TaskStatus::done);
}

TEST_F(Status, WhatCanNoLongerBeginSaysWhy)
{
  seen_.slurm[merge] = {"14", {"14", 0, "PENDING", "", "DependencyNeverSatisfied"}};
  const run::TaskView view = view_of(merge);
  EXPECT_EQ(view.status, run::TaskStatus::failed);
  EXPECT_THAT(view.reason, HasSubstr("depends on"));
}

// On any host, since the lock is on the shared file system.
TEST_F(Status, ALocalTaskRunsWhileItHoldsItsLock)
{
  run::TaskState state = test::state_of(run::TaskStatus::running, "", "waits");
  state.host = "node17";
  run::write_task_state(folder_, submission_, shard(1), state);
  auto lock = OutputLock::acquire(run::task_file_of(folder_, submission_, shard(1)), "vrda task", {});
  seen_ = run::take_snapshot(folder_, submission_);
  EXPECT_THAT(seen_.locked, testing::ElementsAre(shard(1)));
  EXPECT_EQ(view_of(shard(1)).status, run::TaskStatus::running);
  EXPECT_EQ(view_of(shard(1)).host, "node17");
  // It counts as missing: a repetition waits for the lock.
  ASSERT_EQ(missing().work.cases.size(), 1U);
  EXPECT_THAT(missing().work.cases[0].shards, testing::Contains(1));
  EXPECT_THAT(missing().reasons, testing::Contains("shard 1 of 3: running: waits"));
  EXPECT_EQ(missing().n_active, 0);
  lock.reset();
  seen_ = run::take_snapshot(folder_, submission_);
  EXPECT_THAT(seen_.locked, testing::IsEmpty());
  EXPECT_EQ(view_of(shard(1)).status, run::TaskStatus::lost);
  EXPECT_EQ(view_of(shard(1)).reason, "its process no longer exists");
  EXPECT_THAT(missing().work.cases.at(0).shards, testing::Contains(1));
}

TEST_F(Status, ACompletedTaskWithoutItsJournalIsNotDone)
{
  seen_.slurm[shard(1)] = {"13_1", {"13", 1, "COMPLETED", "n1", "None"}};
  EXPECT_EQ(view_of(shard(1)).status, run::TaskStatus::lost);
  EXPECT_EQ(view_of(shard(1)).reason, "its journal is missing");
  write_shard(1, 3);
  EXPECT_EQ(view_of(shard(1)).status, run::TaskStatus::done);
}

TEST_F(Status, ALostTaskQuotesSlurmFromItsLog)
{
  scratch_.write("submission/logs/knee.shard-2-of-3.log",
                 "loading\nslurmstepd: error: *** JOB 14 ON n1 CANCELLED DUE TO NODE FAILURE ***\n");
  seen_.states[shard(2)] = test::state_of(run::TaskStatus::running, "13_2");
  seen_.slurm[shard(2)] = {"13_2", {}, "knee.shard-2-of-3.log"};
  EXPECT_EQ(view_of(shard(2)).reason, "*** JOB 14 ON n1 CANCELLED DUE TO NODE FAILURE ***");
}

TEST_F(Status, WithoutAnAnswerOfSlurmNothingIsLost)
{
  seen_.remark = "no answer";
  seen_.slurm[shard(1)] = {"13_1", {}};
  seen_.slurm[shard(2)] = {"13_2", {}};
  seen_.states[shard(2)] = test::state_of(run::TaskStatus::running, "13_2");
  EXPECT_EQ(view_of(shard(1)).status, run::TaskStatus::queued);
  EXPECT_EQ(view_of(shard(2)).status, run::TaskStatus::running);
}

TEST_F(Status, CountsTheAttitudesOfItsOwnRows)
{
  // Rows 0, 3, 6: two of them with 5 cells each, and of the third the spine's cell only.
  write_spine();
  write_shard(1, 2);
  run_locally(shard(1));
  const run::TaskView view = view_of(shard(1));
  EXPECT_EQ(view.n_total, 15);
  EXPECT_EQ(view.n_done, 11);
  run_locally(spine);
  EXPECT_EQ(view_of(spine).n_done, 7);
  EXPECT_EQ(view_of(spine).n_total, 7);
}

// From the modification times of the files, so changes of the clock and other machines' clocks do not matter.
TEST_F(Status, TheRateIsOfThisStart)
{
  write_shard(1, 2);
  run_locally(shard(1));
  run::TaskState& state = seen_.states[shard(1)];
  state.n_done_at_start = 6;
  state.started = "2999-01-01T00:00:00Z";
  run::write_task_state(folder_, submission_, shard(1), state);
  const auto begun = fs::last_write_time(run::task_file_of(folder_, submission_, shard(1)));
  const fs::path journal = store::shard_journal_of(output(), {1, 3});
  fs::last_write_time(journal, begun - std::chrono::hours(1));
  EXPECT_FALSE(view_of(shard(1)).per_second);
  EXPECT_FALSE(view_of(shard(1)).seconds_left);
  fs::last_write_time(journal, begun + std::chrono::seconds(2));
  const run::TaskView view = view_of(shard(1));
  EXPECT_NEAR(view.per_second.value(), 4.0 / 2.0, 1e-6);
  EXPECT_NEAR(view.seconds_left.value(), 5.0 / 2.0, 1e-6);
  EXPECT_EQ(run::rate_text(*view.per_second, view.seconds_left), "2/s, 0:03 left");
}

TEST_F(Status, SumsUp)
{
  write_spine();
  seen_.states[spine] = test::state_of(run::TaskStatus::done, "12");
  seen_.slurm[spine] = {"12", {}};
  write_shard(1, 3);
  seen_.states[shard(1)] = test::state_of(run::TaskStatus::done, "13_1");
  seen_.slurm[shard(1)] = {"13_1", {"13", 1, "COMPLETED", "n1", "None"}};
  write_shard(2, 1);
  seen_.states[shard(2)] = test::state_of(run::TaskStatus::running, "13_2");
  seen_.states[shard(2)].n_done_at_start = 6;
  seen_.slurm[shard(2)] = {"13_2", {"13", 2, "RUNNING", "n2", "None"}};
  seen_.slurm[shard(3)] = {"13_3", {"13", 3, "PENDING", "", "Resources"}};
  const run::StatusView status = run::status_of(folder_, submission_, seen_);
  EXPECT_EQ(run::summary_of(status, submission_),
            "1 of 3 shards done, 1 running, 1 queued; 21 of 35 attitudes");
  EXPECT_EQ(status.cases[0].status, run::TaskStatus::running);
}

TEST_F(Status, AMadeCaseIsDoneWhateverItsTasksSay)
{
  scratch_.write("submission/knee.h5", "model");
  seen_.states[shard(1)] = test::state_of(run::TaskStatus::failed, "", "of old");
  EXPECT_EQ(view_of(shard(1)).status, run::TaskStatus::done);
  EXPECT_EQ(view_of(shard(1)).reason, "");
  EXPECT_TRUE(missing().work.is_empty());
}

TEST(StatusOfCampaign, CountsCases)
{
  const test::Scratch scratch;
  const run::Submission submission = test::campaign(4, 1);
  const std::string folder = test::folder_with(scratch, submission);
  scratch.write("submission/case-1/case-1.h5", "model");
  run::SubmissionSnapshot seen;
  seen.states[{run::TaskKind::run, 1, 0}] = test::state_of(run::TaskStatus::running, "");
  seen.locked = {{run::TaskKind::run, 1, 0}};
  seen.states[{run::TaskKind::run, 2, 0}] = test::state_of(run::TaskStatus::failed, "", "bad mesh");
  EXPECT_EQ(run::summary_of(run::status_of(folder, submission, seen), submission),
            "1 of 4 cases done, 1 running, 1 waiting, 1 failed; 35 of 140 attitudes");
}

TEST(StatusText, DurationsReadAsTimes)
{
  EXPECT_EQ(run::duration_text(10.6), "0:11");
  EXPECT_EQ(run::duration_text(7530.0), "2:05:30");
  EXPECT_EQ(run::duration_text(3.5 * 86400.0), "3 days");
  EXPECT_EQ(run::duration_text(1e12), "over 100 days");
  EXPECT_EQ(run::duration_text(std::nan("")), "over 100 days");
}

}  // namespace vrda::status_test
