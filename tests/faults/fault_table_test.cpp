// Injects a kill, an error or a short write into every call of a run and of its parts in turn (spine, shards,
// merge), after counting the calls: the same command then finishes with the same files.
#include <gmock/gmock.h>

#include <csignal>

#include "app/scenes.hpp"
#include "core/framed_file.hpp"
#include "faults/faulty_run.hpp"
#include "store/journal.hpp"
#include "support/messages.hpp"

namespace vrda::test::fault_table_test {

using testing::EndsWith;
using testing::Not;
using enum Ending;

class Run : public FaultyRun {
 protected:
  void expect_survives(const std::vector<FaultRow>& rows) const
  {
    for (const FaultRow& row : rows) FaultyRun::expect_survives(whole_run(), row);
  }
  /// From the files that a run leaves which was killed within the write of its k-th record.
  Stage resumed_after(int k) const
  {
    run_from_empty({"torn", "write", std::to_string(k + 1), "a.h5.journal"});  // the first is the header
    return stage("resumed run", command(), files());
  }
};
class RunOneWay : public Run {};

TEST_P(Run, LosesNothingByAKill)
{
  expect_survives({{{"kill", "any", "each"}, killed},
                   {{"torn", "write", "each", "a.h5.start.h5"}, killed},
                   {{"torn", "write", "each", "a.h5.partial"}, killed},
                   {{"torn", "write", "each", "a.h5.run.json"}, killed}});
}

// Every file and call on which a result depends.
TEST_P(Run, RefusesAnError)
{
  for (const auto& [call, files] : std::map<std::string, std::vector<std::string>>{
           {"write", {"a.h5.journal", "a.h5.start.h5.partial", "a.h5.partial"}},
           {"fsync", {"a.h5.journal", "a.h5.start.h5", "a.h5.partial"}},
           {"rename", {"a.h5.journal", "a.h5.start.h5", "a.h5.partial"}},
           {"open", {"a.h5.journal.partial", "a.h5.start.h5.partial", "a.h5.partial"}},
           {"close", {"a.h5.start.h5.partial", "a.h5.partial"}}}) {
    for (const std::string& file : files) {
      expect_survives({{{"eio", call, "each", file}, refused}});
      run_from_empty({"eio", call, "1", file});
      EXPECT_THAT(names(), testing::Each(Not(EndsWith(".partial")))) << call << " of " << file;
    }
  }
}

TEST_P(Run, DropsATornRecordAndKeepsAllBeforeIt)
{
  const int n = n_calls(whole_run(), {"count", "write", "1", "a.h5.journal"});
  EXPECT_GT(n, 6);
  for (int k = 2; k <= n; ++k) {  // the first is the header
    SCOPED_TRACE(k);
    EXPECT_EQ(run_from_empty({"torn", "write", std::to_string(k), "a.h5.journal"}).exit_code, -1);
    const store::JournalContent content = store::read_journal(journal());
    EXPECT_EQ(content.records.size(), static_cast<std::size_t>(k - 2));
    EXPECT_THAT(expect_finishes(), warns(journal(), std::to_string(content.dropped_bytes) + " bytes"));
    EXPECT_EQ(n_steps_recalled(), k - 2);
  }
}

TEST_P(Run, FinishesThoughEachOfItsStartsIsKilled)
{
  // Each adds one step: the second write of a resumed run is its second record.
  clear();
  int n_killed = 0;
  while (run({"torn", "write", "2", "a.h5.journal"}).exit_code == -1 && n_killed < 100) ++n_killed;
  EXPECT_GT(n_killed, 6);
  expect_finished();
}

// A resumed run reads the journal, cuts the torn record off and appends.
TEST_P(Run, KeepsRecordedStepsWhenItIsResumed)
{
  constexpr int n_kept = 4, stride = 4;
  const Stage resumed = resumed_after(n_kept + 1);
  for (const std::string call : {"any", "read"}) {
    for (const FaultRow& row : {FaultRow{{"kill", call, "each"}, killed, {}, 0, stride, n_kept},
                                FaultRow{{"torn", call, "each"}, killed, {}, 0, stride, n_kept},
                                FaultRow{{"short", call, "each"}, unchanged, {}, 0, stride, n_kept},
                                FaultRow{{"eio", call, "each"}, either, {}, 0, stride, n_kept},
                                FaultRow{{"enospc", call, "each"}, either, {}, 0, stride, n_kept}})
      FaultyRun::expect_survives(resumed, row);
  }
}

TEST_P(RunOneWay, FinishesAfterErrors)
{
  // But for the last write: the run record is optional. With a lost disk cleanup fails too.
  expect_survives({{{"short", "write", "each"}, unchanged},
                   {{"short", "write", "1+"}, unchanged},
                   {{"full", "write", "each"}, refused, "No space left on device", 1},
                   {{"eio", "any", "each+"},
                    refused,
                    {},
                    n_calls(whole_run(), {"count"}) - n_calls(whole_run(), {"count", "write"}) + 1},
                   {{"eio", "write", "1", "a.h5.run.json"}, warned, "a.h5.run.json"},
                   {{"eio", "open", "1", "a.h5.run.json"}, warned, "a.h5.run.json"},
                   {{"eio", "close", "1", "a.h5.run.json"}, warned, "a.h5.run.json"},
                   {{"eio", "unlink", "1", "a.h5.journal"}, warned, {journal(), "Input/output error"}},
                   {{"eio", "unlink", "each"}, done}});
}

TEST_P(RunOneWay, RemovesTheTemporaryOfAKilledRunDespiteAnError)
{
  Stage stage = whole_run();
  stage.before["a.h5.start.h5.partial"] = "half";
  for (const std::string what : {"eio", "enospc"})
    FaultyRun::expect_survives(stage, {{what, "unlink", "1", "a.h5.start.h5.partial"}, unchanged});
}

TEST_P(RunOneWay, ReportsAnErrorOfSynchronisingDuringTheRun)
{
  // With readings further apart than the journal's interval it synchronises at every record. Each is later,
  // since a sanitizer reads the clock too.
  Stage stage = whole_run();
  stage.command.environment["VRDA_FAULT_CLOCK"] = "10";
  EXPECT_GT(n_calls(stage, {"count", "fsync", "1", "a.h5.journal"}), 2);  // two are of the header and the end
  FaultyRun::expect_survives(stage, {{"eio", "fsync", "each", "a.h5.journal"}, refused, journal()});
}

TEST_P(RunOneWay, NamesAJournalThatCannotBeReadOpenedOrCut)
{
  const Stage resumed = resumed_after(5);
  for (const std::string call : {"read", "open", "truncate"}) {
    SCOPED_TRACE(call);
    put(resumed.before);
    EXPECT_THAT(run({"eio", call, "1", "a.h5.journal"}), refuses({.file = journal()}));
    if (call == "read") {
      EXPECT_EQ(files(), resumed.before);
    }
    expect_finishes();
    EXPECT_EQ(n_steps_recalled(), 4);
  }
  FaultyRun::expect_survives(resumed, {{"short", "read", "1+", "a.h5.journal"}, unchanged});
}

TEST_P(RunOneWay, LosesNothingOnTwoThreads)
{
  Stage threaded = whole_run();
  *std::next(std::ranges::find(threaded.command.arguments, "--threads")) = "2";
  FaultyRun::expect_survives(threaded, {{"torn", "write", "each", "a.h5.journal"}, killed});
}

INSTANTIATE_TEST_SUITE_P(All, Run, testing::ValuesIn(every_method()), name_of);
INSTANTIATE_TEST_SUITE_P(All, RunOneWay, testing::ValuesIn(one_method()), name_of);

/// Magic, version, length of the key, key, checksum.
std::size_t header_bytes(const std::string& journal)
{
  return 8 + 4 + 4 + core::u32_at(journal, 12) + 4;
}

/// A run in two shards.
class Shards : public FaultyRun {
 protected:
  Shards()
      : spine_(stage("spine", part({"--spine"}), {})),
        shard_(stage("shard", part({"--shard", "1/2"}), spine_.after)),
        lone_shard_(stage("shard and spine", part({"--shard", "1/2"}), {})),
        merge_(stage("merge", merge_command(),
                     stage("second shard", part({"--shard", "2/2"}), lone_shard_.after).after))
  {
    expect_finished();
  }

  Command part(const std::vector<std::string>& words) const
  {
    Command with_words = command();
    with_words.arguments.insert(with_words.arguments.end(), words.begin(), words.end());
    return with_words;
  }
  Command merge_command() const
  {
    return vrda({"merge", "-o", (folder_ / "a.h5").string(), "--quiet", "--threads", "1"});
  }

  Stage spine_, shard_, lone_shard_, merge_;
};
class ShardErrors : public Shards {};

TEST_P(Shards, LoseNothing)
{
  for (const Stage& stage : {lone_shard_, merge_}) expect_survives(stage, {{"kill", "any", "each"}, killed});
  for (const Stage& stage : {spine_, shard_, merge_})
    expect_survives(stage, {{"torn", "write", "each"}, killed});
  for (const Stage& stage : {spine_, shard_, lone_shard_, merge_})
    expect_survives(stage, {{"short", "write", "1+"}, unchanged});
}

TEST_P(ShardErrors, AreRefusedAndRepeated)
{
  for (const std::string call : {"write", "fsync", "rename"}) {
    expect_survives(lone_shard_, {{"eio", call, "each"}, refused});
    expect_survives(merge_, {{"eio", call, "each", "a.h5.partial"}, refused});
  }
  // The model is complete; the journals are kept for the next merge.
  for (const std::string call : {"open", "write", "fsync", "close", "rename"})
    expect_survives(merge_, {{"eio", call, "1", "a.h5.case.json.partial"}, warned, "a.h5.case.json"});
  EXPECT_EQ(merge_.before.size(), 5U);
  for (const auto& [name, bytes] : merge_.before) {
    // The last call is the removal: earlier ones are for temporary names.
    const std::string last = std::to_string(n_calls(merge_, {"count", "unlink", "1", name}));
    expect_survives(merge_, {{"eio", "unlink", last, name}, warned, name});
  }
}

TEST_P(Shards, SolveADamagedSpineAgain)
{
  const std::string name = "a.h5.spine.journal", bytes = shard_.before.at(name);
  const std::size_t header = header_bytes(bytes), n_records = bytes.size() - header;
  ASSERT_GT(n_records, 500u);
  // Up to the last record, which with the search is derived from the others.
  for (std::size_t byte = header; byte < header + n_records * 4 / 5; byte += n_records / 5) {
    SCOPED_TRACE(byte);
    std::string flipped = bytes;
    flipped[byte] = static_cast<char>(bytes[byte] ^ 16);
    for (const std::string& damaged : {flipped, bytes.substr(0, byte + 1)}) {
      Files files = shard_.before;
      files[name] = damaged;
      put(files);
      EXPECT_THAT(expect_finishes(shard_), warns(name, "bytes"));
    }
  }
}

// A header is named, a record dropped with a warning: a merge refuses both and changes nothing.
TEST_P(Shards, RefuseADamagedJournal)
{
  struct Row {
    Stage stage;
    std::string name;
    bool is_header;
  };
  for (const auto& [stage, name, is_header] :
       {Row{shard_, "a.h5.spine.journal", true}, Row{merge_, "a.h5.spine.journal", true},
        Row{merge_, "a.h5.shard-2-of-2.journal", true}, Row{merge_, "a.h5.spine.journal", false},
        Row{merge_, "a.h5.shard-1-of-2.journal", false}, Row{merge_, "a.h5.shard-2-of-2.journal", false}}) {
    SCOPED_TRACE(stage.name + ": " + name);
    Files damaged = stage.before;
    char& byte = damaged[name][is_header ? 20 : header_bytes(damaged[name]) + 30];
    byte = static_cast<char>(byte ^ 1);
    put(damaged);
    const Ended ended = test::run(stage.command);
    EXPECT_THAT(ended,
                is_header ? refuses({.file = name, .field = "header"}) : refuses({"a.h5", "journals"}));
    EXPECT_EQ(files(), damaged);
    if (is_header) continue;
    EXPECT_THAT(ended.err, warns(name, "bytes"));
    for (const std::string shard : {"1/2", "2/2"})
      EXPECT_EQ(test::run(part({"--shard", shard})).exit_code, 0);
    expect_finishes(merge_);
  }
}

TEST_P(Shards, TakeTheSpineOverFromOneThatDies)
{
  const int n = n_calls(spine_, {"count"});
  for (const int k : {3, n / 2, n - 4}) {  // the spine is locked and incomplete
    SCOPED_TRACE(k);
    clear();
    const HeldProcess holder(scratch_, spine_.command, in_folder({"hold", "any", std::to_string(k)}));
    Command second = lone_shard_.command;
    std::erase(second.arguments, "--quiet");
    Process waiting(second);
    EXPECT_TRUE(waiting.runs_until_said("waiting for the run"));
    holder.send(SIGKILL);
    const Ended ended = waiting.wait();
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    expect_same(lone_shard_.after);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Shards, testing::ValuesIn(untraced_or(equilibrium())), name_of);
INSTANTIATE_TEST_SUITE_P(All, ShardErrors, testing::Values(search()), name_of);

}  // namespace vrda::test::fault_table_test
