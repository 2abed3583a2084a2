// Tasks as processes of this machine, and the work that is left of a submission.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>

#include "job/job.hpp"
#include "run/campaign.hpp"
#include "run/local_run.hpp"
#include "run/sharded_case.hpp"
#include "run/slurm.hpp"
#include "run/status.hpp"
#include "run/submission_scenes.hpp"
#include "support/refusal.hpp"

namespace vrda::local_run_test {

namespace fs = std::filesystem;
using test::merge;
using test::shard;
using test::spine;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

// Tasks are a script that records its arguments and runs `act`.
class LocalRunTest : public testing::Test {
 protected:
  LocalRunTest() : submission_(test::one_case(3)), folder_(test::folder_with(scratch_, submission_)) {}

  run::LocalOutcome run(const std::string& act, const run::LocalOptions& options)
  {
    const fs::path program =
        scratch_.write("vrda", "#!/bin/bash\necho \"$@\" >> " + said().string() + "\n" + act + "\n");
    fs::permissions(program, fs::perms::owner_all);
    submission_.program = program.string();
    return run::run_locally(folder_, submission_,
                            run::jobs_of_work(submission_, run::all_work(submission_), run::no_limits),
                            options);
  }

  fs::path said() const { return scratch_.path() / "said"; }
  std::string what_was_said() const { return test::read_bytes(said()); }

  test::Scratch scratch_;
  run::Submission submission_;
  std::string folder_;
};

TEST_F(LocalRunTest, DoesEveryTaskInOrder)
{
  const run::LocalOutcome outcome = run("exit 0", {1, 2, {}, {}});
  EXPECT_EQ(outcome.n_done, 5);
  EXPECT_EQ(outcome.worst_code, 0);
  EXPECT_FALSE(outcome.is_interrupted);
  const std::string task = "task " + folder_ + " --kind ";
  EXPECT_EQ(what_was_said(),
            task + "spine --cpus 2 --first 1\n" + task + "shard --cpus 2 --first 1 --shard 1\n" + task +
                "shard --cpus 2 --first 1 --shard 2\n" + task + "shard --cpus 2 --first 1 --shard 3\n" +
                task + "merge --cpus 2 --first 1\n");
}

TEST_F(LocalRunTest, RunsNoMoreTasksAtOnceThanRequested)
{
  // Each counts the running tasks, including itself.
  const std::string act = "mkdir -p " + (scratch_.path() / "now").string() + "; cd " +
                          (scratch_.path() / "now").string() +
                          "; touch $$; sleep 0.2; ls | wc -l >> ../counts; rm $$";
  run(act, {2, 1, {}, {}});
  const std::string counts = test::read_bytes(scratch_.path() / "counts");
  EXPECT_THAT(counts, HasSubstr("2\n"));
  EXPECT_THAT(counts, Not(HasSubstr("3\n")));
}

TEST_F(LocalRunTest, ATaskThatWasKilledHasItsReason)
{
  const run::LocalOutcome outcome = run("case \"$*\" in *spine*) kill -KILL $$ ;; esac", {1, 1, {}, {}});
  EXPECT_EQ(outcome.n_failed, 1);
  EXPECT_EQ(outcome.n_skipped, 4);
  const auto state = run::read_task_state(folder_, submission_, {run::TaskKind::spine, 0, 0});
  ASSERT_TRUE(state);
  EXPECT_EQ(state->status, run::TaskStatus::failed);
  EXPECT_EQ(state->reason, "ended by signal 9");
}

TEST_F(LocalRunTest, WhenStoppedItSignalsItsProcessesAndWaitsForThem)
{
  run::LocalOptions options{3, 1, {}, {}};
  options.is_stop_requested = [&] { return what_was_said().find("ready") != std::string::npos; };
  const run::LocalOutcome outcome =
      run("trap 'sleep 0.1; echo flushed >> " + said().string() + "; exit 4' TERM; echo ready >> " +
              said().string() + "; while :; do sleep 0.01; done",
          options);
  EXPECT_TRUE(outcome.is_interrupted);
  EXPECT_EQ(outcome.n_done, 0);
  EXPECT_THAT(what_was_said(), HasSubstr("flushed\n"));
}

// E.g. in a shell within a Slurm job.
TEST_F(LocalRunTest, ItsTasksDoNotInheritAJobOfSlurm)
{
  setenv("SLURM_JOB_ID", "77", 1);
  const run::LocalOutcome outcome = run("[ -z \"$SLURM_JOB_ID\" ]", {1, 1, {}, {}});
  unsetenv("SLURM_JOB_ID");
  EXPECT_EQ(outcome.n_done, 5);
}

TEST_F(LocalRunTest, ASecondOneIsRefused)
{
  const OpenFile lock = run::locked_submission(folder_);
  EXPECT_THAT(test::input_error([&] { run::locked_submission(folder_); }),
              test::refuses({folder_, "", "submit"}));
}

// Options for Slurm's programs, and variables of an enclosing Slurm job.
TEST(RunSlurm, KeepsOptionsOfTheEnvironmentFromSlurm)
{
  const std::vector<std::string> dropped{"SBATCH_PARTITION",    "SQUEUE_STATES",       "SCANCEL_STATE",
                                         "SLURM_JOB_ID",        "SLURM_JOBID",         "SLURM_ARRAY_JOB_ID",
                                         "SLURM_ARRAY_TASK_ID", "SLURM_RESTART_COUNT", "SLURM_JOB_NODELIST"};
  const std::vector<std::string> kept{"SBATCH_EXPORT", "SLURM_CONF", "SLURM_CLUSTERS", "SLURM_JWT"};
  for (const auto& names : {dropped, kept}) {
    for (const std::string& name : names) setenv(name.c_str(), "set", 1);
  }
  const ProgramResult said = run::run_slurm({"/usr/bin/env"});
  for (const auto& names : {dropped, kept}) {
    for (const std::string& name : names) unsetenv(name.c_str());
  }
  for (const std::string& name : dropped) EXPECT_THAT(said.out, Not(HasSubstr(name + "="))) << name;
  for (const std::string& name : kept) EXPECT_THAT(said.out, HasSubstr(name + "=set")) << name;
}

class MissingOfCase : public test::ShardedCase {};

TEST_F(MissingOfCase, AMissingOrShortJournalIsIncompleteWhateverItsState)
{
  set_all_done_except_merge();
  fs::remove(store::shard_journal_of(output(), {2, 3}));
  write_shard(3, 1);
  const run::MissingWork found = missing();
  ASSERT_EQ(found.work.cases.size(), 1U);
  EXPECT_THAT(found.work.cases[0].shards, ElementsAre(2, 3));
  EXPECT_FALSE(found.work.cases[0].needs_spine);
  EXPECT_THAT(found.reasons, ElementsAre("shard 2 of 3: lost: its journal is missing",
                                         "shard 3 of 3: its journal is incomplete", "merge: waiting"));
}

TEST_F(MissingOfCase, ALostSpineIsMissing)
{
  set_all_done_except_merge();
  fs::remove(store::spine_journal_of(output()));
  const run::MissingWork found = missing();
  ASSERT_EQ(found.work.cases.size(), 1U);
  EXPECT_TRUE(found.work.cases[0].needs_spine);
  // Its cells were part of every shard's rows.
  EXPECT_THAT(found.work.cases[0].shards, IsEmpty());
}

// The number of steps of a spine with free varus is known only to the spine task.
TEST_F(MissingOfCase, AFreeSpineIsRepeatedOnceTheMergeHasFailed)
{
  set_all_done_except_merge();
  fs::remove(store::spine_journal_of(output()));
  test::write_free_spine(store::spine_journal_of(output()), 3);
  struct Row {
    const char* name;
    std::optional<run::TaskStatus> phase;  // of the merge's state, of job 14
    const char* queue;                     // of the merge, now job 20 or nothing
    bool needs_spine;
  };
  for (const Row& row :
       {Row{"never begun", {}, nullptr, false}, Row{"failed", run::TaskStatus::failed, nullptr, true},
        Row{"interrupted", run::TaskStatus::interrupted, nullptr, false},
        Row{"failed, and could not begin again", run::TaskStatus::failed, "DependencyNeverSatisfied",
            false}}) {
    SCOPED_TRACE(row.name);
    seen_.states.erase(merge);
    seen_.slurm.erase(merge);
    if (row.phase)
      seen_.states[merge] = test::state_of(*row.phase, row.queue == nullptr ? "" : "14", "no spine");
    if (row.queue != nullptr) seen_.slurm[merge] = {"20", {"20", 0, "PENDING", "", row.queue}};
    const run::MissingWork found = missing();
    ASSERT_EQ(found.work.cases.size(), 1U);
    EXPECT_EQ(found.work.cases[0].needs_spine, row.needs_spine);
    EXPECT_THAT(found.work.cases[0].shards, IsEmpty());
  }
  // A repeated shard detects and repairs it, too.
  seen_.slurm.clear();
  write_shard(2, 1);
  ASSERT_EQ(missing().work.cases.size(), 1U);
  EXPECT_FALSE(missing().work.cases[0].needs_spine);
  EXPECT_THAT(missing().work.cases[0].shards, ElementsAre(2));
}

TEST_F(MissingOfCase, AMergeKilledWhileItClearedUpIsAllThatIsMissing)
{
  set_all_done_except_merge();
  fs::remove(store::spine_journal_of(output()));
  fs::remove(store::shard_journal_of(output(), {1, 3}));
  scratch_.write("submission/knee.h5", "model");
  seen_.states[merge] = test::state_of(run::TaskStatus::failed, "", "ended by signal 9");
  const auto note = [&](const std::string& sha256) {
    run::write_case_file(run::case_file_of(output()), {submission_.cases[0].spec, sha256});
  };
  note(job::sha256_of("model"));
  const run::MissingWork found = missing();
  ASSERT_EQ(found.work.cases.size(), 1U);
  EXPECT_FALSE(found.work.cases[0].needs_spine);
  EXPECT_THAT(found.work.cases[0].shards, IsEmpty());
  EXPECT_THAT(found.reasons, ElementsAre("merge: failed: ended by signal 9"));
  EXPECT_EQ(view_of(shard(1)).status, run::TaskStatus::done);
  // The record is ignored if it does not match the model.
  for (const std::string& other : {job::sha256_of("another"), std::string()}) {
    note(other);
    ASSERT_EQ(missing().work.cases.size(), 1U);
    EXPECT_TRUE(missing().work.cases[0].needs_spine);
    EXPECT_THAT(missing().work.cases[0].shards, ElementsAre(1));
  }
}

TEST_F(MissingOfCase, WhatIsUnderWayIsNotSubmittedAgain)
{
  set_all_done_except_merge();
  seen_.states[shard(1)] = test::state_of(run::TaskStatus::failed, "13_1", "bad luck");
  seen_.slurm[shard(1)] = {"13_1", {"13", 1, "FAILED", "n1", "NonZeroExitCode"}};
  seen_.slurm[shard(2)] = {"13_2", {"13", 2, "RUNNING", "n1", ""}};
  seen_.slurm[merge] = {"14", {"14", 0, "PENDING", "", "Dependency"}};
  const run::MissingWork found = missing();
  ASSERT_EQ(found.work.cases.size(), 1U);
  EXPECT_THAT(found.work.cases[0].shards, ElementsAre(1));
  EXPECT_THAT(found.work.cases[0].active_shard_jobs, ElementsAre("13_2"));
  EXPECT_EQ(found.n_active, 2);
  // The queued merge does not depend on the new shard.
  EXPECT_THAT(found.to_cancel, ElementsAre("14"));
  EXPECT_THAT(found.reasons, ElementsAre("shard 1 of 3: failed: bad luck"));
  const std::vector<run::PlannedJob> jobs = run::jobs_of_work(submission_, found.work, {});
  ASSERT_EQ(jobs.size(), 2U);
  EXPECT_THAT(jobs[1].after, ElementsAre(0U));
  EXPECT_THAT(jobs[1].after_ids, ElementsAre("13_2"));
}

TEST(MissingOfCampaign, CasesThatAreNotMadeAndThenTheIndex)
{
  const test::Scratch scratch;
  const run::Submission submission = test::campaign(4, 1);
  const std::string folder = test::folder_with(scratch, submission);
  scratch.write("submission/case-1/case-1.h5", "model");
  run::SubmissionSnapshot seen;
  seen.slurm[{run::TaskKind::run, 1, 0}] = {"20_2", {"20", 2, "RUNNING", "n1", ""}};
  seen.states[{run::TaskKind::run, 2, 0}] = test::state_of(run::TaskStatus::failed, "", "bad mesh");
  seen.slurm[{run::TaskKind::index, -1, 0}] = {"21", {"21", 0, "PENDING", "", "Dependency"}};
  const auto missing = [&] {
    return run::find_missing_work(folder, submission, run::status_of(folder, submission, seen), seen);
  };
  const run::MissingWork found = missing();
  ASSERT_EQ(found.work.cases.size(), 2U);
  EXPECT_EQ(found.work.cases[0].case_number, 2);
  EXPECT_EQ(found.work.cases[1].case_number, 3);
  EXPECT_TRUE(found.work.needs_index);
  EXPECT_THAT(found.work.active_case_jobs, ElementsAre("20_2"));
  EXPECT_THAT(found.to_cancel, ElementsAre("21"));
  EXPECT_THAT(found.reasons, ElementsAre("case-3 run: failed: bad mesh", "case-4 run: waiting"));
  // A running index may miss new models: the next one follows it.
  seen.slurm[{run::TaskKind::index, -1, 0}].row.state = "RUNNING";
  const run::MissingWork beside_index = missing();
  EXPECT_TRUE(beside_index.work.needs_index);
  EXPECT_THAT(beside_index.work.active_case_jobs, ElementsAre("20_2", "21"));
  EXPECT_THAT(beside_index.to_cancel, IsEmpty());
  EXPECT_EQ(beside_index.n_active, 2);
  for (const int k : {2, 3, 4}) {
    const std::string name = "case-" + std::to_string(k);
    scratch.write("submission/" + name + "/" + name + ".h5", "model");
  }
  EXPECT_TRUE(missing().work.is_empty());
  seen.slurm.clear();
  EXPECT_TRUE(missing().work.needs_index);
  seen.states[{run::TaskKind::index, -1, 0}] = test::state_of(run::TaskStatus::done, "");
  EXPECT_TRUE(missing().work.is_empty());
}

// E.g. when the next index task was rejected by Slurm, or killed before it started.
TEST(MissingOfCampaign, AnIndexOlderThanACaseIsRebuilt)
{
  const test::Scratch scratch;
  const run::Submission submission = test::campaign(2, 1);
  const std::string folder = test::folder_with(scratch, submission);
  const run::TaskId first{run::TaskKind::run, 0, 0}, second{run::TaskKind::run, 1, 0},
      index{run::TaskKind::index, -1, 0};
  run::SubmissionSnapshot seen;
  seen.states[first] = seen.states[second] = seen.states[index] = test::state_of(run::TaskStatus::done, "");
  const auto missing = [&] {
    return run::find_missing_work(folder, submission, run::status_of(folder, submission, seen), seen);
  };
  scratch.write("submission/case-1/case-1.h5", "model");
  seen.slurm[second] = {"20_2", {"20", 2, "RUNNING", "n1", ""}};
  seen.states[second].status = run::TaskStatus::running;
  EXPECT_TRUE(missing().work.needs_index);
  EXPECT_THAT(missing().work.active_case_jobs, ElementsAre("20_2"));
  scratch.write("submission/case-2/case-2.h5", "model");
  seen.slurm.clear();
  seen.states[second].status = run::TaskStatus::done;
  struct Row {
    const char *ended, *begun;
    bool is_outdated;
  };
  for (const Row& row : {Row{"2026-03-01T10:00:00Z", "2026-03-01T10:00:00Z", false},
                         Row{"2026-03-01T10:00:01Z", "2026-03-01T10:00:00Z", true},
                         // The clock was changed since.
                         Row{"9999-03-01T10:00:01Z", "2026-03-01T10:00:00Z", false}}) {
    SCOPED_TRACE(row.ended);
    seen.states[second].ended = row.ended;
    seen.states[index].started = row.begun;
    const run::MissingWork found = missing();
    EXPECT_EQ(found.work.needs_index, row.is_outdated);
    EXPECT_THAT(found.work.cases, IsEmpty());
  }
  seen.states[second].ended = "2026-03-01T10:00:01Z";
  EXPECT_THAT(missing().reasons, ElementsAre("index: done, but older than its cases"));
}

// One task of four cases: complete, failed, running, not started; the fifth case is another task's.
class SharedTask : public testing::Test {
 protected:
  SharedTask()
  {
    submission_.slurm.cases_per_task = 4;
    run::SubmittedJob job{"20", "", {}};
    job.job.numbers = {1, 2};
    job.job.per_task = 4;
    seen_.slurm = run::tasks_in_slurm(
        submission_, {job}, {{"20", 1, "RUNNING", "n1", "None"}, {"20", 2, "PENDING", "", "Priority"}});
    scratch_.write("submission/case-1/case-1.h5", "model");
    seen_.states[run(0)] = test::state_of(run::TaskStatus::done, "20_1");
    seen_.states[run(1)] = test::state_of(run::TaskStatus::failed, "20_1", "bad mesh");
    seen_.states[run(2)] = test::state_of(run::TaskStatus::running, "20_1");
    // From an earlier job: ignored.
    seen_.states[run(3)] = test::state_of(run::TaskStatus::failed, "13_1", "of old");
  }

  static run::TaskId run(std::int32_t number) { return {run::TaskKind::run, number, 0}; }

  test::Scratch scratch_;
  run::Submission submission_ = test::campaign(5, 1);
  std::string folder_ = test::folder_with(scratch_, submission_);
  run::SubmissionSnapshot seen_;
};

TEST_F(SharedTask, EachCaseHasItsOwnStatus)
{
  const run::StatusView status = run::status_of(folder_, submission_, seen_);
  struct Row {
    run::TaskStatus standing;
    const char* reason;
  };
  const std::vector<Row> rows{{run::TaskStatus::done, ""},
                              {run::TaskStatus::failed, "bad mesh"},
                              {run::TaskStatus::running, ""},
                              {run::TaskStatus::queued, "waiting for other cases of its task"},
                              {run::TaskStatus::queued, "Priority"}};
  for (std::size_t k = 0; k < rows.size(); ++k) {
    SCOPED_TRACE(k);
    const run::TaskView& view = status.cases[k].tasks.front();
    EXPECT_STREQ(name_of(view.status), name_of(rows[k].standing));
    EXPECT_EQ(view.reason, rows[k].reason);
  }
  EXPECT_EQ(status.cases[2].tasks.front().host, "n1");
}

TEST_F(SharedTask, NoneOfItsCasesIsSubmittedAgainBeforeItEnds)
{
  const auto missing = [&] {
    return run::find_missing_work(folder_, submission_, run::status_of(folder_, submission_, seen_), seen_);
  };
  const run::MissingWork found = missing();
  EXPECT_THAT(found.work.cases, IsEmpty());
  EXPECT_EQ(found.n_active, 4);
  EXPECT_THAT(found.work.active_case_jobs, ElementsAre("20_1", "20_2"));
  for (const std::int32_t k : {0, 1, 2, 3}) seen_.slurm[run(k)].row.state = "FAILED";
  const run::MissingWork then = missing();
  ASSERT_EQ(then.work.cases.size(), 3U);
  EXPECT_EQ(then.work.cases[0].case_number, 1);
  EXPECT_EQ(then.n_active, 1);
}

}  // namespace vrda::local_run_test
