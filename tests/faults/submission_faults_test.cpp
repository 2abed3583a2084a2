// A submission of local processes, one of which is killed or fails: resumed, it gives the same bytes.
// Slurm tasks that are signalled to end at a certain system call: their state, and how they resume.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include <csignal>
#include <fstream>
#include <optional>

#include "app/scenes.hpp"
#include "core/files.hpp"
#include "faults/faulty_run.hpp"
#include "support/messages.hpp"

namespace vrda::test::submission_faults_test {

namespace fs = std::filesystem;

class SubmissionFaults : public FaultyRun {
 protected:
  Command submit() const
  {
    std::vector<std::string> words = command().arguments;  // run JOB -o ... --quiet --threads 1 --set ...
    words[0] = "submit";
    words[3] = folder_;
    words.erase(words.begin() + 5, words.begin() + 7);
    words.insert(words.end(), {"--shards", "2", "--local", "--workers", "1"});
    return vrda(words);
  }

  /// The remedy after a failure: the same command until there is a submission, then resume.
  Ended go_on() const
  {
    const bool is_submitted = fs::exists(folder_ / "submission.json");
    return test::run(is_submitted ? vrda({"resume", folder_, "--local", "--workers", "1", "--quiet"})
                                  : submit());
  }

  fs::path model() const { return folder_ / job_.stem() += ".h5"; }

  /// Only one process gets the fault, at its k-th such call.
  Ended disturbed(Command command, const Fault& fault) const
  {
    fs::remove(once_);
    command = with_fault(command, in_folder(fault));
    command.environment["VRDA_FAULT_ONCE"] = once_;
    return test::run(command);
  }

  /// Each of the faults at calls of any process of the command, which starts in a folder made by `put`; the
  /// remedy then makes the model.
  template <typename Put>
  void expect_resumable(const Command& command, const Put& put, const std::vector<std::string>& whats) const
  {
    put();
    // Of all processes together; a single one makes fewer.
    const int n = n_calls_of(command, in_folder({"count"}), scratch_.path() / "counts");
    expect_made();
    EXPECT_GT(n, 50);
    int n_disturbed = 0, n_refused = 0;
    bool is_beyond = false;  // no process makes so many calls
    for (int k = 1; k <= n && !is_beyond; k += runs_full_set() ? 1 : 2) {
      for (std::size_t i = 0; i < whats.size(); ++i) {
        // The faults by turns, but in the full set each.
        if (!runs_full_set() && static_cast<std::size_t>(k / 2) % whats.size() != i) continue;
        const std::string& what = whats[i];
        SCOPED_TRACE(what + " " + std::to_string(k));
        put();
        const Ended ended = disturbed(command, {what, "any", std::to_string(k)});
        is_beyond = !fs::exists(once_);
        if (is_beyond) break;
        ++n_disturbed;
        EXPECT_NE(ended.exit_code, 5) << ended.err;
        EXPECT_TRUE(what != "short" || ended.exit_code == 0) << ended.err;
        n_refused += ended.exit_code == 2 ? 1 : 0;
        expect_goes_on();
      }
    }
    EXPECT_GT(n_disturbed, 12);
    EXPECT_GT(n_refused, 0);
  }

  void expect_goes_on() const
  {
    const Ended after = go_on();
    EXPECT_EQ(after.exit_code, 0) << after.err;
    expect_made();
  }

  void expect_made() const
  {
    EXPECT_TRUE(read_bytes(model()) == whole_run().after.at("a.h5"));
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      const std::string name = entry.path().filename();
      EXPECT_FALSE(name.ends_with(".partial") || name.ends_with(".journal") || name.ends_with(".start.h5"))
          << name;
    }
  }

  const fs::path once_ = scratch_.path() / "once";
};

TEST_P(SubmissionFaults, IsResumedAfterAnyProcessIsKilledOrFails)
{
  expect_resumable(submit(), [&] { fs::remove_all(folder_); }, {"kill", "torn", "eio"});
}

// The submission stopped at its half; a fault of any process of resume itself keeps the next one able to
// finish.
TEST_P(SubmissionFaults, IsResumedAfterAResumeIsKilledOrFails)
{
  fs::remove_all(folder_);
  const std::string spine = model().filename().string() + ".spine.journal";
  ASSERT_NE(disturbed(submit(), {"torn", "write", "3", spine}).exit_code, 0);
  const fs::path kept = scratch_.path() / "interrupted";
  fs::copy(folder_, kept, fs::copy_options::recursive);
  const auto put = [&] {
    fs::remove_all(folder_);
    fs::copy(kept, folder_, fs::copy_options::recursive);
  };
  expect_resumable(vrda({"resume", folder_, "--local", "--workers", "1", "--quiet"}), put,
                   {"kill", "torn", "eio", "enospc", "short"});
}

// All tasks but the merge are done; then a bit of a journal is flipped, or its end cut off.
TEST_P(SubmissionFaults, ADamagedJournalIsRepairedByResume)
{
  fs::remove_all(folder_);
  ASSERT_EQ(test::run(submit()).exit_code, 0);
  fs::remove(model());
  const auto task = [&](const std::vector<std::string>& words) {
    std::vector<std::string> all{"task", folder_, "--kind"};
    all.insert(all.end(), words.begin(), words.end());
    return test::run(vrda(all));
  };
  ASSERT_EQ(task({"spine"}).exit_code, 0);
  ASSERT_EQ(task({"shard", "--shard", "1"}).exit_code, 0);
  ASSERT_EQ(task({"shard", "--shard", "2"}).exit_code, 0);
  const fs::path kept = scratch_.path() / "kept";
  fs::copy(folder_, kept, fs::copy_options::recursive);
  for (const std::string which : {".spine.journal", ".shard-2-of-2.journal"}) {
    const std::string bytes = read_bytes(kept / (model().filename() += which));
    const std::size_t at = bytes.size() * 3 / 4;  // after the header, before the end of the last step
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ 16);
    for (const std::string& damaged : {flipped, bytes.substr(0, at)}) {
      SCOPED_TRACE(which + (damaged == flipped ? " flipped" : " cut"));
      fs::remove_all(folder_);
      fs::copy(kept, folder_, fs::copy_options::recursive);
      std::ofstream(model() += which, std::ios::binary) << damaged;
      const Ended merged = task({"merge"});
      EXPECT_EQ(merged.exit_code, 2) << merged.err;
      EXPECT_FALSE(fs::exists(model()));
      expect_goes_on();
    }
  }
}

TEST_P(SubmissionFaults, AFileSystemWithoutLocksIsReportedInOneLine)
{
  fs::remove_all(folder_);
  const Fault without = in_folder({"enolck", "lock", "1+"});
  const Ended ended = test::run(with_fault(submit(), without));
  EXPECT_EQ(n_lines(ended.err), 1) << ended.err;
  EXPECT_THAT(ended,
              refuses({"submission.lock", "", "No locks available", {"flock", "-o flock", "--no-lock"}}));
  expect_goes_on();
  fs::remove_all(folder_);
  Command unlocked = submit();
  unlocked.arguments.emplace_back("--no-lock");  // its tasks go on without locks, too
  EXPECT_EQ(test::run(with_fault(unlocked, without)).exit_code, 0);
  EXPECT_THAT(test::run(vrda({"info", model().string()})).out, testing::HasSubstr("warning: --no-lock"));
  EXPECT_EQ(test::run(with_fault(vrda({"resume", folder_, "--local"}), without)).exit_code, 2);
  EXPECT_EQ(test::run(with_fault(vrda({"resume", folder_, "--local", "--no-lock"}), without)).exit_code, 0);
}

// What a submission writes does not depend on the method; the search is faster here.
INSTANTIATE_TEST_SUITE_P(All, SubmissionFaults, testing::ValuesIn(untraced_or(search())), name_of);

// A submission of one case in a given number of shards, with no task done yet.
class TaskInterruption : public FaultyRun {
 protected:
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

  HeldProcess held(const Command& command, const std::string& call, const std::string& at,
                   const std::string& file) const
  {
    return {scratch_, command, in_folder({"hold", call, at, file})};
  }

  /// Signalled twice, as by Slurm and by the script, before the call.
  Ended signalled_at(const Command& command, const std::string& call, const std::string& at,
                     const std::string& file) const
  {
    HeldProcess process = held(command, call, at, file);
    process.send(SIGTERM);
    process.send(SIGTERM);
    return process.release();
  }
  /// While it loads, so that no step is solved.
  Ended signalled_while_loading(const Command& command, const std::string& model) const
  {
    return signalled_at(command, "write", "1", model + ".start.h5");
  }
  /// At the last step of the run of the only case.
  Ended signalled_at_last_step()
  {
    const int n = n_calls_of(task("run"), in_folder({"count", "write", "1", name_of_model(".journal")}),
                             scratch_.path() / "counts");
    fs::remove(model());
    return signalled_at(task("run"), "write", std::to_string(n), name_of_model(".journal"));
  }

  /// The lock of the run's journal, as of a predecessor that still writes it.
  OpenFile locked_journal() const
  {
    OpenFile journal(open((folder_ / name_of_model(".journal")).c_str(), O_RDWR | O_CLOEXEC));
    EXPECT_TRUE(try_lock_file(journal.get(), "journal"));
    return journal;
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
  void expect_made(const fs::path& file) const
  {
    EXPECT_TRUE(read_bytes(file) == whole_run().after.at("a.h5")) << file;
  }
};

TEST_P(TaskInterruption, ATimeLimitWithoutAStepIsAFailure)
{
  submit("2", "1");
  const Ended ended = signalled_while_loading(task("spine"), name_of_model(""));
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
  // The first case has failed and the second has not started: the task requests a restart by Slurm.
  EXPECT_EQ(signalled_while_loading(both, "a/a.h5").exit_code, 4);
  expect_state_of("a.run", "failed", {"--time", "no step"});
  const Ended again = test::run(restarted(both, 1));
  EXPECT_EQ(again.exit_code, 2) << again.err;
  EXPECT_THAT(again.err, reports("", {"a.run", "failed"}));
  expect_state_of("a.run", "failed", {"--time", "1", "no step"});
  expect_state_of("b.run", "done", "");
  EXPECT_FALSE(fs::exists(model_of("a")));
  expect_made(model_of("b"));
  // Another Slurm job, as submitted by vrda resume.
  both.environment["SLURM_JOB_ID"] = "102";
  expect_done(both);
  expect_made(model_of("a"));
}

// With a limit of ten minutes the task was preempted early, which is not a failure.
TEST_P(TaskInterruption, AnEarlySignalIsNotAFailure)
{
  submit("2", "10");
  EXPECT_EQ(signalled_while_loading(task("spine"), name_of_model("")).exit_code, 4);
  expect_state("spine", "interrupted", "");
}

// Signalled at its last step a run makes the model the next time; a whole limit without a model is a failure.
TEST_P(TaskInterruption, TheModelIsMadeByTheNextStart)
{
  submit("1", "1");
  for (const bool is_signalled_again : {false, true}) {
    const Ended ended = signalled_at_last_step();
    EXPECT_EQ(ended.exit_code, 4) << ended.err;
    EXPECT_THAT(ended.err, reports("interrupted", (folder_ / name_of_model(".journal")).string()));
    EXPECT_FALSE(fs::exists(model()));
    expect_state("run", "interrupted", "");
    if (is_signalled_again) {
      EXPECT_EQ(signalled_at(task("run"), "open", "1", name_of_model(".journal")).exit_code, 2);
      expect_state("run", "failed", {"--time", "1", "model"});
    }
    expect_done(task("run"));
    expect_state("run", "done", "");
    expect_made(model());
    fs::remove(model());
  }
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
    const Ended ended = signalled_at(task("merge"), "read", "1", name_of_model(".spine.journal"));
    EXPECT_EQ(ended.exit_code, row.exit_code) << ended.err;
    EXPECT_THAT(ended.err, reports("interrupted", "journals"));
    EXPECT_EQ(names(), before);
    expect_state("merge", row.state, row.reason);
    expect_done(task("merge"));
    expect_state("merge", "done", "");
    expect_made(model());
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
  EXPECT_THAT(test::run(merge), refuses({model().string(), "journals", "shard 2 of 2"}));
  scratch_.write("out/" + second, bytes);
  expect_done(merge);
  expect_made(model());
  EXPECT_THAT(names(), testing::Not(testing::Contains(testing::EndsWith(".journal"))));
}

// Otherwise it would wait forever for a process that does not exist.
TEST_P(TaskInterruption, WithoutLocksATaskFails)
{
  submit("2", "10");
  EXPECT_EQ(test::run(with_fault(task("shard", "1"), in_folder({"enolck", "lock", "1+"}))).exit_code, 2);
  expect_state("shard-1-of-2", "failed", {name_of_model(".spine.journal"), "No locks available"});
  expect_done(task("shard", "1"));
}

// The predecessor may run on a node that was declared dead: a whole case waits like a shard. The
// predecessor's model is used, although its journal is removed.
TEST_P(TaskInterruption, AWholeCaseWaitsForItsPredecessorAndUsesItsModel)
{
  submit("1", "10");
  const fs::path journal = folder_ / name_of_model(".journal"), kept = scratch_.path() / "kept.h5";
  const auto interrupt = [&] {
    EXPECT_EQ(signalled_at(task("run"), "write", "3", journal.filename()).exit_code, 4);
  };
  const auto waiting_end = [&](const auto& meanwhile) {
    std::optional<OpenFile> lock(locked_journal());
    Process waiting(task("run"));
    EXPECT_TRUE(waiting.runs_until_said("waiting for the run"));
    meanwhile();
    lock.reset();
    return waiting.wait();
  };
  const auto predecessor_ends = [&] {
    fs::copy_file(kept, model());
    fs::remove(journal);
    fs::remove(model().string() + ".run.json");
  };
  const auto expect_made_once = [&](const Ended& ended) {
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    expect_state("run", "done", "");
    EXPECT_FALSE(fs::exists(journal));
    expect_made(model());
  };
  interrupt();
  expect_made_once(waiting_end([] {}));
  fs::rename(model(), kept);
  interrupt();
  const Ended ended = waiting_end(predecessor_ends);
  expect_made_once(ended);
  EXPECT_THAT(ended.err, reports(model().string(), "--fresh"));
  fs::remove(model());

  // Between the check for the journal and its opening.
  interrupt();
  HeldProcess opening = held(task("run"), "open", "1", journal.filename());
  predecessor_ends();
  const Ended late = opening.release();
  expect_made_once(late);
  EXPECT_THAT(late.err, reports(model().string(), "--fresh"));
}

INSTANTIATE_TEST_SUITE_P(All, TaskInterruption, testing::Values(equilibrium()), name_of);

}  // namespace vrda::test::submission_faults_test
