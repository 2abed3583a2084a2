// A call of `vrda run` goes wrong: every one of them in turn, found by counting them first.
#include <gmock/gmock.h>

#include <algorithm>

#include "app/scenes.hpp"
#include "faults/faulty_run.hpp"
#include "journal/journal.hpp"

namespace vrda::test {
namespace {

namespace fs = std::filesystem;
using testing::EndsWith;
using testing::HasSubstr;
using testing::Not;

constexpr int killed = -1;

class RunFaults : public FaultyRun {};

TEST_P(RunFaults, AKillBeforeAnyCallLosesNothing)
{
  const int n = n_calls("any");
  EXPECT_GT(n, 30);
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    EXPECT_EQ(run_anew({"kill", "any", std::to_string(k)}).exit_code, killed);
    expect_no_part_of_a_result();
    expect_finishes();
  }
}

TEST_P(RunFaults, AWriteThatTearsLosesNothing)
{
  for (const std::string file : {"a.h5.start.h5", "a.h5.partial", "a.h5.run.json"}) {
    const int n = n_calls("write", file);
    for (int k = 1; k <= n; ++k) {
      SCOPED_TRACE(file + " " + std::to_string(k));
      EXPECT_EQ(run_anew({"torn", "write", std::to_string(k), file}).exit_code, killed);
      expect_no_part_of_a_result();
      expect_finishes();
    }
  }
}

TEST_P(RunFaults, ATornRecordIsDroppedAndAllBeforeItKept)
{
  const int n = n_calls("write", "a.h5.journal");
  EXPECT_GT(n, 9);
  for (int k = 2; k <= n; ++k) {  // the first is the header
    SCOPED_TRACE(k);
    EXPECT_EQ(run_anew({"torn", "write", std::to_string(k), "a.h5.journal"}).exit_code, killed);
    const JournalContent content = read_journal(journal());
    EXPECT_EQ(content.records.size(), static_cast<std::size_t>(k - 2));
    EXPECT_GT(content.dropped_bytes, 0u);
    EXPECT_THAT(expect_finishes(), HasSubstr("dropped " + std::to_string(content.dropped_bytes) + " bytes"));
    EXPECT_EQ(n_steps_recalled(), k - 2);
  }
}

TEST_P(RunFaults, KilledAtEveryRecordOfEveryResumptionItStillEnds)
{
  // Each time one step further: the second write of a resumed run is its second record.
  fs::remove_all(folder_);
  fs::create_directory(folder_);
  int n_killed = 0;
  while (run({"torn", "write", "2", "a.h5.journal"}).exit_code == killed && n_killed < 100) ++n_killed;
  EXPECT_GT(n_killed, 9);
  expect_finished();
}

TEST_P(RunFaults, ShortWritesChangeNothing)
{
  const int n = n_calls("write");
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    EXPECT_EQ(run_anew({"short", "write", std::to_string(k)}).exit_code, 0);
    expect_finished();
  }
  EXPECT_EQ(run_anew({"short", "write", "1+"}).exit_code, 0);
  expect_finished();
}

struct Row {
  std::string file;
  std::string call;
};

TEST_P(RunFaults, AnErrorIsOneLineAndTheSameCommandGoesOn)
{
  // Every file and call that a result depends on; "" is any file, its folder too.
  for (const auto& [file, call] :
       {Row{"a.h5.journal", "write"}, Row{"a.h5.start.h5.partial", "write"}, Row{"a.h5.partial", "write"},
        Row{"", "fsync"}, Row{"", "rename"}, Row{"a.h5.journal.partial", "open"},
        Row{"a.h5.start.h5.partial", "open"}, Row{"a.h5.partial", "open"}, Row{"a.h5.start.h5", "close"},
        Row{"a.h5.partial", "close"}}) {
    const int n = n_calls(call, file);
    for (int k = 1; k <= n; ++k) {
      SCOPED_TRACE(file + " " + call + " " + std::to_string(k));
      expect_refused(run_anew({"eio", call, std::to_string(k), file}));
      EXPECT_THAT(names(), testing::Each(Not(EndsWith(".partial"))));
      expect_finishes();
    }
  }
}

TEST_P(RunFaults, ADiskThatIsFullFromAnyWriteOnLosesNothing)
{
  const int n = n_calls("write") - 1;  // all but the times, which a run does without
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    const Ended ended = run_anew({"full", "write", std::to_string(k)});
    expect_refused(ended);
    EXPECT_THAT(ended.err, HasSubstr("No space left on device"));
    EXPECT_THAT(names(), testing::Each(Not(EndsWith(".partial"))));
    expect_finishes();
  }
}

TEST_P(RunFaults, ADiskThatIsGoneLosesNothing)
{
  // Nothing can be tidied up then either: torn frames and partial files stay until the next run.
  const int n = n_calls("write") - 1;
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    expect_refused(run_anew({"eio", "any", std::to_string(k) + "+"}));
    expect_finishes();
  }
}

TEST_P(RunFaults, TimesThatCannotBeWrittenAreAWarning)
{
  for (const std::string call : {"write", "open", "close"}) {
    SCOPED_TRACE(call);
    const Ended ended = run_anew({"eio", call, "1", "a.h5.run.json"});
    EXPECT_EQ(ended.exit_code, 0);
    EXPECT_EQ(n_lines(ended.err), 1) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("a.h5.run.json: found a file that cannot be written"));
    EXPECT_THAT(names(), Not(testing::Contains("a.h5.run.json")));
    expect_finishes();
  }
}

TEST_P(RunFaults, WhatCannotBeRemovedIsSaidAndGoesWithTheNextRun)
{
  const Ended left = run_anew({"eio", "unlink", "1", "a.h5.journal"});
  EXPECT_EQ(left.exit_code, 0);
  EXPECT_EQ(n_lines(left.err), 1) << left.err;
  EXPECT_THAT(left.err, HasSubstr(journal() + ": found a file that cannot be removed (Input/output error)"));
  const int n = n_calls("unlink");
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    EXPECT_EQ(run_anew({"eio", "unlink", std::to_string(k)}).exit_code, 0);
    expect_finishes();
  }
}

TEST_P(RunFaults, AJournalThatCannotBeReadIsNamedAndLeftAlone)
{
  run_anew({"kill", "write", "6", "a.h5.journal"});
  const std::string before = read_bytes(journal());
  const Ended ended = run({"eio", "read", "1", "a.h5.journal"});
  expect_refused(ended);
  EXPECT_THAT(ended.err, HasSubstr(journal() + ": found a read error (Input/output error)"));
  EXPECT_EQ(read_bytes(journal()), before);
  EXPECT_EQ(run({"short", "read", "1+", "a.h5.journal"}).exit_code, 0);
  EXPECT_EQ(n_steps_recalled(), 4);
  expect_finished();
}

TEST_P(RunFaults, AJournalThatCannotBeOpenedOrCutIsNamed)
{
  for (const std::string call : {"open", "truncate"}) {
    SCOPED_TRACE(call);
    run_anew({"torn", "write", "6", "a.h5.journal"});
    const Ended ended = run({"eio", call, "1", "a.h5.journal"});
    EXPECT_EQ(ended.exit_code, 2);
    EXPECT_THAT(ended.err, HasSubstr("vrda: " + journal() + ": found a journal that cannot be"));
    expect_finishes();
    EXPECT_EQ(n_steps_recalled(), 4);
  }
}

INSTANTIATE_TEST_SUITE_P(All, RunFaults, testing::ValuesIn(all_settings()),
                         [](const auto& setting) { return setting.param.name; });

}  // namespace
}  // namespace vrda::test
