// `vrda submit`, `resume`, `status` and `task`: local processes, and programs with Slurm's names.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>
#include <csignal>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "app/scenes.hpp"
#include "core/files.hpp"
#include "support/messages.hpp"

namespace vrda::submit_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

/// Programs with Slurm's names that record their calls; sbatch runs the script immediately if `runs` is set.
class FakeSlurm : public testing::Test {
 protected:
  FakeSlurm()
  {
    program("sbatch", R"(
echo "sbatch $*" >> "$fake/calls"
id=$(($(cat "$fake/last" 2>/dev/null || echo 100) + 1)); echo $id > "$fake/last"
if [ "$id" = "${refused:-}" ]; then echo 'sbatch: error: Job violates policy' >&2; exit 1; fi
echo $id
[ -n "${runs:-}" ] || exit 0
array=
while [[ $1 == --* ]]; do
  case $1 in --array=*) array=${1#--array=}; array=${array%\%*} ;; --output=*) log=${1#--output=} ;; esac
  shift
done
export SLURM_JOB_ID=$id SLURM_CPUS_PER_TASK=1
if [ -z "$array" ]; then bash "$@" >> "${log}" 2>&1; exit 0; fi
export SLURM_ARRAY_JOB_ID=$id
for part in ${array//,/ }; do
  for SLURM_ARRAY_TASK_ID in $(seq ${part%-*} ${part#*-}); do
    export SLURM_ARRAY_TASK_ID
    bash "$@" >> "${log//%a/$SLURM_ARRAY_TASK_ID}" 2>&1
  done
done
exit 0)");
    program("squeue", "cat \"$fake/queue\" 2>/dev/null; true");
    program("scontrol", "echo 'MaxArraySize = 11'; echo 'MaxJobCount = 40'");
    program("scancel", "echo \"scancel $*\" >> \"$fake/calls\"");
  }

  void program(const std::string& name, const std::string& body)
  {
    std::filesystem::permissions(scratch_.write("bin/" + name, "#!/bin/bash\n" + body + "\n"),
                                 std::filesystem::perms::owner_all);
  }

  test::Ended run(std::vector<std::string> words, const std::map<std::string, std::string>& environment = {})
  {
    test::Command command = test::vrda(std::move(words));
    command.environment = environment;
    command.environment["fake"] = scratch_.path().string();
    command.environment["PATH"] = (scratch_.path() / "bin").string() + ":/usr/bin:/bin";
    return test::run(command);
  }

  test::Ended submit(const std::vector<std::string>& more,
                     const std::map<std::string, std::string>& environment = {})
  {
    std::vector<std::string> words{"submit", job_.string(), "-o",    folder_.string(),
                                   "--time", "10",          "--mem", "200M"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words, environment);
  }

  void queue(const std::string& lines) { scratch_.write("queue", lines); }
  std::string calls() const { return test::text_of(scratch_.path() / "calls"); }
  void forget_calls() const { std::filesystem::remove(scratch_.path() / "calls"); }

  test::Scratch scratch_;
  std::filesystem::path job_ = test::small_knee_job(scratch_, "right");
  std::filesystem::path folder_ = scratch_.path() / "it's a \"folder\"";
};

/// The right knee over that many ranges of flexion.
std::string campaign_of(int n_cases)
{
  std::string text =
      "[campaign]\ntitle = \"Many\"\n[[campaign.subject]]\nname = \"knee\"\njob = \"knee_right.toml\"\n";
  for (int k = 1; k <= n_cases; ++k) {
    text += "[[campaign.resolution]]\nname = \"r" + std::to_string(k) +
            "\"\nset = { grid = { flexion = { from = 0, to = " + std::to_string(k) + ", step = 1 } } }\n";
  }
  return text;
}

std::string whole_run(const test::Scratch& scratch, const fs::path& job)
{
  const fs::path output = scratch.path() / "whole.h5";
  EXPECT_EQ(test::run_vrda({"run", job.string(), "-o", output.string(), "--quiet"}).exit_code, 0);
  return test::sha256_of_file(output);
}

nlohmann::json status_of(const fs::path& folder)
{
  const test::Ended ended = test::run_vrda({"status", folder.string(), "--json"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  return nlohmann::json::parse(ended.out);
}

std::vector<std::string> states_of(const fs::path& folder)
{
  std::vector<std::string> states;
  const nlohmann::json status = status_of(folder);
  for (const auto& task : status["cases"][0]["tasks"]) states.push_back(task["state"]);
  return states;
}

// Fewer, as many and more shards than the seven rows.
TEST(SubmitLocal, AnyNumberOfShardsGivesTheBytesOfOneRun)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  const std::string whole = whole_run(scratch, job);
  for (const std::string n : {"1", "10"}) {
    SCOPED_TRACE(n);
    const fs::path folder = scratch.path() / ("it's " + n + " \"shards\"");
    const test::Ended ended = test::run_vrda(
        {"submit", job.string(), "--shards", n, "--local", "--workers", "2", "-o", folder.string()});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_EQ(ended.out, folder.string() + "\n");
    EXPECT_EQ(test::sha256_of_file(folder / "knee_right.h5"), whole);
    EXPECT_FALSE(fs::exists(folder / "knee_right.h5.case.json"));
    EXPECT_FALSE(fs::exists(folder / "knee_right.h5.spine.journal"));
    EXPECT_THAT(states_of(folder), testing::Each("done"));
    EXPECT_EQ(test::run_vrda({"resume", folder.string(), "--local"}).exit_code, 0);
  }
}

// Ended by SIGKILL, which cannot be handled, and by SIGTERM: the next start resumes from the journals.
TEST(SubmitLocal, KilledItGoesOnAndGivesTheSameBytes)
{
  const test::Scratch scratch;
  const fs::path job = test::longer_knee_job(scratch);
  const std::string whole = whole_run(scratch, job);
  for (const int signal : {SIGKILL, SIGTERM}) {
    SCOPED_TRACE(signal);
    const fs::path folder = scratch.path() / std::to_string(signal);
    test::Process process(test::vrda(
        {"submit", job.string(), "--shards", "3", "--local", "--workers", "2", "-o", folder.string()}));
    test::wait_for_bytes(process, folder / "knee_right.h5.shard-1-of-3.journal", 3000);
    ASSERT_TRUE(process.is_running()) << "ended before it could be killed";
    process.send(signal);
    EXPECT_EQ(process.wait().exit_code, signal == SIGKILL ? -1 : 4);
    EXPECT_FALSE(fs::exists(folder / "knee_right.h5"));
    const test::Ended ended = test::run_vrda({"resume", folder.string(), "--local"});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_THAT(ended.err, test::reports("shard 1 of 3"));
    EXPECT_THAT(ended.err, test::reports("merge"));
    EXPECT_EQ(test::sha256_of_file(folder / "knee_right.h5"), whole);
    const test::Ended again = test::run_vrda({"resume", folder.string(), "--local"});
    EXPECT_EQ(again.exit_code, 0);
    EXPECT_THAT(again.err, Not(test::reports("merge")));
  }
}

TEST(SubmitLocal, AFailureSaysWhyAndIsMendedByResume)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right");
  const fs::path folder = scratch.path() / "sub";
  // This shard's journal cannot be written.
  fs::create_directories(folder / "knee_right.h5.shard-2-of-3.journal");
  const test::Ended ended =
      test::run_vrda({"submit", job.string(), "--shards", "3", "--local", "-o", folder.string()});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err, test::reports("shard 2 of 3", "failed"));
  EXPECT_THAT(states_of(folder), testing::ElementsAre("done", "done", "failed", "done", "waiting"));
  const nlohmann::json failed = status_of(folder)["cases"][0]["tasks"][2];
  EXPECT_THAT(failed["reason"].get<std::string>(), test::reports("knee_right.h5.shard-2-of-3.journal"));
  fs::remove(folder / "knee_right.h5.shard-2-of-3.journal");
  const test::Ended resumed = test::run_vrda({"resume", folder.string(), "--local"});
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_THAT(resumed.err, Not(test::reports("shard 1 of 3")));
  EXPECT_EQ(test::sha256_of_file(folder / "knee_right.h5"), whole_run(scratch, job));
}

// The state left by a process on a crashed machine, which no longer holds its lock.
TEST(SubmitLocal, TasksOfALostMachineAreRestarted)
{
  const test::Scratch scratch;
  const fs::path job = test::small_knee_job(scratch, "right"), folder = scratch.path() / "sub";
  fs::create_directories(folder / "knee_right.h5.shard-2-of-3.journal");
  ASSERT_EQ(
      test::run_vrda({"submit", job.string(), "--shards", "3", "--local", "-o", folder.string()}).exit_code,
      2);
  fs::remove(folder / "knee_right.h5.shard-2-of-3.journal");
  const fs::path file = folder / "tasks/knee_right.shard-2-of-3.json";
  auto state = nlohmann::json::parse(test::text_of(file));
  state["state"] = "running";
  state["host"] = "node17";
  scratch.write("sub/tasks/knee_right.shard-2-of-3.json", state.dump());
  // While it runs, a repeated task waits.
  auto lock = OutputLock::acquire(file.string(), "vrda task", {});
  EXPECT_THAT(test::run_vrda({"status", folder.string()}).out,
              test::reports("", {"shard 2 of 3", "running", "2 of 10", "node17"}));
  test::Process waiting(
      test::vrda({"task", folder.string(), "--kind", "shard", "--first", "1", "--shard", "2"}));
  while (waiting.is_running() && waiting.said().find("waiting for vrda task, process") == std::string::npos)
    usleep(2000);
  EXPECT_TRUE(waiting.is_running());
  waiting.send(SIGTERM);
  EXPECT_EQ(waiting.wait().exit_code, 4);
  EXPECT_EQ(nlohmann::json::parse(test::text_of(file)), state);
  lock.reset();
  EXPECT_THAT(test::run_vrda({"status", folder.string()}).out, test::reports("", {"shard 2 of 3", "lost"}));
  const test::Ended resumed = test::run_vrda({"resume", folder.string(), "--local"});
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_THAT(resumed.err, test::reports("shard 2 of 3", "lost"));
  EXPECT_EQ(test::sha256_of_file(folder / "knee_right.h5"), whole_run(scratch, job));
}

TEST(SubmitLocal, ACampaignMakesEveryCaseAndItsIndex)
{
  const test::Scratch scratch;
  test::small_knee_job(scratch, "right");
  test::small_knee_job(scratch, "left");
  const fs::path campaign = scratch.write("sides.toml", R"([campaign]
title = "Both sides"
[[campaign.subject]]
name = "right"
job = "knee_right.toml"
[[campaign.subject]]
name = "left"
job = "knee_left.toml"
)");
  std::vector<std::string> tables;
  for (const std::string n : {"1", "2"}) {
    const fs::path folder = scratch.path() / n;
    const test::Ended ended =
        test::run_vrda({"submit", campaign.string(), "--shards", n, "--local", "-o", folder.string()});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_EQ(status_of(folder)["summary"], "2 of 2 cases done; 70 of 70 attitudes");
    tables.push_back(test::text_of(folder / "index.csv"));
    EXPECT_EQ(test::sha256_of_file(folder / "right" / "right.h5"),
              whole_run(scratch, scratch.path() / "knee_right.toml"));
  }
  EXPECT_EQ(tables[0], tables[1]);
  EXPECT_THAT(tables[0], HasSubstr("right,"));
}

TEST(Submit, ARepeatedSubmissionIsRefusedWithAHintToResume)
{
  const test::Scratch scratch;
  const std::string job = test::small_job(scratch).string(), folder = (scratch.path() / "sub").string();
  const auto submit = [&](const std::string& n) {
    return test::run_vrda({"submit", job, "--shards", n, "--local", "-o", folder});
  };
  ASSERT_EQ(submit("2").exit_code, 0);
  const test::Ended same = submit("2"), other = submit("3");
  EXPECT_THAT(same, test::refuses({folder, "", "same", "vrda resume"}));
  EXPECT_THAT(other, test::refuses({folder, "", "another"}));
}

TEST(Submit, AModelOfAnotherRunIsNotReplaced)
{
  const test::Scratch scratch;
  const std::string job = test::small_job(scratch).string();
  ASSERT_EQ(
      test::run_vrda({"run", job, "-o", (scratch.path() / "sub/small.h5").string(), "--quiet"}).exit_code, 0);
  const test::Ended ended =
      test::run_vrda({"submit", job, "--local", "-o", (scratch.path() / "sub").string()});
  EXPECT_THAT(ended, test::refuses({.file = "small.h5"}));
  EXPECT_FALSE(fs::exists(scratch.path() / "sub/submission.json"));
}

TEST_F(FakeSlurm, SubmitPrintsTheIdsOfJobsThatWaitForEachOther)
{
  const test::Ended ended = submit({"--shards", "3", "--max-parallel", "2", "--partition", "batch"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(ended.out, "spine 101, shards 102_[1-3%2], merge 103\n");
  const std::string calls = this->calls();
  EXPECT_THAT(
      calls,
      HasSubstr("--array=1-3%2 --dependency=afterok:101 --kill-on-invalid-dep=yes scripts/shard.sbatch"));
  EXPECT_THAT(calls, HasSubstr("--dependency=afterok:102 --kill-on-invalid-dep=yes scripts/merge.sbatch"));
  EXPECT_THAT(test::text_of(folder_ / "scripts/shard.sbatch"), HasSubstr("#SBATCH --partition=batch\n"));
  queue(
      "101|N/A|RUNNING|n1|None\n102|1|PENDING||Dependency\n102|2|PENDING||Dependency\n"
      "102|3|PENDING||Dependency\n103|N/A|PENDING||Dependency\n");
  const test::Ended status = run({"status", folder_.string()});
  EXPECT_THAT(status.out, test::reports("", {"0 of 3", "3 queued", "0 of 35"}));
  EXPECT_THAT(status.out, test::reports("", {"102_3", "Dependency"}));
  forget_calls();
  const test::Ended resumed = run({"resume", folder_.string()});
  EXPECT_EQ(resumed.exit_code, 0);
  EXPECT_THAT(resumed.err, test::reports("", "5"));
  EXPECT_EQ(this->calls(), "");
}

TEST_F(FakeSlurm, ScriptsMakeTheModelOfAPlainRun)
{
  ASSERT_EQ(submit({"--shards", "3"}, {{"runs", "yes"}}).exit_code, 0);
  EXPECT_EQ(test::sha256_of_file(folder_ / "knee_right.h5"), whole_run(scratch_, job_));
  const test::Ended status = run({"status", folder_.string()});
  EXPECT_THAT(status.out, test::reports("", {"3 of 3", "35 of 35"}));
  EXPECT_EQ(run({"resume", folder_.string()}).exit_code, 0);
}

TEST_F(FakeSlurm, ResumeSubmitsOnlyWhatIsMissing)
{
  ASSERT_EQ(submit({"--shards", "3"}).exit_code, 0);
  // The results of a spine and two shards of three.
  for (const std::vector<std::string>& words : {std::vector<std::string>{"--kind", "spine"},
                                                {"--kind", "shard", "--shard", "1"},
                                                {"--kind", "shard", "--shard", "3"}}) {
    std::vector<std::string> all{"task", folder_.string()};
    all.insert(all.end(), words.begin(), words.end());
    ASSERT_EQ(run(all).exit_code, 0);
  }
  queue("102|2|TIMEOUT|n2|TimeLimit\n103|N/A|PENDING||DependencyNeverSatisfied\n");
  const test::Ended status = run({"status", folder_.string()});
  EXPECT_THAT(status.out, test::reports("", {"2 of 3", "1 failed"}));
  EXPECT_THAT(status.out, test::reports("", {"TIMEOUT", "TimeLimit"}));
  forget_calls();
  const test::Ended resumed = run({"resume", folder_.string(), "--time", "20"}, {{"runs", "yes"}});
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(resumed.out, "shards 104_[2], merge 105\n");
  EXPECT_THAT(resumed.err, test::reports("shard 2 of 3", {"TIMEOUT", "TimeLimit"}));
  EXPECT_THAT(calls(), testing::StartsWith("scancel 103\nsbatch"));
  EXPECT_THAT(test::text_of(folder_ / "scripts/shard.sbatch"), HasSubstr("#SBATCH --time=20\n"));
  EXPECT_EQ(test::sha256_of_file(folder_ / "knee_right.h5"), whole_run(scratch_, job_));
}

TEST_F(FakeSlurm, CampaignsAreArraysThatSlurmTakes)
{
  job_ = scratch_.write("many.toml", campaign_of(25));
  // At most 20 tasks, half of MaxJobCount, in arrays of numbers below 11.
  const test::Ended ended = submit({});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(ended.out, "cases 101_[1-10], cases 102_[1-3], index 103\n");
  EXPECT_THAT(calls(), HasSubstr("--array=1-3 scripts/run.sbatch 20 2\n"));
  EXPECT_THAT(calls(), HasSubstr("--dependency=afterany:101:102"));
}

TEST_F(FakeSlurm, ResumeKeepsTheCasesOfATaskWhileTasksAreUnderWay)
{
  std::string text = "[campaign]\ntitle = \"Some\"\n";
  for (const std::string name : {"a", "b", "c"})
    text += "[[campaign.subject]]\nname = \"" + name + "\"\njob = \"knee_right.toml\"\n";
  job_ = scratch_.write("some.toml", text);
  ASSERT_EQ(submit({}).out, "cases 101_[1-3], index 102\n");
  queue("101|1|FAILED|n1|NonZeroExitCode\n101|2|RUNNING|n1|None\n101|3|PENDING||Priority\n");
  forget_calls();
  const test::Ended refused = run({"resume", folder_.string(), "--cases-per-task", "2"});
  EXPECT_EQ(test::n_lines(refused.err), 1) << refused.err;
  EXPECT_THAT(refused, test::refuses({"--cases-per-task", "", {"2", "1"}}));
  EXPECT_EQ(calls(), "");
  EXPECT_EQ(run({"resume", folder_.string(), "--cases-per-task", "1"}).out, "cases 103_[1], index 104\n");
}

// sbatch passes its environment to the job.
TEST_F(FakeSlurm, JobsSubmittedWithinAnArrayDoNotBelongToIt)
{
  ASSERT_EQ(submit({"--shards", "2"}, {{"runs", "yes"},
                                       {"SLURM_JOB_ID", "99"},
                                       {"SLURM_ARRAY_JOB_ID", "98"},
                                       {"SLURM_ARRAY_TASK_ID", "1"},
                                       {"SLURM_RESTART_COUNT", "1"}})
                .exit_code,
            0);
  for (const auto& [task, job] : {std::pair{"spine", "101"}, {"shard-1-of-2", "102_1"}, {"merge", "103"}}) {
    const auto state = nlohmann::json::parse(
        test::text_of(folder_ / "tasks" / ("knee_right." + std::string(task) + ".json")));
    EXPECT_EQ(state["slurm_job"], job);
    EXPECT_EQ(state["restarts"], 0);
  }
}

TEST_F(FakeSlurm, ADryRunWritesNothing)
{
  const test::Ended ended = submit({"--shards", "3", "--dry-run"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr("==> scripts/shard.sbatch <==\n#!/bin/bash\n"));
  EXPECT_THAT(ended.out, HasSubstr("job2=$(sbatch --parsable"));
  EXPECT_FALSE(fs::exists(folder_));
  EXPECT_EQ(calls(), "");
}

TEST_F(FakeSlurm, WithoutSlurmOneLineNamesTheOtherWay)
{
  for (const char* name : {"sbatch", "squeue", "scontrol", "scancel"})
    fs::remove(scratch_.path() / "bin" / name);
  test::Command command = test::vrda(
      {"submit", job_.string(), "-o", (scratch_.path() / "none").string(), "--time", "10", "--mem", "1G"});
  command.environment["PATH"] = (scratch_.path() / "bin").string();
  const test::Ended without = test::run(command);
  EXPECT_EQ(test::n_lines(without.err), 1) << without.err;
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_THAT(without.err, test::reports("", "--local"));
  EXPECT_FALSE(fs::exists(scratch_.path() / "none"));
}

// A spine journal that another process holds: its task waits, and can be interrupted there.
class HeldSpine : public FakeSlurm {
 protected:
  HeldSpine()
  {
    EXPECT_EQ(submit({"--shards", "3"}).exit_code, 0);
    test::edit(folder_ / "submission.json", "\"time\": \"10\"", "\"time\": \"1\"");
    EXPECT_EQ(test::run(spine()).exit_code, 0);
    fs::remove(state());
    lock_ = open((folder_ / "knee_right.h5.spine.journal").c_str(), O_RDWR | O_CLOEXEC);
    EXPECT_EQ(flock(lock_, LOCK_EX), 0);
  }
  ~HeldSpine() override { close(lock_); }

  fs::path state() const { return folder_ / "tasks/knee_right.spine.json"; }

  test::Command spine() const
  {
    test::Command command = test::vrda({"task", folder_.string(), "--kind", "spine"});
    command.environment["SLURM_JOB_ID"] = "101";
    return command;
  }

  int lock_ = -1;
};

// The predecessor may end soon: the time limit is not at fault.
TEST_F(HeldSpine, ATaskReportsThatItWaitsForItAndIsRestartedAfterAnInterrupt)
{
  test::Process process(spine());
  while (process.is_running() && process.said().find("waiting for the run") == std::string::npos)
    usleep(2000);
  while (process.is_running() &&
         test::text_of(state()).find("waiting for another process") == std::string::npos) {
    usleep(2000);
  }
  ASSERT_TRUE(process.is_running());
  queue("101|N/A|RUNNING|n1|None\n");
  EXPECT_THAT(run({"status", folder_.string()}).out, test::reports("", {"n1", "waiting", "journal"}));
  process.send(SIGTERM);
  process.send(SIGTERM);
  EXPECT_EQ(process.wait().exit_code, 4);
  const auto left = nlohmann::json::parse(test::text_of(state()));
  EXPECT_EQ(left["state"], "interrupted");
  EXPECT_EQ(left["slurm_job"], "101");
  EXPECT_EQ(flock(lock_, LOCK_UN), 0);
  EXPECT_EQ(test::run(spine()).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(test::text_of(state()))["state"], "done");
}

TEST_F(HeldSpine, TheStateOfASuccessorIsLeftAlone)
{
  test::Process process(spine());
  test::wait_for_bytes(process, state(), 1);
  ASSERT_TRUE(process.is_running());
  test::edit(state(), "\"restarts\": 0", "\"restarts\": 1");
  const std::string of_another = test::text_of(state());
  process.send(SIGTERM);
  process.wait();
  EXPECT_EQ(test::text_of(state()), of_another);
}

TEST_F(HeldSpine, AKilledTaskIsNotedDownByItsScript)
{
  test::Process process(spine());
  test::wait_for_bytes(process, state(), 1);
  process.send(SIGKILL);
  process.wait();
  test::Command note = spine();
  note.arguments.insert(note.arguments.end(), {"--ended", "137"});
  // The state of another start is not changed.
  note.environment["SLURM_RESTART_COUNT"] = "1";
  EXPECT_EQ(test::run(note).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(test::text_of(state()))["state"], "running");
  note.environment["SLURM_RESTART_COUNT"] = "0";
  EXPECT_EQ(test::run(note).exit_code, 0);
  queue("101|N/A|FAILED|n1|NonZeroExitCode\n");
  EXPECT_THAT(run({"status", folder_.string()}).out, test::reports("", "signal 9"));
}

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
  job_ = scratch_.write("many.toml", campaign_of(20));
  const test::Ended ended = submit({"--shards", "3"});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_EQ(test::n_lines(ended.err), 1) << ended.err;
  EXPECT_THAT(ended, test::refuses({"--shards", "", {"3", "20", "101"}, "40"}));
  EXPECT_EQ(calls(), "");
  EXPECT_FALSE(fs::exists(folder_));
}

}  // namespace vrda::submit_test
