#include "run/submission.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "run/campaign.hpp"
#include "run/status.hpp"
#include "run/submission_scenes.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::submission_test {

using testing::HasSubstr;

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

}  // namespace vrda::submission_test
