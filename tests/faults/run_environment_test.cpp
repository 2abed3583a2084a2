// The environment of a run: a read-only folder, a clock that jumps, another run.
// Commands that read a motion model and extend it, write another file or print: after any fault the file is
// the old or the new one.
#include <gmock/gmock.h>

#include <iostream>
#include <regex>

#include "app/scenes.hpp"
#include "faults/faulty_run.hpp"
#include "support/messages.hpp"
#include "support/small_disk.hpp"

namespace vrda::test::run_environment_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

class Ground : public FaultyRun {};

// Before a run, in its middle, and with its result.
TEST_P(Ground, AReadOnlyFolderIsReportedInOneLineAndUnchanged)
{
  if (!mount_refusal().empty()) GTEST_SKIP() << "a disk of its own, missing: " << mount_refusal();
  SmallDisk disk(folder_, 4 << 20);
  const auto expect_read_only = [&](const std::string& file, const std::string& found) {
    const Files before = files();
    disk.forbid_writing();
    const Ended ended = run();
    disk.permit_writing();
    expect_refused(ended);
    EXPECT_THAT(ended, refuses({.file = file, .field = printed_facts(ended.err).field, .found = found}));
    EXPECT_EQ(files(), before);
  };
  expect_read_only("", "Read-only file system");
  run({"kill", "write", "5", "a.h5.journal"});
  expect_read_only(journal(), "Read-only file system");
  expect_finishes();
  EXPECT_EQ(n_steps_recalled(), 3);
  expect_read_only(folder_.string() + "/a.h5", "permission");
}

// The failed lock is not held by another run, so there is nothing to wait for. With --no-lock the run goes
// on, and its result keeps the warning.
TEST_P(Ground, AFileSystemWithoutLocksIsReportedInOneLine)
{
  struct Row {
    std::string what, reason;
  };
  for (const Row& row : {Row{"enolck", "No locks available"}, Row{"enosys", "Function not implemented"}}) {
    SCOPED_TRACE(row.what);
    const Fault without{row.what, "lock", "1+"};
    const RefusalMatcher names_remedy =
        refuses({journal(), "", row.reason, {"flock", "-o flock", "--no-lock"}});
    const Ended refused = run_from_empty(without);
    expect_refused(refused);
    EXPECT_THAT(refused, names_remedy);
    EXPECT_THAT(names(), IsEmpty());
    run({"kill", "write", "5", "a.h5.journal"});
    const std::string before = read_bytes(journal());
    const Ended again = run(without);
    expect_refused(again);
    EXPECT_THAT(again, names_remedy);
    EXPECT_EQ(read_bytes(journal()), before);
    Command unlocked = command();
    unlocked.arguments.emplace_back("--no-lock");
    const Ended went_on = test::run(with_fault(unlocked, in_folder(without)));
    EXPECT_EQ(went_on.exit_code, 0);
    EXPECT_THAT(messages_of(went_on), warns("--no-lock", row.reason));
    EXPECT_EQ(n_steps_recalled(), 3);
    const std::string file = (folder_ / "a.h5").string(), bytes = read_bytes(file);
    EXPECT_THAT(test::run(vrda({"info", file})).out, HasSubstr("warning: --no-lock: found"));
    EXPECT_EQ(run().exit_code, 0);  // the same job, finished
    EXPECT_EQ(read_bytes(file), bytes);
    clear();
    EXPECT_EQ(test::run(unlocked).exit_code, 0);  // with locks the option changes nothing
    expect_finished();
  }
}

TEST_P(Ground, AClockThatJumpsChangesNoByteAndProgressStaysValid)
{
  // Every reading jumps by hours forward or back, from the start or from the middle of the run.
  for (const std::string at : {"1", "40"}) {
    for (const std::string style : {"plain", "bar"}) {
      clear();
      Command command = this->command();
      std::erase(command.arguments, "--quiet");
      command.arguments.insert(command.arguments.end(), {"--progress", style});
      const Ended ended = test::run(with_fault(command, {"clock", "any", at}));
      EXPECT_EQ(ended.exit_code, 0) << ended.err;
      expect_finished();
      const std::regex progress(R"((\d+)/6 attitudes, ([^\n\r]*?) *(?=[\n\r]|$))");
      const std::regex sane(R"(starting|[0-9.]+(e[-+]\d+)?/s, \d+:[0-5]\d left)");
      int n_said = 0;
      for (std::sregex_iterator it(ended.err.begin(), ended.err.end(), progress), end; it != end;
           ++it, ++n_said)
        EXPECT_TRUE(std::regex_match((*it)[2].str(), sane)) << it->str();
      EXPECT_GT(n_said, 0) << ended.err;
    }
  }
}

TEST_P(Ground, ASecondRunWhileTheFirstBeginsIsRefusedAndHarmsNothing)
{
  // The first run is held before each call that creates and first writes its journal, except the first, open,
  // before which there is nothing to damage.
  Command fresh = command();
  fresh.arguments.emplace_back("--fresh");
  for (const Command& run : {command(), fresh}) {
    for (int k = 2; k <= 8; ++k) {
      SCOPED_TRACE(run.arguments.back() + " " + std::to_string(k));
      clear();
      HeldProcess first(scratch_, run, {"hold", "any", std::to_string(k), journal()});
      const Ended second = test::run(run);
      EXPECT_EQ(first.release().exit_code, 0);
      expect_refused(second);
      EXPECT_THAT(printed_facts(second.err).wanted, HasSubstr("no other run"));
      expect_finished();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Ground, testing::ValuesIn(one_method()), name_of);

using testing::AnyOf;

/// A command and the file that it writes; empty if it prints.
struct Job {
  std::string name;
  std::vector<std::string> words;
  std::string output;
};

class ModelFaults : public FaultyRun {
 protected:
  ModelFaults() { begin_ = {{"a.h5", whole_run().after.at("a.h5")}, {"b.csv", "flexion,varus\n1,2\n"}}; }

  std::string written(const Job& job) const
  {
    return job.output.empty() ? "" : read_bytes(folder_ / job.output);
  }

  void expect_sound_end(const Fault& fault, const Ended& ended, const Ended& whole) const
  {
    // Only a kill ends it by a signal; errors of closing folders and of removing missing files are ignored.
    if (fault.what == "kill") {
      EXPECT_THAT(ended.exit_code, AnyOf(-1, 0, 2));
    } else {
      EXPECT_THAT(ended.exit_code, AnyOf(0, 2));
    }
    EXPECT_LE(n_lines(ended.err), n_lines(whole.err) + (ended.exit_code == 2 ? 1 : 0)) << ended.err;
    if (ended.exit_code == 2 && fault.what != "kill") {
      EXPECT_THAT(printed_facts(ended.err).file, testing::StartsWith(folder_.string()));
      EXPECT_THAT(
          ended,
          AnyOf(refuses({.field = printed_facts(ended.err).field, .found = "Input/output error"}),
                refuses({.field = printed_facts(ended.err).field, .found = "No space left on device"})));
    }
    if (ended.exit_code == 0) {
      EXPECT_EQ(ended.out, whole.out);
    }
  }

  Files begin_;
};

TEST_P(ModelFaults, TheFileIsTheOldOrTheNewOne)
{
  const std::string file = (folder_ / "a.h5").string();
  int n_disturbed = 0;
  for (const Job& job :
       {Job{"smooth", {"smooth", file, "--degree", "1", "--robust", "--quiet"}, "a.h5"},
        Job{"audit", {"audit", file, "--set", "degree_1", "--quiet"}, "a.h5"},
        Job{"reduce", {"reduce", file, "--set", "degree_1", "--quiet"}, "a.h5"},
        Job{"export",
            {"export", file, "--to", "csv", "-o", (folder_ / "b.csv").string(), "--quiet"},
            "b.csv"},
        Job{"compare", {"compare", file, "--degrees", "1", "--refine", "0", "--quiet"}, ""}}) {
    const Command command = vrda(job.words);
    put(begin_);
    const std::string old_bytes = written(job);
    const Ended whole = test::run(command);
    ASSERT_EQ(whole.exit_code, 0) << whole.err;
    const std::string new_bytes = written(job);
    const std::vector<std::string> whole_names = names();
    int n_refused = 0;
    for (const std::string call : {"any", "read"}) {
      put(begin_);
      // In a command that only prints, a separate process reads the model, with its own count of calls.
      const int n = job.output.empty()
                        ? 2
                        : n_calls_of(command, in_folder({"count", call}), scratch_.path() / "counts");
      int row = 0;
      for (const std::string what : {"kill", "eio", "enospc", "short"}) {
        ++row;
        for (int k = 1; k <= n; ++k) {
          if (!runs_full_set() && (k + row) % 4 != 0) continue;
          SCOPED_TRACE(job.name + " " + what + " " + call + " " + std::to_string(k));
          ++n_disturbed;
          put(begin_);
          const Fault fault{what, call, std::to_string(k)};
          const Ended ended = test::run(with_fault(command, in_folder(fault)));
          expect_sound_end(fault, ended, whole);
          n_refused += ended.exit_code == 2 ? 1 : 0;
          const std::string there = written(job);
          EXPECT_TRUE(there == new_bytes || (there == old_bytes && ended.exit_code != 0));
          EXPECT_EQ(test::run(command).exit_code, 0);
          EXPECT_TRUE(written(job) == new_bytes);
          EXPECT_EQ(names(), whole_names);
        }
      }
    }
    EXPECT_GT(n_refused, 0) << job.name;
  }
  std::cout << n_disturbed << " calls went wrong\n";
}

INSTANTIATE_TEST_SUITE_P(All, ModelFaults, testing::Values(equilibrium()), name_of);

}  // namespace vrda::test::run_environment_test
