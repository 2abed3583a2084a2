// The environment of a run: a read-only folder, a clock that jumps, another run.
#include <gmock/gmock.h>

#include <regex>

#include "app/scenes.hpp"
#include "faults/faulty_run.hpp"
#include "support/messages.hpp"
#include "support/small_disk.hpp"

namespace vrda::test::ground_test {

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

// The failed lock is not held by another run, so there is nothing to wait for.
TEST_P(Ground, AFileSystemWithoutLocksIsReportedInOneLine)
{
  const Fault without{"enolck", "lock", "1+"};
  const RefusalMatcher names_remedy = refuses({journal(), "", "No locks available", {"flock", "-o flock"}});
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
  expect_finishes();
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

}  // namespace vrda::test::ground_test
