// Injects a kill, an error or a short write into every call of a run and of its parts in turn (spine, shards,
// merge), after counting the calls: the same command then finishes with the same files.
// Tests of the shim with dd, which makes one write call per block.
// A journal that was cut or has a flipped bit: the records before the damage are kept, the rest is solved
// again.
#include <gmock/gmock.h>

#include <algorithm>
#include <csignal>
#include <fstream>

#include "app/scenes.hpp"
#include "core/framed_file.hpp"
#include "core/text.hpp"
#include "faults/faulty_run.hpp"
#include "store/journal.hpp"
#include "support/messages.hpp"

namespace vrda::test::fault_table_test {

namespace fs = std::filesystem;
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
TEST_P(RunOneWay, RefusesAnError)
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
    if (!runs_full_set() && k > 3 && k < n - 1) continue;
    SCOPED_TRACE(k);
    EXPECT_EQ(run_from_empty({"torn", "write", std::to_string(k), "a.h5.journal"}).exit_code, -1);
    const store::JournalContent content = store::read_journal(journal());
    EXPECT_EQ(content.records.size(), static_cast<std::size_t>(k - 2));
    EXPECT_THAT(expect_finishes(), warns(journal(), std::to_string(content.dropped_bytes) + " bytes"));
    EXPECT_EQ(n_steps_recalled(), k - 2);
  }
}

TEST_P(RunOneWay, FinishesThoughEachOfItsStartsIsKilled)
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

class Shim : public testing::Test {
 protected:
  /// Four blocks of 100 bytes into out/blocks.
  Command blocks() const
  {
    return {"/bin/dd", {"if=/dev/zero", "of=" + file_.string(), "bs=100", "count=4", "status=none"}, {}, {}};
  }
  Ended run_with(const Fault& fault) const
  {
    fs::remove(file_);
    return run(with_fault(blocks(), fault));
  }
  std::uintmax_t size() const { return fs::file_size(file_); }

  Scratch scratch_;
  fs::path file_ = scratch_.path() / "blocks";
};

TEST_F(Shim, CountsTheCallsOfOneFile)
{
  const fs::path counts = scratch_.path() / "counts";
  EXPECT_EQ(n_calls_of(blocks(), {"count", "write", "1", "/blocks"}, counts), 4);
  EXPECT_EQ(n_calls_of(blocks(), {"count", "read", "1", "/dev/zero"}, counts), 4);
  EXPECT_EQ(n_calls_of(blocks(), {"count", "open", "1", "/blocks"}, counts), 1);
  Command synced = blocks();
  synced.arguments.emplace_back("conv=fsync");
  EXPECT_EQ(n_calls_of(synced, {"count", "fsync", "1", "/blocks"}, counts), 1);
  Command moved{"/bin/mv", {file_.string(), file_.string() + ".moved"}, {}, {}};
  fs::remove(counts);
  moved = with_fault(moved, {"count", "write", "1", "/blocks"});
  moved.environment["VRDA_FAULT_COUNT"] = counts.string();
  EXPECT_EQ(run(moved).exit_code, 0);
  EXPECT_EQ(read_bytes(counts), "0\n");
}

TEST_F(Shim, DisturbsTheCallAndThoseAfterIt)
{
  struct Row {
    Fault fault;
    int exit_code;
    std::uintmax_t n_bytes;
    const char* said;
  };
  for (const Row& row : {Row{{"kill", "write", "1", "/blocks"}, -1, 0, ""},
                         Row{{"kill", "write", "4", "/blocks"}, -1, 300, ""},
                         Row{{"torn", "write", "1", "/blocks"}, -1, 50, ""},
                         Row{{"torn", "write", "3", "/blocks"}, -1, 250, ""},
                         // dd writes the rest by another call
                         Row{{"short", "write", "2", "/blocks"}, 0, 400, ""},
                         Row{{"full", "write", "3", "/blocks"}, 1, 250, "No space left on device"},
                         Row{{"eio", "write", "2", "/blocks"}, 1, 100, "Input/output error"}}) {
    SCOPED_TRACE(row.fault.what + " " + row.fault.at);
    const Ended ended = run_with(row.fault);
    EXPECT_EQ(ended.exit_code, row.exit_code);
    EXPECT_EQ(size(), row.n_bytes);
    EXPECT_NE(ended.err.find(row.said), std::string::npos) << ended.err;
  }
  EXPECT_EQ(run_with({"enospc", "open", "1+", "/blocks"}).exit_code, 1);
  EXPECT_FALSE(fs::exists(file_));
}

class JournalDamage : public FaultyRun {
 protected:
  JournalDamage()
  {
    // Killed before its last record: the journal contains all others.
    run_from_empty({"kill", "open", "1", "a.h5.partial"});
    bytes_ = read_bytes(journal());
    // Magic, version, length of the key, key, checksum; then of each frame its length, checksum and content.
    std::size_t end = 8 + 4 + 4 + core::u32_at(bytes_, 12) + 4;
    for (; end < bytes_.size(); end += 8 + core::u32_at(bytes_, end)) ends_.push_back(end);
    ends_.push_back(end);
    EXPECT_EQ(end, bytes_.size());
    EXPECT_GT(ends_.size(), 6u);
  }

  /// Number of complete frames that end at or before this byte.
  std::size_t n_whole_before(std::size_t byte) const
  {
    return static_cast<std::size_t>(std::upper_bound(ends_.begin(), ends_.end(), byte) - ends_.begin()) - 1;
  }

  std::string flipped(std::size_t byte, int bit) const
  {
    std::string damaged = bytes_;
    damaged[byte] = static_cast<char>(damaged[byte] ^ (1 << bit));
    return damaged;
  }

  void put_journal(const std::string& bytes) const { std::ofstream(journal(), std::ios::binary) << bytes; }

  /// The first `n_kept` frames are recalled, the rest is solved again; the message reports the dropped bytes.
  void expect_goes_on(const std::string& damaged, std::size_t n_kept) const
  {
    std::filesystem::remove(folder_ / "a.h5");  // a finished job reads no journal
    put_journal(damaged);
    const std::string said = expect_finishes();
    EXPECT_EQ(n_steps_recalled(), static_cast<int>(n_kept));
    EXPECT_THAT(said, warns(journal(), std::to_string(damaged.size() - ends_[n_kept]) + " bytes"));
  }

  std::string bytes_;
  std::vector<std::size_t> ends_;  ///< of the header, then of each frame
};

void expect_content(const store::JournalContent& content, std::size_t n_records, std::size_t valid,
                    std::size_t size)
{
  EXPECT_EQ(content.records.size(), n_records);
  EXPECT_EQ(content.valid_bytes, valid);
  EXPECT_EQ(content.dropped_bytes, size - valid);
  EXPECT_EQ(content.dropped_reason.empty(), size == valid);
}

TEST_P(JournalDamage, EveryLengthIsReadUpToItsLastWholeRecord)
{
  for (std::size_t size = ends_[0]; size <= bytes_.size(); ++size) {
    SCOPED_TRACE(size);
    const std::size_t n = n_whole_before(size);
    expect_content(store::parse_journal("a", bytes_.substr(0, size)), n, ends_[n], size);
  }
}

// Of the first two records and the last one; those between have the same form.
TEST_P(JournalDamage, EveryFlippedBitIsDetected)
{
  for (std::size_t byte = ends_[0]; byte < bytes_.size(); ++byte) {
    if (byte == ends_[2]) byte = ends_[ends_.size() - 2];
    for (int bit = 0; bit < 8; ++bit) {
      SCOPED_TRACE(std::to_string(byte) + " " + std::to_string(bit));
      const std::size_t n = n_whole_before(byte);
      expect_content(store::parse_journal("a", flipped(byte, bit)), n, ends_[n], bytes_.size());
    }
  }
}

TEST_P(JournalDamage, EveryDamageToTheHeaderIsAnErrorThatNamesTheFile)
{
  int n_refused = 0;
  const auto count_refusal = [&](const std::string& damaged) {
    try {
      store::parse_journal("a.journal", damaged);
    } catch (const InputError& error) {
      n_refused += error.facts().file == "a.journal" ? 1 : 0;
    }
  };
  const int n_bytes = static_cast<int>(ends_[0]);
  for (std::size_t byte = 0; byte < ends_[0]; ++byte) {
    for (int bit = 0; bit < 8; ++bit) count_refusal(flipped(byte, bit));
    count_refusal(bytes_.substr(0, byte));
  }
  EXPECT_EQ(n_refused, 9 * n_bytes);
}

TEST_P(JournalDamage, ARunResumesBeforeTheDamage)
{
  // Offsets with a stride that is coprime to a record's length, and the ends of each record.
  const std::size_t n = ends_.size() - 1;
  for (const std::size_t size : {ends_[0] + 7, ends_[2] + 8, ends_[n] - 1}) {
    SCOPED_TRACE(size);
    expect_goes_on(bytes_.substr(0, size), n_whole_before(size));
  }
  for (std::size_t byte = ends_[0]; byte < bytes_.size(); byte += (bytes_.size() - ends_[0]) / 4) {
    SCOPED_TRACE(byte);
    expect_goes_on(flipped(byte, static_cast<int>(byte % 8)), n_whole_before(byte));
  }
}

TEST_P(JournalDamage, ADamagedHeaderIsReportedAndTheJournalKept)
{
  for (const std::string& damaged : {flipped(3, 0), flipped(8, 1), flipped(40, 5), flipped(ends_[0] - 1, 7),
                                     bytes_.substr(0, ends_[0] - 1), std::string()}) {
    put_journal(damaged);
    const Ended ended = run();
    expect_refused(ended);
    EXPECT_THAT(ended, refuses({journal(), "header"}));
    EXPECT_EQ(read_bytes(journal()), damaged);
  }
  Command fresh = command();
  fresh.arguments.emplace_back("--fresh");
  EXPECT_EQ(test::run(fresh).exit_code, 0);
  expect_finished();
}

INSTANTIATE_TEST_SUITE_P(All, JournalDamage, testing::ValuesIn(untraced_or(equilibrium())), name_of);

}  // namespace vrda::test::fault_table_test
