// Kills `vrda run` before or within every call in turn, after counting the calls.
#include <gmock/gmock.h>

#include <algorithm>
#include <iterator>

#include "faults/faulty_run.hpp"
#include "store/journal.hpp"
#include "support/messages.hpp"

namespace vrda::test::run_kills_test {

constexpr int killed = -1;

class RunKills : public FaultyRun {};
class RunKillsOneWay : public FaultyRun {};

TEST_P(RunKills, AKillBeforeAnyCallLosesNothing)
{
  const int n = n_calls("any");
  EXPECT_GT(n, 30);
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    EXPECT_EQ(run_from_empty({"kill", "any", std::to_string(k)}).exit_code, killed);
    expect_no_incomplete_result();
    expect_finishes();
  }
}

TEST_P(RunKills, AWriteThatTearsLosesNothing)
{
  for (const std::string file : {"a.h5.start.h5", "a.h5.partial", "a.h5.run.json"}) {
    const int n = n_calls("write", file);
    for (int k = 1; k <= n; ++k) {
      SCOPED_TRACE(file + " " + std::to_string(k));
      EXPECT_EQ(run_from_empty({"torn", "write", std::to_string(k), file}).exit_code, killed);
      expect_no_incomplete_result();
      expect_finishes();
    }
  }
}

TEST_P(RunKills, ATornRecordIsDroppedAndAllBeforeItKept)
{
  const int n = n_calls("write", "a.h5.journal");
  EXPECT_GT(n, 6);
  for (int k = 2; k <= n; ++k) {  // the first is the header
    SCOPED_TRACE(k);
    EXPECT_EQ(run_from_empty({"torn", "write", std::to_string(k), "a.h5.journal"}).exit_code, killed);
    const store::JournalContent content = store::read_journal(journal());
    EXPECT_EQ(content.records.size(), static_cast<std::size_t>(k - 2));
    EXPECT_GT(content.dropped_bytes, 0u);
    EXPECT_THAT(expect_finishes(), warns(journal(), std::to_string(content.dropped_bytes) + " bytes"));
    EXPECT_EQ(n_steps_recalled(), k - 2);
  }
}

TEST_P(RunKills, FinishesAfterAKillAtEveryRecordOfEveryResumedRun)
{
  // Each run adds one step: the second write of a resumed run is its second record.
  clear();
  int n_killed = 0;
  while (run({"torn", "write", "2", "a.h5.journal"}).exit_code == killed && n_killed < 100) ++n_killed;
  EXPECT_GT(n_killed, 6);
  expect_finished();
}

TEST_P(RunKillsOneWay, TwoThreadsLoseNothing)
{
  Command threaded = command();
  *std::next(std::find(threaded.arguments.begin(), threaded.arguments.end(), "--threads")) = "2";
  const int n = n_calls("write", "a.h5.journal");
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    clear();
    const Fault torn = in_folder({"torn", "write", std::to_string(k), "a.h5.journal"});
    EXPECT_EQ(test::run(with_fault(threaded, torn)).exit_code, killed);
    EXPECT_EQ(test::run(threaded).exit_code, 0);
    expect_finished();
  }
}

INSTANTIATE_TEST_SUITE_P(All, RunKillsOneWay, testing::ValuesIn(one_method()), name_of);
INSTANTIATE_TEST_SUITE_P(All, RunKills, testing::ValuesIn(every_method()), name_of);

}  // namespace vrda::test::run_kills_test
