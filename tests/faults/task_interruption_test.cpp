// Slurm tasks that are signalled to end at a certain system call: their state, and how they resume.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "app/scenes.hpp"
#include "faults/faulty_run.hpp"
#include "support/messages.hpp"

namespace vrda::test::task_interruption_test {

namespace fs = std::filesystem;

// A submission of one case in a given number of shards, with no task done yet.
class TaskInterruption : public FaultyRun {
 protected:
  TaskInterruption() : wanted_(sha256_of_file(folder_ / "a.h5")) {}

  void submit(const std::string& n_shards, const std::string& time) { submit(job_, n_shards, time); }

  /// Two unsharded cases, `a` and `b`, of the same job.
  void submit_two(const std::string& time)
  {
    std::string campaign = "[campaign]\ntitle = \"Two\"\n";
    for (const std::string name : {"a", "b"}) {
      campaign +=
          "[[campaign.subject]]\nname = \"" + name + "\"\njob = \"" + job_.filename().string() + "\"\n";
    }
    submit(scratch_.write("two.toml", campaign), "1", time);
    for (const std::string name : {"a", "b"}) fs::remove(model_of(name));
  }

  void submit(const fs::path& job, const std::string& n_shards, const std::string& time)
  {
    std::vector<std::string> words = command().arguments;  // run JOB -o FILE --quiet --threads 1 --set ...
    words[0] = "submit";
    words[1] = job;
    words[3] = folder_;
    words.erase(words.begin() + 5, words.begin() + 7);
    words.insert(words.end(), {"--shards", n_shards, "--local", "--workers", "1", "--time", time});
    clear();
    EXPECT_EQ(test::run(vrda(words)).exit_code, 0);
    fs::remove(model());
    fs::remove_all(folder_ / "tasks");
    fs::create_directory(folder_ / "tasks");
  }

  Command task(const std::string& kind, const std::string& shard = "") const
  {
    std::vector<std::string> words{"task", folder_, "--kind", kind};
    if (!shard.empty()) words.insert(words.end(), {"--shard", shard});
    Command command = vrda(words);
    command.environment["SLURM_JOB_ID"] = "101";
    return command;
  }

  static Command restarted(Command command, int n_restarts)
  {
    command.environment["SLURM_RESTART_COUNT"] = std::to_string(n_restarts);
    return command;
  }

  /// Signalled twice, as by Slurm and by the script, at the fault's call.
  Ended signalled_at(const Command& command, const Fault& fault)
  {
    return held_at(command, fault, [](const Process& process) {
      process.send(SIGTERM);
      process.send(SIGTERM);
    });
  }

  template <typename Meanwhile>
  Ended held_at(const Command& command, const Fault& fault, const Meanwhile& meanwhile)
  {
    const fs::path gate = scratch_.path() / "gate", held = scratch_.path() / "gate.held";
    fs::remove(gate);
    fs::remove(held);
    Command with_hold = with_fault(command, in_folder(fault));
    with_hold.environment["VRDA_FAULT_GATE"] = gate;
    Process process(with_hold);
    while (process.is_running() && !fs::exists(held))
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    EXPECT_TRUE(process.is_running()) << "never came to " << fault.call << " of " << fault.file;
    meanwhile(process);
    scratch_.write("gate", "");
    return process.wait();
  }

  void expect_state(const std::string& task, const std::string& state, const Values& reason) const
  {
    expect_state_of(job_.stem().string() + "." + task, state, reason);
  }

  void expect_state_of(const std::string& stem, const std::string& state, const Values& reason) const
  {
    const auto json = nlohmann::json::parse(text_of(folder_ / "tasks" / (stem + ".json")));
    EXPECT_EQ(json["state"], state);
    EXPECT_EQ(json["slurm_job"], "101");
    EXPECT_TRUE(names_all(json["reason"].get<std::string>(), reason)) << json["reason"];
  }

  void expect_done(const Command& command) const
  {
    const Ended ended = test::run(command);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
  }

  fs::path model_of(const std::string& name) const { return folder_ / name / (name + ".h5"); }
  fs::path model() const { return folder_ / job_.stem() += ".h5"; }
  std::string name_of_model(const std::string& ending) const { return model().filename().string() + ending; }

  std::string wanted_;  ///< SHA-256 of the model of a run without shards
};

// Held while it loads, so that no step is solved when the signal arrives.
const Fault while_loading{"hold", "write", "1", ".start.h5"};

TEST_P(TaskInterruption, ATimeLimitWithoutAStepIsAFailure)
{
  submit("2", "1");
  Fault fault = while_loading;
  fault.file = name_of_model(fault.file);
  const Ended ended = signalled_at(task("spine"), fault);
  EXPECT_THAT(ended, refuses({"--time", "", {"1", "no step"}, "longer"}));
  expect_state("spine", "failed", {"--time", "1", "no step"});
  // Restarted by hand: a task's only case is not skipped.
  expect_done(restarted(task("spine"), 1));
}

TEST_P(TaskInterruption, AFailedCaseIsSkippedByTheNextStartOfItsTask)
{
  submit_two("1");
  Command both = task("run");
  both.arguments.insert(both.arguments.end(), {"--first", "1", "--count", "2"});
  Fault fault = while_loading;
  fault.file = "a/a.h5.start.h5";
  // The first case has failed and the second has not started: the task requests a restart by Slurm.
  EXPECT_EQ(signalled_at(both, fault).exit_code, 4);
  expect_state_of("a.run", "failed", {"--time", "no step"});
  const Ended again = test::run(restarted(both, 1));
  EXPECT_EQ(again.exit_code, 2) << again.err;
  EXPECT_THAT(again.err, reports("", {"a.run", "failed"}));
  expect_state_of("a.run", "failed", {"--time", "1", "no step"});
  expect_state_of("b.run", "done", "");
  EXPECT_FALSE(fs::exists(model_of("a")));
  EXPECT_EQ(sha256_of_file(model_of("b")), wanted_);
  // Another Slurm job, as submitted by vrda resume.
  both.environment["SLURM_JOB_ID"] = "102";
  expect_done(both);
  EXPECT_EQ(sha256_of_file(model_of("a")), wanted_);
}

// With a limit of ten minutes the task was preempted early, which is not a failure.
TEST_P(TaskInterruption, AnEarlySignalIsNotAFailure)
{
  submit("2", "10");
  Fault fault = while_loading;
  fault.file = name_of_model(fault.file);
  EXPECT_EQ(signalled_at(task("spine"), fault).exit_code, 4);
  expect_state("spine", "interrupted", "");
}

TEST_P(TaskInterruption, SignalledAtItsLastStepARunMakesTheModelTheNextTime)
{
  submit("1", "1");
  const std::string journal = name_of_model(".journal");
  const int n =
      n_calls_of(task("run"), in_folder({"count", "write", "1", journal}), scratch_.path() / "counts");
  fs::remove(model());
  const Ended ended = signalled_at(task("run"), {"hold", "write", std::to_string(n), journal});
  EXPECT_EQ(ended.exit_code, 4) << ended.err;
  EXPECT_THAT(ended.err, reports("interrupted", (folder_ / journal).string()));
  EXPECT_FALSE(fs::exists(model()));
  expect_state("run", "interrupted", "");
  expect_done(task("run"));
  expect_state("run", "done", "");
  EXPECT_EQ(sha256_of_file(model()), wanted_);
}

TEST_P(TaskInterruption, AWholeLimitWithoutAModelIsAFailure)
{
  submit("1", "1");
  const std::string journal = name_of_model(".journal");
  const int n =
      n_calls_of(task("run"), in_folder({"count", "write", "1", journal}), scratch_.path() / "counts");
  fs::remove(model());
  EXPECT_EQ(signalled_at(task("run"), {"hold", "write", std::to_string(n), journal}).exit_code, 4);
  const Ended again = signalled_at(task("run"), {"hold", "open", "1", journal});
  EXPECT_EQ(again.exit_code, 2) << again.err;
  expect_state("run", "failed", {"--time", "1", "model"});
  expect_done(task("run"));
  EXPECT_EQ(sha256_of_file(model()), wanted_);
}

TEST_P(TaskInterruption, AMergeEndsImmediatelyAndKeepsTheJournals)
{
  struct Row {
    std::string time, state;
    Values reason;
    int exit_code;
  };
  for (const Row& row : {Row{"10", "interrupted", "", 4}, Row{"1", "failed", {"--time", "model"}, 2}}) {
    SCOPED_TRACE(row.time);
    submit("2", row.time);
    for (const Command& each : {task("spine"), task("shard", "1"), task("shard", "2")}) expect_done(each);
    const std::vector<std::string> before = names();
    const Ended ended = signalled_at(task("merge"), {"hold", "read", "1", name_of_model(".spine.journal")});
    EXPECT_EQ(ended.exit_code, row.exit_code) << ended.err;
    EXPECT_THAT(ended.err, reports("interrupted", "journals"));
    EXPECT_EQ(names(), before);
    expect_state("merge", row.state, row.reason);
    expect_done(task("merge"));
    expect_state("merge", "done", "");
    EXPECT_EQ(sha256_of_file(model()), wanted_);
  }
}

// A network file system may list a folder up to a minute late.
TEST_P(TaskInterruption, AMergeFindsJournalsThatAreNotListedYet)
{
  submit("2", "10");
  for (const Command& each : {task("spine"), task("shard", "1"), task("shard", "2")}) expect_done(each);
  const std::string second = name_of_model(".shard-2-of-2.journal"), bytes = read_bytes(folder_ / second);
  const Command merge = with_fault(task("merge"), in_folder({"eio", "list", "1+", name_of_model(".shard-")}));
  fs::remove(folder_ / second);
  const Ended refused = test::run(merge);
  EXPECT_THAT(refused, refuses({model().string(), "journals", "shard 2 of 2"}));
  scratch_.write("out/" + second, bytes);
  expect_done(merge);
  EXPECT_EQ(sha256_of_file(model()), wanted_);
  EXPECT_THAT(names(), testing::Not(testing::Contains(testing::EndsWith(".journal"))));
}

// Otherwise it would wait forever for a process that does not exist.
TEST_P(TaskInterruption, WithoutLocksATaskFails)
{
  submit("2", "10");
  const Ended ended = test::run(with_fault(task("shard", "1"), in_folder({"enolck", "lock", "1+"})));
  EXPECT_EQ(ended.exit_code, 2);
  expect_state("shard-1-of-2", "failed", {name_of_model(".spine.journal"), "No locks available"});
  expect_done(task("shard", "1"));
}

// The predecessor may run on a node that was declared dead: a whole case waits like a shard.
TEST_P(TaskInterruption, AWholeCaseWaitsForTheWriterOfItsJournal)
{
  submit("1", "10");
  const std::string journal = name_of_model(".journal");
  EXPECT_EQ(signalled_at(task("run"), {"hold", "write", "3", journal}).exit_code, 4);
  const int lock = open((folder_ / journal).c_str(), O_RDWR | O_CLOEXEC);
  EXPECT_EQ(flock(lock, LOCK_EX), 0);
  Process waiting(task("run"));
  while (waiting.is_running() && waiting.said().find("waiting for the run") == std::string::npos)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_TRUE(waiting.is_running());
  close(lock);
  const Ended ended = waiting.wait();
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  expect_state("run", "done", "");
  EXPECT_EQ(sha256_of_file(model()), wanted_);
}

// The predecessor's model is used, although its journal is removed.
TEST_P(TaskInterruption, AWholeCaseFinishedByItsPredecessorIsNotSolvedAgain)
{
  submit("1", "10");
  const std::string journal = name_of_model(".journal");
  const fs::path kept = scratch_.path() / "kept.h5";
  expect_done(task("run"));
  fs::rename(model(), kept);
  const auto predecessor_ends = [&] {
    fs::copy_file(kept, model());
    fs::remove(folder_ / journal);
    fs::remove(model().string() + ".run.json");
  };
  const auto expect_untouched = [&](const Ended& ended) {
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_THAT(ended.err, reports(model().string(), "--fresh"));
    expect_state("run", "done", "");
    EXPECT_FALSE(fs::exists(folder_ / journal));
    EXPECT_EQ(sha256_of_file(model()), wanted_);
    fs::remove(model());
  };
  EXPECT_EQ(signalled_at(task("run"), {"hold", "write", "3", journal}).exit_code, 4);
  const int lock = open((folder_ / journal).c_str(), O_RDWR | O_CLOEXEC);
  EXPECT_EQ(flock(lock, LOCK_EX), 0);
  Process waiting(task("run"));
  while (waiting.is_running() && waiting.said().find("waiting for the run") == std::string::npos)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  EXPECT_TRUE(waiting.is_running());
  predecessor_ends();
  close(lock);
  expect_untouched(waiting.wait());

  // Between the check for the journal and its opening.
  EXPECT_EQ(signalled_at(task("run"), {"hold", "write", "3", journal}).exit_code, 4);
  expect_untouched(
      held_at(task("run"), {"hold", "open", "1", journal}, [&](const Process&) { predecessor_ends(); }));
}

INSTANTIATE_TEST_SUITE_P(All, TaskInterruption, testing::Values(equilibrium()), name_of);

}  // namespace vrda::test::task_interruption_test
