#include "run/slurm.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "run/submission_scenes.hpp"
#include "support/input_error.hpp"

namespace vrda::slurm_test {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Slurm, RowsOfTheQueueAreRead)
{
  const std::vector<run::SlurmRow> rows = run::rows_of_squeue(
      "12|N/A|COMPLETED|n1|None\n"
      "13|1|RUNNING|n2|None\n"
      "13|2|PENDING||JobArrayTaskLimit\n"
      "an invalid line\n"
      "14|N/A|PENDING||DependencyNeverSatisfied\n"
      "15|N/A|FAILED|n1|(a reason | with bars)\n"
      "16|N/A|PENDING||launch failed requeued held\n");
  ASSERT_EQ(rows.size(), 6U);
  EXPECT_EQ(rows[0].id, "12");
  EXPECT_EQ(rows[0].number, 0);
  EXPECT_EQ(rows[1].number, 1);
  EXPECT_EQ(rows[1].node, "n2");
  EXPECT_TRUE(run::is_running(rows[1]));
  EXPECT_TRUE(run::is_queued(rows[2]));
  EXPECT_EQ(rows[2].reason, "JobArrayTaskLimit");
  EXPECT_FALSE(run::is_queued(rows[3]));
  EXPECT_EQ(rows[4].reason, "(a reason | with bars)");
  EXPECT_FALSE(run::is_queued(rows[0]) || run::is_running(rows[0]));
  EXPECT_TRUE(run::is_queued(rows[5]) && run::is_held_after_failed_launch(rows[5]));
  EXPECT_FALSE(run::is_held_after_failed_launch(rows[2]));
}

TEST(Slurm, LimitsAreReadFromTheConfiguration)
{
  const run::SlurmLimits limits = run::limits_of_config(
      "Configuration data as of 2026-03-01T10:00:00\n"
      "MaxArraySize            = 4001\n"
      "MaxJobCount             = 500000\n"
      "MaxJobId                = 67043328\n");
  EXPECT_EQ(limits.max_array_size, 4001);
  EXPECT_EQ(limits.max_job_count, 500000);
  EXPECT_EQ(run::limits_of_config("").max_array_size, run::SlurmLimits{}.max_array_size);
  EXPECT_EQ(run::limits_of_config("MaxJobCount = many\n").max_job_count, run::SlurmLimits{}.max_job_count);
}

TEST(Slurm, MessagesBecomeOneLine)
{
  EXPECT_EQ(
      run::slurm_message("sbatch: error: invalid partition specified: nosuch\n"
                         "sbatch: error: Batch job submission failed: Invalid partition name specified\n"),
      "invalid partition specified: nosuch; Batch job submission failed: Invalid partition name specified");
  EXPECT_EQ(run::slurm_message("\n"), "");
}

TEST(Submitted, ATornLastLineIsLeftOut)
{
  const test::Scratch scratch;
  const std::string folder = scratch.path().string();
  EXPECT_THAT(run::read_submitted(folder), IsEmpty());
  run::PlannedJob job;
  job.kind = run::TaskKind::shard;
  job.case_number = 0;
  job.numbers = {2, 5};
  EXPECT_FALSE(run::append_submitted(folder, {"12", "2026-03-01T10:00:00Z", job}));
  EXPECT_FALSE(run::append_submitted(folder, {"13", "2026-03-01T10:00:01Z", job}));
  const std::string whole = test::read_bytes(run::submitted_file_of(folder));
  scratch.write("submitted.jsonl", whole.substr(0, whole.size() - 10));
  const std::vector<run::SubmittedJob> jobs = run::read_submitted(folder);
  ASSERT_EQ(jobs.size(), 1U);
  EXPECT_EQ(jobs[0].id, "12");
  EXPECT_EQ(jobs[0].job.kind, run::TaskKind::shard);
  EXPECT_EQ(jobs[0].job.numbers, job.numbers);

  // The next line is not lost.
  EXPECT_FALSE(run::append_submitted(folder, {"14", "2026-03-01T10:00:02Z", job}));
  EXPECT_FALSE(run::append_submitted(folder, {"15", "2026-03-01T10:00:03Z", job}));
  std::vector<std::string> ids;
  for (const run::SubmittedJob& submitted : run::read_submitted(folder)) ids.push_back(submitted.id);
  EXPECT_THAT(ids, ElementsAre("12", "14", "15"));
}

TEST(Submitted, EachTaskHasItsLastJob)
{
  const run::Submission submission = test::campaign(5, 1);
  run::PlannedJob all, again;
  all.kind = again.kind = run::TaskKind::run;
  all.numbers = {1, 2, 3};
  all.per_task = 2;
  again.numbers = {2};
  again.per_task = 2;
  const auto tasks = run::tasks_in_slurm(submission, {{"20", "", all}, {"31", "", again}},
                                         {{"20", 1, "COMPLETED", "n1", ""},
                                          {"20", 2, "TIMEOUT", "n1", ""},
                                          {"31", 2, "PENDING", "", "Priority"}});
  ASSERT_EQ(tasks.size(), 5U);
  EXPECT_EQ(tasks.at({run::TaskKind::run, 0, 0}).job, "20_1");
  EXPECT_EQ(tasks.at({run::TaskKind::run, 2, 0}).job, "31_2");
  EXPECT_EQ(tasks.at({run::TaskKind::run, 3, 0}).row.state, "PENDING");
  EXPECT_EQ(tasks.at({run::TaskKind::run, 4, 0}).job, "20_3");
  EXPECT_EQ(tasks.at({run::TaskKind::run, 4, 0}).row.state, "");
  EXPECT_EQ(tasks.at({run::TaskKind::run, 3, 0}).log, "run-0.2.log");
}

TEST(Submitted, WhileRunsAreUnderWayTasksKeepTheirNumberOfCases)
{
  const run::Submission submission = test::campaign(5, 1);
  run::PlannedJob job;
  job.kind = run::TaskKind::run;
  job.numbers = {1, 2, 3};
  job.per_task = 2;
  const auto tasks_when = [&](const std::string& state) {
    return run::tasks_in_slurm(submission, {{"20", "", job}},
                               {{"20", 1, "FAILED", "n1", ""}, {"20", 2, state, "", ""}});
  };
  for (const std::string state : {"PENDING", "RUNNING"}) {
    const auto facts = test::input_error([&] { run::require_same_cases_per_task(tasks_when(state), 3); });
    EXPECT_EQ(facts.file, "--cases-per-task");
    EXPECT_THAT(facts.found, "3, while tasks of 2 are queued or running");
    EXPECT_THAT(facts.wanted, testing::StartsWith("2;"));
    EXPECT_NO_THROW(run::require_same_cases_per_task(tasks_when(state), 2));
  }
  EXPECT_NO_THROW(run::require_same_cases_per_task(tasks_when("COMPLETED"), 3));
}

}  // namespace vrda::slurm_test
