#include "cluster/submission.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cluster/submission_scenes.hpp"
#include "support/input_error.hpp"

namespace vrda::submission_test {

using testing::HasSubstr;

TEST(Submission, ComesBackAsItWasWritten)
{
  const test::Scratch scratch;
  Submission submission = test::campaign(3, 2);
  submission.program = "/a b/\"vrda\"'s";
  submission.slurm = {"batch", "1-12", "2G", "us", "high", 4, 7, 3, {"--constraint=avx2"}};
  submission.cases[1].spec.overrides = {"title=\"K\u00f6nig\"", "grid.varus=\"free\""};
  EXPECT_EQ(read_submission(test::folder_with(scratch, submission)), submission);
}

TEST(Submission, AnythingElseIsRefusedWithItsName)
{
  const test::Scratch scratch;
  const std::string folder = scratch.path().string();
  EXPECT_THAT(test::input_error([&] { read_submission(folder); }).wanted, HasSubstr("vrda submit"));
  for (const std::string text : {"", "{", "[]", "{\"format\":\"vrda submission 1\"}"}) {
    SCOPED_TRACE(text);
    scratch.write("submission.json", text);
    const auto facts = test::input_error([&] { read_submission(folder); });
    EXPECT_EQ(facts.file, submission_file_of(folder));
    EXPECT_THAT(facts.found, HasSubstr("no submission"));
  }
  scratch.write("submission.json", "{\"format\":\"vrda submission 9\"}");
  EXPECT_EQ(test::input_error([&] { read_submission(folder); }).found, "vrda submission 9");
  Submission without_rows = test::one_case(2);
  without_rows.cases[0].n_flexion = 0;
  write_submission(folder, without_rows);
  EXPECT_THAT(test::input_error([&] { read_submission(folder); }).found, HasSubstr("no submission"));
}

TEST(Submission, ItsFolderIsAbsoluteAndEndsWithoutASlash)
{
  const std::string here = std::filesystem::current_path().string();
  for (const std::string folder : {"a/b", "a/b/", "./a//b//", "a/c/../b"})
    EXPECT_EQ(absolute_folder(folder), here + "/a/b") << folder;
  EXPECT_EQ(absolute_folder("/a b/"), "/a b");
  EXPECT_EQ(absolute_folder("."), here);
}

TEST(Submission, PathsThatCouldNotBeReadBackAreRefused)
{
  const test::Scratch scratch;
  Submission submission = test::one_case(1);
  submission.cases[0].spec.job_file = "/jobs/\xff.toml";
  const auto facts = test::input_error([&] { write_submission(scratch.path().string(), submission); });
  EXPECT_THAT(facts.wanted, HasSubstr("UTF-8"));
}

TEST(Submission, FilesOfTasksAreNamedAfterCaseAndKind)
{
  const Submission submission = test::one_case(8);
  EXPECT_EQ(file_stem_of({TaskKind::spine, 0, 0}, submission), "knee.spine");
  EXPECT_EQ(file_stem_of({TaskKind::shard, 0, 3}, submission), "knee.shard-3-of-8");
  EXPECT_EQ(file_stem_of({TaskKind::index, -1, 0}, submission), "index");
  EXPECT_EQ(text_of({TaskKind::shard, 0, 3}, submission), "shard 3 of 8");
  for (const TaskKind kind :
       {TaskKind::spine, TaskKind::shard, TaskKind::merge, TaskKind::run, TaskKind::index}) {
    EXPECT_EQ(task_kind_of(name_of(kind)), kind);
  }
  EXPECT_EQ(task_kind_of("shards"), std::nullopt);
}

TEST(Submission, AMisspeltCaseIsToldTheNearest)
{
  const Submission submission = test::campaign(12, 1);
  EXPECT_EQ(case_named(submission, "case-11"), 10);
  EXPECT_THAT(test::input_error([&] { case_named(submission, "casee-7"); }).wanted, HasSubstr("case-7"));
}

TEST(Submission, ACaseIsMadeWhenNothingOfItsMakingIsLeft)
{
  const test::Scratch scratch;
  const Submission submission = test::one_case(2);
  const std::string folder = scratch.path().string();
  EXPECT_FALSE(is_made(folder, submission.cases[0]));
  scratch.write("knee.h5", "model");
  EXPECT_TRUE(is_made(folder, submission.cases[0]));
  for (const std::string leftover : {"knee.h5.journal", "knee.h5.case.json"}) {
    const auto file = scratch.write(leftover, "");
    EXPECT_FALSE(is_made(folder, submission.cases[0])) << leftover;
    std::filesystem::remove(file);
  }
}

}  // namespace vrda::submission_test
