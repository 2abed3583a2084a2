// Submissions that Slurm accepts in part or not at all.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/fake_slurm.hpp"
#include "support/messages.hpp"

namespace vrda::refused_submission_test {

namespace fs = std::filesystem;
using test::FakeSlurm;
using testing::HasSubstr;
using testing::Not;

TEST_F(FakeSlurm, ARefusalIsOneLineAndLeavesNothing)
{
  const test::Ended ended = submit({"--shards", "3"}, {{"refused", "101"}});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_EQ(test::n_lines(ended.err), 1) << ended.err;
  EXPECT_THAT(ended.err, test::reports("", "Job violates policy"));
  EXPECT_FALSE(test::names_value(ended.err, "vrda resume"));
  EXPECT_FALSE(fs::exists(folder_));
}

// As if other users had filled the queue.
TEST_F(FakeSlurm, WhatWasTakenBeforeARefusalGoesOnAndResumeAddsTheRest)
{
  const test::Ended ended = submit({"--shards", "3"}, {{"refused", "102"}});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_EQ(test::n_lines(ended.err), 1) << ended.err;
  EXPECT_THAT(ended.err,
              test::reports("", {"Job violates policy", "1 of 3", "vrda resume " + folder_.string()}));
  EXPECT_THAT(calls(), Not(HasSubstr("scancel")));
  queue("101|N/A|RUNNING|n1|None\n");
  EXPECT_THAT(run({"status", folder_.string()}).out, test::reports("", {"spine", "running"}));
  // Refused again, then accepted.
  EXPECT_EQ(run({"resume", folder_.string()}, {{"refused", "104"}}).exit_code, 2);
  queue(
      "101|N/A|RUNNING|n1|None\n103|1|PENDING||Dependency\n103|2|PENDING||Dependency\n"
      "103|3|PENDING||Dependency\n");
  forget_calls();
  EXPECT_EQ(run({"resume", folder_.string()}).out, "merge 105\n");
  EXPECT_THAT(calls(), HasSubstr("--dependency=afterok:103_1:103_2:103_3:101 "));
  EXPECT_THAT(calls(), Not(HasSubstr("scancel")));
}

TEST_F(FakeSlurm, AJobThatCannotBeNotedDownIsCancelled)
{
  program("sbatch", R"(echo 101; rm -f "$folder/submitted.jsonl"; mkdir "$folder/submitted.jsonl")");
  const test::Ended ended = submit({"--shards", "3"}, {{"folder", folder_.string()}});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_EQ(test::n_lines(ended.err), 1) << ended.err;
  EXPECT_THAT(ended.err, test::reports("", {"submitted.jsonl", "101"}));
  EXPECT_THAT(calls(), HasSubstr("scancel 101\n"));
}

// MaxJobCount is 40 here; twenty cases need 101 tasks.
TEST_F(FakeSlurm, MoreJobsThanTheQueueTakesAreRefusedBeforeTheFirst)
{
  std::string text =
      "[campaign]\ntitle = \"Many\"\n[[campaign.subject]]\nname = \"knee\"\njob = \"knee_right.toml\"\n";
  for (int k = 1; k <= 20; ++k) {
    text += "[[campaign.resolution]]\nname = \"r" + std::to_string(k) +
            "\"\nset = { grid = { flexion = { from = 0, to = " + std::to_string(k) + ", step = 1 } } }\n";
  }
  job_ = scratch_.write("many.toml", text);
  const test::Ended ended = submit({"--shards", "3"});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_EQ(test::n_lines(ended.err), 1) << ended.err;
  EXPECT_THAT(ended, test::refuses({"--shards", "", {"3", "20", "101"}, "40"}));
  EXPECT_EQ(calls(), "");
  EXPECT_FALSE(fs::exists(folder_));
}

}  // namespace vrda::refused_submission_test
