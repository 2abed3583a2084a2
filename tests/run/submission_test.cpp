// A submission's folder, the jobs of its tasks and the rows of its shards.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>

#include "run/campaign.hpp"
#include "run/status.hpp"
#include "run/submission.hpp"
#include "run/submission_scenes.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::submission_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

TEST(Submission, ComesBackAsItWasWritten)
{
  const test::Scratch scratch;
  run::Submission submission = test::campaign(3, 2);
  submission.program = "/a b/\"vrda\"'s";
  submission.slurm = {"batch", "1-12", "2G", "us", "high", 4, 7, 3, {"--constraint=avx2"}};
  submission.cases[1].spec.overrides = {"title=\"K\u00f6nig\"", "grid.varus=\"free\""};
  EXPECT_EQ(run::read_submission(test::folder_with(scratch, submission)), submission);
}

TEST(Submission, AnythingElseIsRefusedWithItsName)
{
  const test::Scratch scratch;
  const std::string folder = scratch.path().string();
  EXPECT_THAT(test::input_error([&] { run::read_submission(folder); }),
              test::refuses({.wanted = "vrda submit"}));
  for (const std::string text : {"", "{", "[]"}) {
    SCOPED_TRACE(text);
    scratch.write("submission.json", text);
    EXPECT_THAT(test::input_error([&] { run::read_submission(folder); }),
                test::refuses({.file = run::submission_file_of(folder), .wanted = "submission"}));
  }
  scratch.write("submission.json", "{\"format\":\"vrda submission 1\"}");
  EXPECT_THAT(test::input_error([&] { run::read_submission(folder); }),
              test::refuses({.field = "program", .wanted = "text"}));
  scratch.write("submission.json", "{\"format\":\"vrda submission 9\"}");
  EXPECT_THAT(test::input_error([&] { run::read_submission(folder); }),
              test::refuses({.field = "format", .found = "9"}));
  run::Submission without_rows = test::one_case(2);
  without_rows.cases[0].n_flexion = 0;
  run::write_submission(folder, without_rows);
  EXPECT_THAT(test::input_error([&] { run::read_submission(folder); }),
              test::refuses({.found = "submission"}));
}

TEST(Submission, ItsFolderIsAbsoluteAndEndsWithoutASlash)
{
  const std::string here = std::filesystem::current_path().string();
  for (const std::string folder : {"a/b", "a/b/", "./a//b//", "a/c/../b"})
    EXPECT_EQ(run::absolute_folder(folder), here + "/a/b") << folder;
  EXPECT_EQ(run::absolute_folder("/a b/"), "/a b");
  EXPECT_EQ(run::absolute_folder("."), here);
}

TEST(Submission, PathsThatCouldNotBeReadBackAreRefused)
{
  const test::Scratch scratch;
  run::Submission submission = test::one_case(1);
  submission.cases[0].spec.job_file = "/jobs/\xff.toml";
  const auto facts = test::input_error([&] { run::write_submission(scratch.path().string(), submission); });
  EXPECT_THAT(facts.wanted, HasSubstr("UTF-8"));
}

TEST(Submission, FilesOfTasksAreNamedAfterCaseAndKind)
{
  const run::Submission submission = test::one_case(8);
  EXPECT_EQ(run::file_stem_of({run::TaskKind::spine, 0, 0}, submission), "knee.spine");
  EXPECT_EQ(run::file_stem_of({run::TaskKind::shard, 0, 3}, submission), "knee.shard-3-of-8");
  EXPECT_EQ(run::file_stem_of({run::TaskKind::index, -1, 0}, submission), "index");
  EXPECT_EQ(run::text_of({run::TaskKind::shard, 0, 3}, submission), "shard 3 of 8");
  for (const run::TaskKind kind : {run::TaskKind::spine, run::TaskKind::shard, run::TaskKind::merge,
                                   run::TaskKind::run, run::TaskKind::index}) {
    EXPECT_EQ(value_named<run::TaskKind>(name_of(kind)), kind);
  }
  EXPECT_EQ(value_named<run::TaskKind>("shards"), std::nullopt);
}

TEST(Submission, AMisspeltCaseIsRefusedWithTheNearestName)
{
  const run::Submission submission = test::campaign(12, 1);
  EXPECT_EQ(run::case_named(submission, "case-11"), 10);
  EXPECT_THAT(test::input_error([&] { run::case_named(submission, "casee-7"); }),
              test::refuses({.file = "--case", .wanted = "case-7"}));
}

TEST(Submission, ACaseIsMadeWhenNothingOfItsMakingIsLeft)
{
  const test::Scratch scratch;
  const run::Submission submission = test::one_case(2);
  const std::string folder = scratch.path().string();
  EXPECT_FALSE(run::is_case_complete(folder, submission.cases[0]));
  scratch.write("knee.h5", "model");
  EXPECT_TRUE(run::is_case_complete(folder, submission.cases[0]));
  for (const std::string leftover : {"knee.h5.journal", "knee.h5.case.json"}) {
    const auto file = scratch.write(leftover, "");
    EXPECT_FALSE(run::is_case_complete(folder, submission.cases[0])) << leftover;
    std::filesystem::remove(file);
  }
}

TEST(CaseSpec, IsNamedAfterItsJobAndHasAbsolutePaths)
{
  const run::CaseSpec spec = run::case_of_job("jobs/../jobs/knee.v2.toml", "data", {"a=1"});
  EXPECT_EQ(spec.name, "knee.v2");
  EXPECT_EQ(spec.job_file, std::filesystem::current_path() / "jobs/knee.v2.toml");
  EXPECT_EQ(spec.data_directory, std::filesystem::current_path() / "data");
  EXPECT_EQ(run::case_of_job("a.toml", "", {}).data_directory, "");
}

TEST(CaseSpec, TheFileGivesItBack)
{
  const test::Scratch scratch;
  const std::string path = run::case_file_of(scratch.path() / "knee.h5");
  EXPECT_EQ(path, scratch.path() / "knee.h5.case.json");
  const run::CaseSpec spec{
      "a \"b\"", "/tmp/with space/j\\ob.toml", "/d", {"title=\"x=y\"", "grid.flexion.step=5"}};
  run::write_case_file(path, {spec, "abc"});
  EXPECT_EQ(run::read_case_file(path).spec, spec);
  EXPECT_EQ(run::read_case_file(path).merged_sha256, "abc");
}

TEST(TaskState, ComesBackAsItWasWritten)
{
  const test::Scratch scratch;
  const run::Submission submission = test::one_case(3);
  const std::string folder = test::folder_with(scratch, submission);
  const run::TaskId task{run::TaskKind::shard, 0, 2};
  EXPECT_FALSE(run::read_task_state(folder, submission, task));
  for (const run::TaskStatus phase : {run::TaskStatus::running, run::TaskStatus::done,
                                      run::TaskStatus::failed, run::TaskStatus::interrupted}) {
    run::TaskState state = run::started_now(12);
    state.status = phase;
    state.n_restarts = 3;
    state.slurm_job = "13_2";
    state.exit_code = phase == run::TaskStatus::running ? 0 : 4;
    state.reason = "a \"reason\"\xff";
    run::write_task_state(folder, submission, task, state);
    const auto read = run::read_task_state(folder, submission, task);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->status, phase);
    EXPECT_EQ(read->host, state.host);
    EXPECT_EQ(read->started, state.started);
    EXPECT_EQ(read->n_done_at_start, 12);
    EXPECT_EQ(read->n_restarts, 3);
    EXPECT_EQ(read->exit_code, state.exit_code);
    EXPECT_EQ(read->slurm_job, "13_2");
    EXPECT_EQ(read->reason, "a \"reason\"\xef\xbf\xbd");
  }
}

TEST(TaskState, ADamagedFileIsNoState)
{
  const test::Scratch scratch;
  const run::Submission submission = test::one_case(2);
  const std::string folder = test::folder_with(scratch, submission);
  for (const std::string text : {"", "{", "{}", "{\"state\":\"asleep\"}", "[1]"}) {
    scratch.write("submission/tasks/knee.spine.json", text);
    EXPECT_FALSE(run::read_task_state(folder, submission, {run::TaskKind::spine, 0, 0})) << text;
  }
  EXPECT_TRUE(run::read_task_states(folder, submission).empty());
}

TEST(TaskState, AllThatBeganAreFound)
{
  const test::Scratch scratch;
  const run::Submission submission = test::campaign(3, 2);
  const std::string folder = test::folder_with(scratch, submission);
  const std::vector<run::TaskId> begun{{run::TaskKind::spine, 0, 0},
                                       {run::TaskKind::shard, 1, 2},
                                       {run::TaskKind::merge, 2, 0},
                                       {run::TaskKind::index, -1, 0}};
  for (const run::TaskId& task : begun) run::write_task_state(folder, submission, task, run::started_now(0));
  const auto states = run::read_task_states(folder, submission);
  EXPECT_EQ(states.size(), begun.size());
  for (const run::TaskId& task : begun) EXPECT_EQ(states.count(task), 1U);
}

TEST(TaskState, StartsDifferByJobAndRestarts)
{
  const run::TaskState first = test::state_of(run::TaskStatus::running, "13_2");
  run::TaskState again = first, elsewhere = first;
  EXPECT_TRUE(run::is_same_start(first, again));
  again.n_restarts = 1;
  elsewhere.slurm_job = "14_2";
  EXPECT_FALSE(run::is_same_start(first, again));
  EXPECT_FALSE(run::is_same_start(first, elsewhere));
}

TEST(TaskState, TimesAreInUtc)
{
  EXPECT_EQ(run::utc_text(std::chrono::system_clock::time_point(std::chrono::seconds(86400))),
            "1970-01-02T00:00:00Z");
}

std::vector<run::PlannedJob> all_jobs(const run::Submission& submission, const run::SlurmLimits& limits = {})
{
  return run::jobs_of_work(submission, run::all_work(submission), limits);
}

TEST(Jobs, RangesAreWrittenAsSbatchTakesThem)
{
  EXPECT_EQ(run::ranges_text({}), "");
  EXPECT_EQ(run::ranges_text({4}), "4");
  EXPECT_EQ(run::ranges_text({1, 2, 3, 5, 7, 8}), "1-3,5,7-8");
}

// Of each case a spine, then its shards, then a merge; the index after every merge.
TEST(Jobs, AreOfSpinesShardsMergesAndTheIndex)
{
  const std::vector<run::PlannedJob> jobs = all_jobs(test::campaign(3, 4));
  ASSERT_EQ(jobs.size(), 10U);
  EXPECT_EQ(jobs[0].kind, run::TaskKind::spine);
  EXPECT_EQ(jobs[1].kind, run::TaskKind::shard);
  EXPECT_THAT(jobs[1].numbers, ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(jobs[1].after, ElementsAre(0U));
  EXPECT_EQ(jobs[2].kind, run::TaskKind::merge);
  EXPECT_THAT(jobs[2].after, ElementsAre(1U));
  EXPECT_EQ(jobs.back().kind, run::TaskKind::index);
  EXPECT_THAT(jobs.back().after, ElementsAre(2U, 5U, 8U));
  EXPECT_EQ(all_jobs(test::one_case(4)).size(), 3U) << "one case has no index";
}

// Array task numbers are from 1 below MaxArraySize, each case is in exactly one task.
void expect_each_case_once(const run::Submission& submission, const run::SlurmLimits& limits,
                           std::size_t n_arrays)
{
  const std::vector<run::PlannedJob> jobs = all_jobs(submission, limits);
  ASSERT_EQ(jobs.size(), n_arrays + 1);
  std::vector<int> n_times(submission.cases.size(), 0);
  std::int32_t n_tasks = 0;
  for (const run::PlannedJob& job : jobs) {
    for (const std::int32_t number : job.numbers) {
      EXPECT_GE(number, 1);
      EXPECT_LT(number, limits.max_array_size);
      ++n_tasks;
      for (const run::TaskId& task : run::tasks_of(submission, job, number))
        ++n_times.at(static_cast<std::size_t>(task.case_number));
    }
  }
  EXPECT_THAT(n_times, testing::Each(1));
  EXPECT_LE(n_tasks, limits.max_job_count / 2);
  EXPECT_EQ(jobs.back().after.size(), n_arrays);
}

TEST(Jobs, ACampaignIsCutIntoArraysThatSlurmTakes)
{
  expect_each_case_once(test::campaign(1, 1), {}, 1);
  expect_each_case_once(test::campaign(1000, 1), {}, 1);
  expect_each_case_once(test::campaign(1001, 1), {}, 2);
  expect_each_case_once(test::campaign(5000, 1), {}, 5);
  // More than half of Slurm's queue: two cases per task.
  expect_each_case_once(test::campaign(5001, 1), {}, 3);
  expect_each_case_once(test::campaign(10000, 1), {}, 5);
  expect_each_case_once(test::campaign(7, 1), {4, 6}, 1);
  expect_each_case_once(test::campaign(10, 1), {2, 200}, 10);
}

TEST(Jobs, OnlyTheTasksOfMissingCasesAreSubmittedAgain)
{
  run::Submission submission = test::campaign(10, 1);
  submission.slurm.cases_per_task = 3;
  run::Work work;
  for (const std::int32_t k : {1, 2, 9}) {
    run::CaseWork c;
    c.case_number = k;
    c.needs_run = true;
    work.cases.push_back(c);
  }
  const std::vector<run::PlannedJob> jobs = run::jobs_of_work(submission, work, {});
  ASSERT_EQ(jobs.size(), 1U);
  EXPECT_THAT(jobs[0].numbers, ElementsAre(1, 4));
  const auto run = [](std::int32_t k) { return run::TaskId{run::TaskKind::run, k, 0}; };
  EXPECT_THAT(run::tasks_of(submission, jobs[0], 1), ElementsAre(run(0), run(1), run(2)));
  EXPECT_THAT(run::tasks_of(submission, jobs[0], 4), ElementsAre(run(9)));
}

run::Submission with_cases_per_task(run::Submission submission, std::int32_t n)
{
  submission.slurm.cases_per_task = n;
  return submission;
}

// The index is one job, each case a spine, its shards and a merge. The refusal names what would fit.
TEST(Jobs, MoreThanSlurmTakesAreRefusedWithWhatWouldFit)
{
  struct Row {
    run::Submission submission;
    run::SlurmLimits limits;
    const char* option;
    test::Values found, wanted;
    std::vector<run::Submission> fitting;
  };
  for (const Row& row :
       {Row{test::one_case(1001), {}, "--shards", "1001", "1000", {test::one_case(1000)}},
        Row{test::campaign(1100, 8),
            {},
            "--shards",
            {"8", "1100", "11001"},
            {"10000", "--shards 7", "999"},
            {test::campaign(1100, 7), test::campaign(999, 8)}},
        Row{test::campaign(4, 3),
            {11, 20},
            "--shards",
            {"3", "4", "21"},
            {"20", "--shards 2", "3"},
            {test::campaign(4, 2), test::campaign(3, 3)}},
        Row{test::campaign(10, 2),
            {11, 20},
            "--shards",
            {"2", "10", "41"},
            {"20", "--shards 1", "4"},
            {test::campaign(10, 1), test::campaign(4, 2)}},
        Row{test::one_case(30), {101, 20}, "--shards", "30", {"20", "--shards 18"}, {test::one_case(18)}},
        Row{with_cases_per_task(test::campaign(100, 1), 2),
            {11, 20},
            "--cases-per-task",
            {"2", "100", "51"},
            {"20", "MaxJobCount", "--cases-per-task 6"},
            {with_cases_per_task(test::campaign(100, 1), 6)}}}) {
    EXPECT_THAT(test::input_error([&] { all_jobs(row.submission, row.limits); }),
                test::refuses({row.option, "", row.found, row.wanted}));
    for (const run::Submission& fitting : row.fitting) EXPECT_NO_THROW(all_jobs(fitting, row.limits));
  }
}

TEST(Jobs, LocalOnesHaveNoLimitAndComeAfterThoseTheyNeed)
{
  const run::Submission submission = test::campaign(2, 3);
  const std::vector<run::PlannedJob> jobs = all_jobs(submission, run::no_limits);
  std::vector<run::TaskId> tasks;
  for (std::size_t k = 0; k < jobs.size(); ++k) {
    for (const std::size_t before : jobs[k].after) EXPECT_LT(before, k);
    for (const run::TaskId& task : run::tasks_of(submission, jobs[k])) tasks.push_back(task);
  }
  EXPECT_EQ(tasks, run::tasks_of(submission));
  ASSERT_EQ(tasks.size(), 11U);
  EXPECT_EQ(tasks.back().kind, run::TaskKind::index);
  EXPECT_EQ(all_jobs(test::campaign(50'000, 1), run::no_limits).size(), 2U);
  EXPECT_EQ(all_jobs(test::one_case(100'000), run::no_limits).size(), 3U);
}

TEST(Shard, RowsAreDealtOutInTurn)
{
  EXPECT_EQ(run::shard_of("3/8"), (store::Shard{3, 8}));
  EXPECT_THAT(run::rows_of({1, 3}, 7), ElementsAre(0, 3, 6));
  EXPECT_THAT(run::rows_of({3, 3}, 7), ElementsAre(2, 5));
  EXPECT_THAT(run::rows_of({8, 8}, 7), IsEmpty());
}

TEST(Shard, EachRowBelongsToOneShardAndSharesDifferByOneAtMost)
{
  for (std::int32_t n_rows = 1; n_rows < 40; ++n_rows) {
    for (std::int32_t count = 1; count < 45; ++count) {
      std::vector<int> n_owners(static_cast<std::size_t>(n_rows), 0);
      for (std::int32_t number = 1; number <= count; ++number) {
        const auto rows = run::rows_of({number, count}, n_rows);
        EXPECT_GE(static_cast<std::int32_t>(rows.size()), n_rows / count);
        EXPECT_LE(static_cast<std::int32_t>(rows.size()), (n_rows + count - 1) / count);
        for (const std::int32_t row : rows) ++n_owners.at(static_cast<std::size_t>(row));
      }
      EXPECT_THAT(n_owners, testing::Each(1));
    }
  }
}

TEST(Shard, NamesOfJournalsLeadBackToTheirRun)
{
  const std::string output = "a.shard-1-of-2.journal/knee.h5";
  EXPECT_EQ(store::shard_journal_of(output, {12, 345}), output + ".shard-12-of-345.journal");
  EXPECT_EQ(store::output_of_journal(store::shard_journal_of(output, {12, 345})), output);
  EXPECT_EQ(store::shard_of_journal(store::shard_journal_of(output, {12, 345})), (store::Shard{12, 345}));
  EXPECT_EQ(store::output_of_journal(store::spine_journal_of(output)), output);
  EXPECT_EQ(store::shard_of_journal(store::spine_journal_of(output)), std::nullopt);
  for (const std::string other : {"knee.h5.journal", "knee.h5.shard-3-of-2.journal",
                                  "knee.h5.shard-x-of-2.journal", "knee.h5.shard-1-of-2", "knee.h5"}) {
    EXPECT_EQ(store::output_of_journal(other), "") << other;
    EXPECT_EQ(store::shard_of_journal(other), std::nullopt) << other;
  }
}

TEST(Shard, JournalsBesideAnOutputAreFoundInOrder)
{
  const test::Scratch scratch;
  const std::string output = scratch.path() / "knee.h5";
  for (const std::string name : {"knee.h5.shard-10-of-12.journal", "knee.h5.shard-2-of-12.journal",
                                 "knee.h5.shard-1-of-3.journal", "knee.h5.spine.journal", "knee.h5.journal",
                                 "other.h5.shard-1-of-3.journal", "knee.h5.shard-1-of-3.journal.partial"}) {
    scratch.write(name, "");
  }
  EXPECT_THAT(store::list_shard_journals(output),
              ElementsAre(output + ".shard-1-of-3.journal", output + ".shard-2-of-12.journal",
                          output + ".shard-10-of-12.journal"));
  EXPECT_EQ(test::input_error([&] { store::list_shard_journals(scratch.path() / "none" / "knee.h5"); }).file,
            scratch.path() / "none");
}

}  // namespace vrda::submission_test
