#include "run/slurm.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>

#include "run/submission_scenes.hpp"
#include "support/input_error.hpp"
#include "support/process.hpp"

namespace vrda::slurm_scripts_test {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr run::TaskKind every_kind[] = {run::TaskKind::spine, run::TaskKind::shard, run::TaskKind::merge,
                                        run::TaskKind::run, run::TaskKind::index};

TEST(Scripts, TimeLimitsAreReadAsSbatchReadsThem)
{
  struct Row {
    const char* text;
    std::int64_t seconds;
  };
  for (const Row& row : {Row{"30", 1800}, Row{"2:30", 150}, Row{"1:02:03", 3723}, Row{"1-12", 129600},
                         Row{"1-1:30", 91800}, Row{"2-0:0:5", 172805}, Row{"0", 0}}) {
    EXPECT_EQ(run::seconds_of_time(row.text), row.seconds) << row.text;
  }
  for (const std::string text : {"", "soon", "1:2:3:4", "-5", "1-", "1-2-3", "3h", " 3", "99999999999"}) {
    EXPECT_EQ(test::input_error([&] { run::seconds_of_time(text); }).file, "--time") << text;
  }
  EXPECT_EQ(run::warning_seconds(60), 15);
  EXPECT_EQ(run::warning_seconds(120), 30);
  EXPECT_EQ(run::warning_seconds(300), 30);
  EXPECT_EQ(run::warning_seconds(600), 60);
  EXPECT_EQ(run::warning_seconds(86400), 120);
}

TEST(Scripts, WhatWouldBreakAScriptIsRefused)
{
  const auto with = [](std::string run::SlurmOptions::*option, const char* value) {
    run::SlurmOptions options;
    options.*option = value;
    return options;
  };
  const auto with_extra = [](const std::vector<std::string>& lines) {
    run::SlurmOptions options;
    options.extra = lines;
    return options;
  };
  for (const auto& [option, options] :
       {std::pair("--partition", with(&run::SlurmOptions::partition, "a b")),
        std::pair("--mem", with(&run::SlurmOptions::memory, "2G\n#SBATCH --exclusive")),
        std::pair("--account", with(&run::SlurmOptions::account, "$(id)")),
        std::pair("--qos", with(&run::SlurmOptions::qos, "a;b")),
        std::pair("--time", with(&run::SlurmOptions::time, "0")),
        std::pair("--extra", with_extra({"constraint=a"})), std::pair("--extra", with_extra({""})),
        std::pair("--extra", with_extra({"--a\n--b"}))}) {
    EXPECT_EQ(test::input_error([&] { run::require_valid_options(options); }).file, option);
  }
  EXPECT_NO_THROW(run::require_valid_options(with(&run::SlurmOptions::partition, "batch,long")));
  EXPECT_NO_THROW(run::require_valid_options(with_extra({"--constraint=\"a b\"", "-C avx2"})));
  for (const std::string folder : {"/a\\b", "/a\nb"})
    EXPECT_EQ(test::input_error([&] { run::require_log_folder(folder); }).file, folder);
}

const std::vector<std::string> odd_paths = {
    "/plain", "/with space", "/it's \"quoted\"", "/$HOME `id` \\ * ?", "/new\nline", "/\xff\xfe", "/-o"};

TEST(Scripts, AnyPathIsOneWordOfAShell)
{
  const test::Scratch scratch;
  for (const std::string& path : odd_paths) {
    EXPECT_EQ(test::run({"/bin/bash", {"-c", "printf '%s|' " + run::shell_word(path)}, {}, {}}).out,
              path + "|");
    run::Submission submission = test::one_case(3);
    submission.program = path + "/vrda";
    for (const run::TaskKind kind : every_kind) {
      const fs::path script = scratch.write("script", run::script_of(kind, path, submission));
      EXPECT_EQ(test::run({"/bin/bash", {"-n", script.string()}, {}, {}}).err, "");
    }
  }
}

TEST(Scripts, OptionsAreWrittenOnceEach)
{
  run::Submission submission = test::one_case(3);
  submission.slurm = {"batch", "1:00:00", "2G", "us", "high", 4, 0, 0, {"--constraint=avx2"}};
  const std::string script = run::script_of(run::TaskKind::shard, "/here", submission);
  for (const char* line :
       {"--partition=batch", "--time=1:00:00", "--mem=2G", "--account=us", "--qos=high", "--cpus-per-task=4",
        "--requeue", "--open-mode=append", "--signal=B:TERM@120", "--constraint=avx2"}) {
    EXPECT_THAT(script, HasSubstr("\n#SBATCH " + std::string(line) + "\n"));
  }
  submission.slurm.partition.clear();
  EXPECT_THAT(run::script_of(run::TaskKind::shard, "/here", submission), Not(HasSubstr("--partition")));
}

TEST(Scripts, CommandsNameWhatTheyWaitFor)
{
  run::Submission submission = test::one_case(8);
  submission.cases[0].spec.name = "-a 5% knee";
  submission.slurm.max_parallel = 4;
  const std::vector<run::PlannedJob> jobs = run::jobs_of_work(submission, run::all_work(submission), {});
  const std::vector<std::string> ids{"12", "13"};
  const std::vector<std::string> shards = run::sbatch_words("/a%b", submission, jobs[1], ids);
  EXPECT_THAT(shards, Contains("--array=1-8%4"));
  EXPECT_THAT(shards, Contains("--dependency=afterok:12"));
  EXPECT_THAT(shards, Contains("--kill-on-invalid-dep=yes"));
  EXPECT_THAT(shards, Contains("--output=/a%%b/logs/-a 5%% knee.shard-%a-of-8.log"));
  EXPECT_THAT(shards, Contains("--job-name=vrda-shard--a-5--knee"));
  EXPECT_EQ(shards.back(), "-a 5% knee");
  EXPECT_THAT(run::sbatch_words("/a%b", submission, jobs[2], ids), Contains("--dependency=afterok:13"));
  EXPECT_THAT(run::sbatch_words("/a%b", submission, jobs[0], ids), Not(Contains(HasSubstr("--dependency"))));
  EXPECT_EQ(run::id_text("13", jobs[1], submission.slurm), "13_[1-8%4]");
  EXPECT_EQ(run::id_text("12", jobs[0], submission.slurm), "12");
}

TEST(Scripts, ADryRunIsAScriptOfItsOwn)
{
  const test::Scratch scratch;
  const run::Submission submission = test::one_case(3);
  const fs::path here = scratch.path() / "it's";
  fs::create_directories(here);
  const std::string lines = run::sbatch_lines(here.string(), submission,
                                              run::jobs_of_work(submission, run::all_work(submission), {}));
  const fs::path sbatch =
      scratch.write("bin/sbatch", "#!/bin/bash\necho \"$@\" >> ../said\nwc -l < ../said\n");
  fs::permissions(sbatch, fs::perms::owner_all);
  const test::Ended ended = test::run(
      {"/bin/bash", {"-ec", lines}, {{"PATH", (scratch.path() / "bin").string() + ":/usr/bin:/bin"}}, {}});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  const std::string said = test::read_bytes(scratch.path() / "said");
  EXPECT_THAT(said,
              HasSubstr("--dependency=afterok:1 --kill-on-invalid-dep=yes scripts/shard.sbatch knee\n"));
  EXPECT_THAT(said,
              HasSubstr("--dependency=afterok:2 --kill-on-invalid-dep=yes scripts/merge.sbatch knee\n"));
}

// A shard's script with programs that only record their arguments.
class Wrapper : public testing::Test {
 protected:
  Wrapper()
  {
    program("vrda", "printf '%s|' \"$@\" >> \"$said\"; echo >> \"$said\"; eval \"$act\"");
    program("scontrol", "echo scontrol \"$@\" >> \"$said\"");
    program("squeue", "echo \"$queue\"");
  }

  void program(const std::string& name, const std::string& body)
  {
    const fs::path file = scratch_.write(folder_ + "/" + name, "#!/bin/bash\n" + body + "\n");
    fs::permissions(file, fs::perms::owner_all);
  }

  // `act` is the command of vrda, `queue` the output of squeue.
  test::Command command(const std::string& act, const std::string& queue, const std::string& restarts = "0")
  {
    const fs::path bin = scratch_.path() / folder_;
    run::Submission submission = test::one_case(8);
    submission.program = (bin / "vrda").string();
    const fs::path script =
        scratch_.write("shard.sbatch", run::script_of(run::TaskKind::shard, bin.string(), submission));
    return {"/bin/bash",
            {script.string(), "knee"},
            {{"PATH", bin.string() + ":/usr/bin:/bin"},
             {"said", said().string()},
             {"act", act},
             {"queue", queue},
             {"SLURM_JOB_ID", "21"},
             {"SLURM_ARRAY_JOB_ID", "13"},
             {"SLURM_ARRAY_TASK_ID", "3"},
             {"SLURM_CPUS_PER_TASK", "2"},
             {"SLURM_RESTART_COUNT", restarts}},
            {}};
  }

  fs::path said() const { return scratch_.path() / "said"; }
  std::string what_was_said() const { return test::read_bytes(said()); }

  void wait_until_said(test::Process& process, const std::string& text)
  {
    while (process.is_running() && what_was_said().find(text) == std::string::npos) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    ASSERT_THAT(what_was_said(), HasSubstr(text));
  }

  const std::string folder_ = "it's a \"bin\"";
  test::Scratch scratch_;
};

TEST_F(Wrapper, RequeuesAnInterruptedTaskOnly)
{
  const std::string last = std::to_string(run::max_restarts);
  struct Row {
    std::string act, queue, restarts;  // of vrda, of squeue, the task's count
    int exit_code;
    bool is_requeued;
  };
  for (const Row& row :
       {Row{"exit 0", "0 RUNNING None", "0", 0, false}, Row{"exit 2", "0 RUNNING None", "0", 2, false},
        Row{"exit 3", "0 RUNNING None", "0", 3, false}, Row{"exit 5", "0 RUNNING None", "0", 5, false},
        Row{"exit 4", "0 RUNNING None", "0", 0, true}, Row{"exit 4", "0 COMPLETING TimeLimit", "0", 0, true},
        // cancelled
        Row{"exit 4", "0 COMPLETING None", "0", 4, false}, Row{"exit 4", "0 CANCELLED None", "0", 4, false},
        Row{"exit 4", "", "0", 4, false},
        // Slurm considered its node lost and restarted the task elsewhere.
        Row{"exit 4", "2 RUNNING None", "1", 4, false}, Row{"exit 4", "1 RUNNING None", "1", 0, true},
        Row{"exit 4", last + " RUNNING None", last, 4, false},
        // SIGTERM before vrda has a handler
        Row{"kill -TERM $$", "0 RUNNING None", "0", 0, true}}) {
    SCOPED_TRACE(row.act + ": " + row.queue);
    std::filesystem::remove(said());
    const test::Ended ended = test::run(command(row.act, row.queue, row.restarts));
    EXPECT_EQ(ended.exit_code, row.exit_code) << ended.err;
    EXPECT_EQ(what_was_said(), "task|" + (scratch_.path() / folder_).string() +
                                   "|--kind|shard|--case=knee|--shard|3|--cpus|2|\n" +
                                   (row.is_requeued ? "scontrol requeue 13_3\n" : ""));
  }
}

// A second signal does not cut it short.
TEST_F(Wrapper, PassesSignalsOnAndStaysUntilVrdaHasEnded)
{
  const std::string act =
      "trap 'echo signalled >> \"$said\"' TERM; echo ready >> \"$said\"; "
      "until [ \"$(grep -c signalled \"$said\")\" -ge 2 ]; do sleep 0.01; done; echo flushed >> \"$said\"; "
      "exit 4";
  test::Process process(command(act, "0 RUNNING None"));
  wait_until_said(process, "ready");
  process.send(SIGTERM);
  wait_until_said(process, "signalled");
  process.send(SIGTERM);
  EXPECT_EQ(process.wait().exit_code, 0);
  EXPECT_THAT(what_was_said(), HasSubstr("signalled\nsignalled\nflushed\nscontrol requeue 13_3\n"));
}

// E.g. out of memory: vrda could not record it, so the script does.
TEST_F(Wrapper, RecordsAKill)
{
  const std::string act = "case \"$*\" in *ended*) ;; *) kill -KILL $$ ;; esac";
  EXPECT_EQ(test::run(command(act, "0 RUNNING None")).exit_code, 137);
  EXPECT_THAT(what_was_said(), HasSubstr("|--cpus|2|--ended|137|\n"));
  EXPECT_THAT(what_was_said(), Not(HasSubstr("scontrol")));
}

}  // namespace vrda::slurm_scripts_test
