#include "cluster/status.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "cluster/missing.hpp"
#include "cluster/shard.hpp"
#include "cluster/submission_scenes.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const TaskId spine{TaskKind::spine, 0, 0};
const TaskId merge{TaskKind::merge, 0, 0};

TaskId shard(std::int32_t number)
{
  return {TaskKind::shard, 0, number};
}

// One case in three shards.
class Status : public testing::Test {
 protected:
  Status() : submission_(test::one_case(3)), folder_(test::folder_with(scratch_, submission_)) {}

  TaskView view_of(const TaskId& task) const
  {
    const StatusView status = status_of(folder_, submission_, seen_);
    for (const TaskView& view : status.cases.front().tasks) {
      if (view.task == task) return view;
    }
    ADD_FAILURE() << "no such task";
    return {};
  }

  std::string output() const { return output_of(folder_, submission_.cases[0]); }

  void write_spine() const { test::write_journal(spine_journal_of(output()), {0, 1, 2, 3, 4, 5, 6}, 1, 0); }
  // Its row cells; the spine has column 0.
  void write_shard(std::int32_t number, std::size_t n_rows) const
  {
    std::vector<std::int32_t> rows = rows_of({number, 3}, 7);
    rows.resize(n_rows);
    test::write_journal(shard_journal_of(output(), {number, 3}), rows, 5);
  }

  void all_but_the_merge_is_done()
  {
    write_spine();
    seen_.states[spine] = test::state_of(TaskPhase::done, "");
    for (const std::int32_t k : {1, 2, 3}) {
      write_shard(k, rows_of({k, 3}, 7).size());
      seen_.states[shard(k)] = test::state_of(TaskPhase::done, "");
    }
  }

  Missing missing() const
  {
    return missing_of(folder_, submission_, status_of(folder_, submission_, seen_), seen_);
  }

  test::Scratch scratch_;
  Submission submission_;
  std::string folder_;
  Sightings seen_;
};

TEST_F(Status, StandsAsQueueAndStateSay)
{
  struct Row {
    const char* name;
    std::optional<TaskPhase> phase;  // of the task's own state, of job 13_1
    const char* queue;               // nothing: never submitted; "": forgotten
    TaskStanding standing;
    const char* reason;
  };
  const std::vector<Row> rows{
      {"never submitted", {}, nullptr, TaskStanding::waiting, ""},
      {"in the queue", {}, "PENDING", TaskStanding::queued, "Priority"},
      {"in the queue again", TaskPhase::interrupted, "PENDING", TaskStanding::queued, "Priority"},
      {"just begun", {}, "RUNNING", TaskStanding::running, ""},
      {"running", TaskPhase::running, "RUNNING", TaskStanding::running, ""},
      {"out of time", TaskPhase::running, "TIMEOUT", TaskStanding::failed, "TIMEOUT (Priority)"},
      {"node lost", TaskPhase::running, "NODE_FAIL", TaskStanding::failed, "NODE_FAIL (Priority)"},
      {"out of memory", TaskPhase::running, "OUT_OF_MEMORY", TaskStanding::failed,
       "OUT_OF_MEMORY (Priority)"},
      {"cancelled", {}, "CANCELLED", TaskStanding::failed, "CANCELLED (Priority)"},
      {"cancelled, in order", TaskPhase::interrupted, "CANCELLED", TaskStanding::interrupted,
       "CANCELLED (Priority)"},
      {"failed", TaskPhase::failed, "FAILED", TaskStanding::failed, "its own reason"},
      {"about to end", TaskPhase::done, "COMPLETING", TaskStanding::done, ""},
      {"too many unsolved", TaskPhase::done, "FAILED", TaskStanding::done, ""},
      {"done and forgotten", TaskPhase::done, "", TaskStanding::done, ""},
      {"failed and forgotten", TaskPhase::failed, "", TaskStanding::failed, "its own reason"},
      {"interrupted and forgotten", TaskPhase::interrupted, "", TaskStanding::interrupted, ""},
      {"gone", TaskPhase::running, "", TaskStanding::lost, "Slurm no longer knows the job"},
      {"never begun and gone",
       {},
       "",
       TaskStanding::lost,
       "Slurm no longer knows the job, and it never began"},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    seen_ = {};
    const TaskId task{TaskKind::merge, 0, 0};
    if (row.phase) {
      const bool is_failed = *row.phase == TaskPhase::failed;
      seen_.states[task] = test::state_of(*row.phase, "13_1", is_failed ? "its own reason" : "");
    }
    if (row.queue != nullptr) seen_.slurm[task] = {"13_1", {"13", 1, row.queue, "n2", "Priority"}};
    const TaskView view = view_of(task);
    EXPECT_STREQ(name_of(view.standing), name_of(row.standing));
    EXPECT_EQ(view.reason, row.reason);
  }
}

TEST_F(Status, AStateOfAnEarlierJobDoesNotSpeakForTheNextOne)
{
  seen_.states[merge] = test::state_of(TaskPhase::failed, "13", "of old");
  seen_.slurm[merge] = {"20", {"20", 0, "TIMEOUT", "n1", ""}};
  EXPECT_EQ(view_of(merge).reason, "TIMEOUT");
  seen_.slurm[merge].row = {};
  EXPECT_EQ(view_of(merge).standing, TaskStanding::lost);
  // Done here since, by a local process.
  seen_.slurm[merge].row = {"20", 0, "TIMEOUT", "n1", ""};
  seen_.states[merge] = test::state_of(TaskPhase::done, "");
  EXPECT_EQ(view_of(merge).standing, TaskStanding::done);
}

TEST_F(Status, WhatCanNoLongerBeginSaysWhy)
{
  seen_.slurm[merge] = {"14", {"14", 0, "PENDING", "", "DependencyNeverSatisfied"}};
  const TaskView view = view_of(merge);
  EXPECT_EQ(view.standing, TaskStanding::failed);
  EXPECT_THAT(view.reason, HasSubstr("what it waited for did not end well"));
}

TEST_F(Status, ALocalProcessThatIsGoneIsLost)
{
  seen_.states[shard(1)] = test::state_of(TaskPhase::running, "");
  EXPECT_EQ(view_of(shard(1)).standing, TaskStanding::running);
  seen_.states[shard(1)].process.started += 1;
  EXPECT_EQ(view_of(shard(1)).standing, TaskStanding::lost);
  seen_.states[shard(1)].process.host = "another";
  EXPECT_EQ(view_of(shard(1)).standing, TaskStanding::running);
}

TEST_F(Status, ALostTaskQuotesSlurmFromItsLog)
{
  scratch_.write("submission/logs/knee.shard-2-of-3.log",
                 "loading\nslurmstepd: error: *** JOB 14 ON n1 CANCELLED DUE TO NODE FAILURE ***\n");
  seen_.states[shard(2)] = test::state_of(TaskPhase::running, "13_2");
  seen_.slurm[shard(2)] = {"13_2", {}, "knee.shard-2-of-3.log"};
  EXPECT_EQ(view_of(shard(2)).reason, "*** JOB 14 ON n1 CANCELLED DUE TO NODE FAILURE ***");
}

TEST_F(Status, WithoutAnAnswerOfSlurmNothingIsLost)
{
  seen_.is_slurm_known = false;
  seen_.slurm[shard(1)] = {"13_1", {}};
  seen_.slurm[shard(2)] = {"13_2", {}};
  seen_.states[shard(2)] = test::state_of(TaskPhase::running, "13_2");
  EXPECT_EQ(view_of(shard(1)).standing, TaskStanding::queued);
  EXPECT_EQ(view_of(shard(2)).standing, TaskStanding::running);
}

TEST_F(Status, CountsTheAttitudesOfItsOwnRows)
{
  // Rows 0, 3, 6: two of them with 5 cells each, and of the third the spine's cell only.
  write_spine();
  write_shard(1, 2);
  seen_.states[shard(1)] = test::state_of(TaskPhase::running, "");
  const TaskView view = view_of(shard(1));
  EXPECT_EQ(view.n_total, 15);
  EXPECT_EQ(view.n_done, 11);
  seen_.states[spine] = test::state_of(TaskPhase::running, "");
  EXPECT_EQ(view_of(spine).n_done, 7);
  EXPECT_EQ(view_of(spine).n_total, 7);
}

TEST_F(Status, TheRateIsOfThisStart)
{
  write_shard(1, 2);
  TaskState state = test::state_of(TaskPhase::running, "");
  state.n_done_at_begin = 6;
  state.begun_at.seconds -= 2.0;
  seen_.states[shard(1)] = state;
  const TaskView view = view_of(shard(1));
  ASSERT_TRUE(view.per_second && view.seconds_left);
  // Four in two seconds and what this test takes.
  constexpr double slowest = 4.0 / 12.0;
  EXPECT_LE(*view.per_second, 2.0);
  EXPECT_GE(*view.per_second, slowest);
  EXPECT_DOUBLE_EQ(*view.seconds_left, 5.0 / *view.per_second);
}

TEST_F(Status, AClockThatJumpsGivesNoNonsense)
{
  write_shard(1, 2);
  const fs::path journal = shard_journal_of(output(), {1, 3});
  TaskState state = test::state_of(TaskPhase::running, "");
  state.begun = "2999-01-01T00:00:00Z";
  state.begun_at.seconds += 1000.0;  // in the future of this machine
  write_task_state(folder_, submission_, shard(1), state);
  const auto begun = fs::last_write_time(task_file_of(folder_, submission_, shard(1)));
  seen_.states[shard(1)] = state;
  // By the times of the files then; where the journal is older than the task, there is no rate.
  fs::last_write_time(journal, begun - std::chrono::hours(1));
  EXPECT_FALSE(view_of(shard(1)).per_second);
  EXPECT_FALSE(view_of(shard(1)).seconds_left);
  fs::last_write_time(journal, begun + std::chrono::seconds(5));
  EXPECT_NEAR(view_of(shard(1)).per_second.value(), 10.0 / 5.0, 1e-6);
  seen_.states[shard(1)].begun_at.boot = "another machine";
  EXPECT_NEAR(view_of(shard(1)).per_second.value(), 10.0 / 5.0, 1e-6);
}

TEST_F(Status, SumsUp)
{
  write_spine();
  seen_.states[spine] = test::state_of(TaskPhase::done, "12");
  seen_.slurm[spine] = {"12", {}};
  write_shard(1, 3);
  seen_.states[shard(1)] = test::state_of(TaskPhase::done, "13_1");
  seen_.slurm[shard(1)] = {"13_1", {"13", 1, "COMPLETED", "n1", "None"}};
  write_shard(2, 1);
  seen_.states[shard(2)] = test::state_of(TaskPhase::running, "13_2");
  seen_.states[shard(2)].n_done_at_begin = 6;
  seen_.slurm[shard(2)] = {"13_2", {"13", 2, "RUNNING", "n2", "None"}};
  seen_.slurm[shard(3)] = {"13_3", {"13", 3, "PENDING", "", "Resources"}};
  const StatusView status = status_of(folder_, submission_, seen_);
  EXPECT_EQ(summary_of(status, submission_), "1 of 3 shards done, 1 running, 1 queued; 21 of 35 attitudes");
  EXPECT_EQ(status.cases[0].standing, TaskStanding::running);
}

TEST_F(Status, AMadeCaseIsDoneWhateverItsTasksSay)
{
  scratch_.write("submission/knee.h5", "model");
  seen_.states[shard(1)] = test::state_of(TaskPhase::failed, "", "of old");
  const StatusView status = status_of(folder_, submission_, seen_);
  EXPECT_EQ(summary_of(status, submission_), "3 of 3 shards done; 35 of 35 attitudes");
  EXPECT_EQ(view_of(shard(1)).reason, "");
  EXPECT_TRUE(missing().work.is_nothing());
}

TEST(StatusOfCampaign, CountsCases)
{
  const test::Scratch scratch;
  const Submission submission = test::campaign(4, 1);
  const std::string folder = test::folder_with(scratch, submission);
  scratch.write("submission/case-1/case-1.h5", "model");
  Sightings seen;
  seen.states[{TaskKind::run, 1, 0}] = test::state_of(TaskPhase::running, "");
  seen.states[{TaskKind::run, 2, 0}] = test::state_of(TaskPhase::failed, "", "bad mesh");
  EXPECT_EQ(summary_of(status_of(folder, submission, seen), submission),
            "1 of 4 cases done, 1 running, 1 waiting, 1 failed; 35 of 140 attitudes");
}

TEST(StatusText, DurationsReadAsTimes)
{
  EXPECT_EQ(duration_text(10.6), "0:11");
  EXPECT_EQ(duration_text(7530.0), "2:05:30");
  EXPECT_EQ(duration_text(3.5 * 86400.0), "3 days");
  EXPECT_EQ(duration_text(1e12), "over 100 days");
  EXPECT_EQ(duration_text(std::nan("")), "over 100 days");
}

TEST_F(Status, OnlyTheMergeIsMissing)
{
  all_but_the_merge_is_done();
  const Missing found = missing();
  ASSERT_EQ(found.work.cases.size(), 1U);
  EXPECT_FALSE(found.work.cases[0].needs_spine);
  EXPECT_THAT(found.work.cases[0].shards, IsEmpty());
  EXPECT_THAT(found.reasons, ElementsAre("merge: waiting"));
}

TEST_F(Status, AJournalThatIsGoneOrShortIsMissingWhateverItsStateSays)
{
  all_but_the_merge_is_done();
  fs::remove(shard_journal_of(output(), {2, 3}));
  write_shard(3, 1);
  const Missing found = missing();
  ASSERT_EQ(found.work.cases.size(), 1U);
  EXPECT_THAT(found.work.cases[0].shards, ElementsAre(2, 3));
  EXPECT_FALSE(found.work.cases[0].needs_spine);
  EXPECT_THAT(found.reasons, ElementsAre("shard 2 of 3: lost: its journal is gone",
                                         "shard 3 of 3: its journal is not whole", "merge: waiting"));
}

TEST_F(Status, ALostSpineIsMissing)
{
  all_but_the_merge_is_done();
  fs::remove(spine_journal_of(output()));
  const Missing found = missing();
  ASSERT_EQ(found.work.cases.size(), 1U);
  EXPECT_TRUE(found.work.cases[0].needs_spine);
  // Its cells were part of every shard's rows.
  EXPECT_THAT(found.work.cases[0].shards, IsEmpty());
}

TEST_F(Status, WhatIsUnderWayIsNotSubmittedAgain)
{
  all_but_the_merge_is_done();
  seen_.states[shard(1)] = test::state_of(TaskPhase::failed, "13_1", "bad luck");
  seen_.slurm[shard(1)] = {"13_1", {"13", 1, "FAILED", "n1", "NonZeroExitCode"}};
  seen_.slurm[shard(2)] = {"13_2", {"13", 2, "RUNNING", "n1", ""}};
  seen_.slurm[merge] = {"14", {"14", 0, "PENDING", "", "Dependency"}};
  const Missing found = missing();
  ASSERT_EQ(found.work.cases.size(), 1U);
  EXPECT_THAT(found.work.cases[0].shards, ElementsAre(1));
  EXPECT_THAT(found.work.cases[0].shards_under_way, ElementsAre("13_2"));
  EXPECT_EQ(found.n_under_way, 2);
  // The merge in the queue would not wait for the new shard.
  EXPECT_THAT(found.to_cancel, ElementsAre("14"));
  EXPECT_THAT(found.reasons, ElementsAre("shard 1 of 3: failed: bad luck"));
  const std::vector<PlannedJob> jobs = jobs_of_work(submission_, found.work, {});
  ASSERT_EQ(jobs.size(), 2U);
  EXPECT_THAT(jobs[1].after, ElementsAre(0U));
  EXPECT_THAT(jobs[1].after_ids, ElementsAre("13_2"));
}

TEST_F(Status, NothingIsMissingWhileAllIsUnderWay)
{
  seen_.slurm[spine] = {"12", {"12", 0, "RUNNING", "n1", ""}};
  for (const std::int32_t k : {1, 2, 3}) {
    seen_.slurm[shard(k)] = {"13_" + std::to_string(k), {"13", k, "PENDING", "", "Dependency"}};
  }
  seen_.slurm[merge] = {"14", {"14", 0, "PENDING", "", "Dependency"}};
  const Missing found = missing();
  EXPECT_TRUE(found.work.is_nothing());
  EXPECT_EQ(found.n_under_way, 5);
}

TEST_F(Status, AQueuedMergeThatNeverCanBeginIsCancelled)
{
  all_but_the_merge_is_done();
  seen_.slurm[merge] = {"14", {"14", 0, "PENDING", "", "DependencyNeverSatisfied"}};
  const Missing found = missing();
  EXPECT_EQ(found.work.cases.size(), 1U);
  EXPECT_THAT(found.to_cancel, ElementsAre("14"));
}

TEST(MissingOfCampaign, CasesThatAreNotMadeAndThenTheIndex)
{
  const test::Scratch scratch;
  const Submission submission = test::campaign(4, 1);
  const std::string folder = test::folder_with(scratch, submission);
  scratch.write("submission/case-1/case-1.h5", "model");
  Sightings seen;
  seen.slurm[{TaskKind::run, 1, 0}] = {"20_2", {"20", 2, "RUNNING", "n1", ""}};
  seen.states[{TaskKind::run, 2, 0}] = test::state_of(TaskPhase::failed, "", "bad mesh");
  seen.slurm[{TaskKind::index, -1, 0}] = {"21", {"21", 0, "PENDING", "", "Dependency"}};
  const auto missing = [&] {
    return missing_of(folder, submission, status_of(folder, submission, seen), seen);
  };
  const Missing found = missing();
  ASSERT_EQ(found.work.cases.size(), 2U);
  EXPECT_EQ(found.work.cases[0].case_number, 2);
  EXPECT_EQ(found.work.cases[1].case_number, 3);
  EXPECT_TRUE(found.work.needs_index);
  EXPECT_THAT(found.work.cases_under_way, ElementsAre("20_2"));
  EXPECT_THAT(found.to_cancel, ElementsAre("21"));
  EXPECT_THAT(found.reasons, ElementsAre("case-3 run: failed: bad mesh", "case-4 run: waiting"));
  for (const int k : {2, 3, 4}) {
    const std::string name = "case-" + std::to_string(k);
    scratch.write("submission/" + name + "/" + name + ".h5", "model");
  }
  EXPECT_TRUE(missing().work.is_nothing());
  seen.slurm.clear();
  EXPECT_TRUE(missing().work.needs_index);
  seen.states[{TaskKind::index, -1, 0}] = test::state_of(TaskPhase::done, "");
  EXPECT_TRUE(missing().work.is_nothing());
}

}  // namespace
}  // namespace vrda
