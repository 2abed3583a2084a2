// Injects an error or a short write into every call of `vrda run` in turn, after counting the calls.
#include <gmock/gmock.h>

#include <fstream>

#include "app/scenes.hpp"
#include "faults/faulty_run.hpp"
#include "support/messages.hpp"

namespace vrda::test::run_errors_test {

using testing::EndsWith;
using testing::Not;

class RunErrors : public FaultyRun {};
class RunErrorsOneWay : public FaultyRun {};

TEST_P(RunErrorsOneWay, ShortWritesChangeNothing)
{
  const int n = n_calls("write");
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    EXPECT_EQ(run_from_empty({"short", "write", std::to_string(k)}).exit_code, 0);
    expect_finished();
  }
  EXPECT_EQ(run_from_empty({"short", "write", "1+"}).exit_code, 0);
  expect_finished();
}

struct Row {
  std::string file;
  std::string call;
};

TEST_P(RunErrors, AnErrorIsOneLineAndTheSameCommandResumes)
{
  // Every file and call on which a result depends.
  for (const auto& [file, call] :
       {Row{"a.h5.journal", "write"}, Row{"a.h5.start.h5.partial", "write"}, Row{"a.h5.partial", "write"},
        Row{"a.h5.journal", "fsync"}, Row{"a.h5.start.h5", "fsync"}, Row{"a.h5.partial", "fsync"},
        Row{"a.h5.journal", "rename"}, Row{"a.h5.start.h5", "rename"}, Row{"a.h5.partial", "rename"},
        Row{"a.h5.journal.partial", "open"}, Row{"a.h5.start.h5.partial", "open"},
        Row{"a.h5.partial", "open"}, Row{"a.h5.start.h5.partial", "close"}, Row{"a.h5.partial", "close"}}) {
    const int n = n_calls(call, file);
    for (int k = 1; k <= n; ++k) {
      SCOPED_TRACE(file + " " + call + " " + std::to_string(k));
      expect_refused(run_from_empty({"eio", call, std::to_string(k), file}));
      EXPECT_THAT(names(), testing::Each(Not(EndsWith(".partial"))));
      expect_finishes();
    }
  }
}

TEST_P(RunErrorsOneWay, AnErrorOfSynchronisingDuringTheRunIsReported)
{
  // With readings further apart than the journal's interval it synchronises at every record. Each is later,
  // since a sanitizer reads the clock too.
  Command command = this->command();
  command.environment["VRDA_FAULT_CLOCK"] = "10";
  clear();
  const int n =
      n_calls_of(command, in_folder({"count", "fsync", "1", "a.h5.journal"}), scratch_.path() / "counts");
  EXPECT_GT(n, 2);  // two are for the header and at the end
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    clear();
    const Ended ended =
        test::run(with_fault(command, in_folder({"eio", "fsync", std::to_string(k), "a.h5.journal"})));
    expect_refused(ended);
    EXPECT_THAT(messages_of(ended), reports(journal()));
    expect_finishes();
  }
}

TEST_P(RunErrorsOneWay, ADiskThatIsFullFromAnyWriteOnLosesNothing)
{
  const int n = n_calls("write") - 1;  // all but the run record, which is optional
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    const Ended ended = run_from_empty({"full", "write", std::to_string(k)});
    expect_refused(ended);
    EXPECT_THAT(messages_of(ended), reports("", "No space left on device"));
    EXPECT_THAT(names(), testing::Each(Not(EndsWith(".partial"))));
    expect_finishes();
  }
}

TEST_P(RunErrorsOneWay, ALostDiskLosesNothing)
{
  // Cleanup fails too: torn frames and partial files remain until the next run.
  const int n = n_calls("write") - 1;
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    expect_refused(run_from_empty({"eio", "any", std::to_string(k) + "+"}));
    expect_finishes();
  }
}

TEST_P(RunErrorsOneWay, TimesThatCannotBeWrittenAreAWarning)
{
  for (const std::string call : {"write", "open", "close"}) {
    SCOPED_TRACE(call);
    const Ended ended = run_from_empty({"eio", call, "1", "a.h5.run.json"});
    EXPECT_EQ(ended.exit_code, 0);
    EXPECT_EQ(n_lines(messages_of(ended)), 1) << ended.err;
    EXPECT_THAT(ended.err, warns("a.h5.run.json", "found"));
    EXPECT_THAT(names(), Not(testing::Contains("a.h5.run.json")));
    expect_finishes();
  }
}

TEST_P(RunErrorsOneWay, AFileThatCannotBeRemovedIsReportedAndRemovedByTheNextRun)
{
  const Ended left = run_from_empty({"eio", "unlink", "1", "a.h5.journal"});
  EXPECT_EQ(left.exit_code, 0);
  EXPECT_EQ(n_lines(messages_of(left)), 1) << left.err;
  EXPECT_THAT(left.err, warns(journal(), "Input/output error"));
  const int n = n_calls("unlink");
  for (int k = 1; k <= n; ++k) {
    SCOPED_TRACE(k);
    EXPECT_EQ(run_from_empty({"eio", "unlink", std::to_string(k)}).exit_code, 0);
    expect_finishes();
  }
}

TEST_P(RunErrorsOneWay, TheTemporaryOfAKilledRunIsRemovedDespiteAnError)
{
  for (const std::string what : {"eio", "enospc"}) {
    SCOPED_TRACE(what);
    clear();
    std::ofstream(folder_ / "a.h5.start.h5.partial") << "half";
    EXPECT_EQ(run({what, "unlink", "1", "a.h5.start.h5.partial"}).exit_code, 0);
    expect_finished();
  }
}

TEST_P(RunErrorsOneWay, AnUnreadableJournalIsNamedAndUnchanged)
{
  run_from_empty({"kill", "write", "6", "a.h5.journal"});
  const std::string before = read_bytes(journal());
  const Ended ended = run({"eio", "read", "1", "a.h5.journal"});
  expect_refused(ended);
  EXPECT_THAT(ended, refuses({journal(), "", "Input/output error"}));
  EXPECT_EQ(read_bytes(journal()), before);
  EXPECT_EQ(run({"short", "read", "1+", "a.h5.journal"}).exit_code, 0);
  EXPECT_EQ(n_steps_recalled(), 4);
  expect_finished();
}

TEST_P(RunErrorsOneWay, AJournalThatCannotBeOpenedOrCutIsNamed)
{
  for (const std::string call : {"open", "truncate"}) {
    SCOPED_TRACE(call);
    run_from_empty({"torn", "write", "6", "a.h5.journal"});
    const Ended ended = run({"eio", call, "1", "a.h5.journal"});
    EXPECT_THAT(ended, refuses({.file = journal()}));
    expect_finishes();
    EXPECT_EQ(n_steps_recalled(), 4);
  }
}

INSTANTIATE_TEST_SUITE_P(All, RunErrors, testing::ValuesIn(every_method()), name_of);
INSTANTIATE_TEST_SUITE_P(All, RunErrorsOneWay, testing::ValuesIn(one_method()), name_of);

}  // namespace vrda::test::run_errors_test
