// Slurm's answers, the scripts that it runs, and programs started.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include "core/process.hpp"
#include "run/slurm.hpp"
#include "run/submission_scenes.hpp"
#include "support/input_error.hpp"
#include "support/process.hpp"

namespace vrda::slurm_test {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

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

TEST(RunProgram, CapturesOutputsAndHowItEnds)
{
  const fs::path here = fs::canonical(fs::temp_directory_path());
  ProcessOptions options;
  options.folder = here;
  const ProgramResult said = run_program({"/bin/bash", "-c", "pwd; echo err >&2; exit 7"}, options);
  EXPECT_EQ(said.exit_code, 7);
  EXPECT_EQ(said.out, here.string() + "\n");
  EXPECT_EQ(said.err, "err\n");
  EXPECT_FALSE(said.is_not_found);
  EXPECT_TRUE(run_program({"no-such-program-here"}, {}).is_not_found);
  EXPECT_EQ(run_program({"/bin/bash", "-c", "kill -KILL $$"}, {}).exit_code, -1);
}

TEST(OwnProgram, IsTheExecutableByItsRealPath)
{
  const fs::path own = own_program();
  EXPECT_EQ(own, fs::canonical(own));
  EXPECT_EQ(own.filename(), "test_cluster");
}

TEST(OwnProgram, IsTheLauncherWhereALoaderRunsIt)
{
  EXPECT_EQ(program_to_start("/a/bin/vrda", "vrda"), "/a/bin/vrda");
  EXPECT_EQ(program_to_start("/a/lib/glibc/ld-linux-x86-64.so.2", "/a/with-glibc/vrda"),
            "/a/with-glibc/vrda");
  EXPECT_EQ(program_to_start("/ld-linux/vrda", "vrda"), "/ld-linux/vrda");
}

}  // namespace vrda::slurm_test
