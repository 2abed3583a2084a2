#include "run/local_run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "run/slurm.hpp"
#include "run/status.hpp"
#include "run/submission_scenes.hpp"
#include "support/refusal.hpp"

namespace vrda::local_run_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
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

}  // namespace vrda::local_run_test
