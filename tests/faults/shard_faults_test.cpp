// Injects kills and errors into every call of the parts of a run in turn: spine, shards, merge.
#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <set>
#include <thread>

#include "app/scenes.hpp"
#include "core/framed_file.hpp"
#include "faults/faulty_run.hpp"
#include "store/journal.hpp"
#include "support/messages.hpp"

namespace vrda::test::shard_faults_test {

namespace fs = std::filesystem;

using Files = std::map<std::string, std::string>;  ///< name -> bytes

constexpr const char* all_steps = "steps of all journals";

/// Magic, version, length of the key, key, checksum.
std::size_t header_bytes(const std::string& journal)
{
  return 8 + 4 + 4 + core::u32_at(journal, 12) + 4;
}

/// A command with the folder's files before and after it.
struct Stage {
  std::string name;
  Command command;
  Files before;
  Files after;
};

class ShardFaults : public FaultyRun {
 protected:
  ShardFaults()
  {
    clear();
    const Files nothing;
    const Files spine = add_stage("spine", part({"--spine"}), nothing);
    add_stage("shard", part({"--shard", "1/2"}), spine);
    put(add_stage("lone shard", part({"--shard", "1/2"}), nothing));
    EXPECT_EQ(test::run(part({"--shard", "2/2"})).exit_code, 0);
    add_stage("merge", merge(), files());
    expect_finished();
  }

  Command part(const std::vector<std::string>& words) const
  {
    Command with_words = command();
    with_words.arguments.insert(with_words.arguments.end(), words.begin(), words.end());
    return with_words;
  }

  Command merge() const
  {
    return vrda({"merge", "-o", (folder_ / "a.h5").string(), "--quiet", "--threads", "1"});
  }

  Files add_stage(const std::string& name, const Command& command, const Files& before)
  {
    put(before);
    const Ended ended = test::run(command);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    stages_.push_back({name, command, before, files()});
    return stages_.back().after;
  }

  void put(const Files& files) const
  {
    clear();
    for (const auto& [name, bytes] : files) std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }

  Files files() const
  {
    Files all;
    for (const std::string& name : names()) all[name] = read_bytes(folder_ / name);
    return all;
  }

  /// Content that must not depend on faults: of run records only their existence, of journals the union of
  /// their steps, since a step that is derived from others may be in any of them.
  Files essence(const Files& files) const
  {
    Files all;
    std::set<std::string> steps;
    for (const auto& [name, bytes] : files) {
      const bool is_journal = name.ends_with(".journal");
      all[name] = is_journal || name == "a.h5.run.json" ? "" : bytes;
      if (!is_journal) continue;
      const store::JournalContent content = store::parse_journal(name, bytes);
      EXPECT_EQ(content.dropped_reason, "") << name;
      for (const StepRecord& record : content.records) steps.insert(core::bytes_of_value(record));
    }
    for (const std::string& step : steps) all[all_steps] += step;
    return all;
  }

  int n_calls_in(const Stage& stage, const std::string& call, const std::string& file = "") const
  {
    put(stage.before);
    return n_calls_of(stage.command, in_folder({"count", call, "1", file}), scratch_.path() / "counts");
  }

  Ended disturbed(const Stage& stage, const Fault& fault) const
  {
    put(stage.before);
    return test::run(with_fault(stage.command, in_folder(fault)));
  }

  /// Running the stage's command again gives the same files.
  std::string expect_done(const Stage& stage) const
  {
    const Ended ended = test::run(stage.command);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    expect_same(stage.after);
    return ended.err;
  }

  void expect_same(const Files& wanted) const
  {
    std::vector<std::string> names, wanted_names;
    for (const auto& [name, bytes] : files()) names.push_back(name);
    for (const auto& [name, bytes] : wanted) wanted_names.push_back(name);
    EXPECT_EQ(names, wanted_names);
    EXPECT_TRUE(essence(files()) == essence(wanted));
  }

  const Stage& spine() const { return stages_[0]; }
  const Stage& shard() const { return stages_[1]; }
  const Stage& lone_shard() const { return stages_[2]; }  ///< solves the spine too
  const Stage& merging() const { return stages_[3]; }

 private:
  std::vector<Stage> stages_;
};
class ShardErrors : public ShardFaults {};

TEST_P(ShardFaults, AKillBeforeAnyCallLosesNothing)
{
  for (const Stage& stage : {lone_shard(), merging()}) {
    const int n = n_calls_in(stage, "any");
    EXPECT_GT(n, 20) << stage.name;
    for (int k = 1; k <= n; ++k) {
      SCOPED_TRACE(stage.name + " " + std::to_string(k));
      EXPECT_EQ(disturbed(stage, {"kill", "any", std::to_string(k)}).exit_code, -1);
      expect_no_incomplete_result();
      expect_done(stage);
    }
  }
}

TEST_P(ShardFaults, AWriteThatTearsLosesNothing)
{
  for (const Stage& stage : {spine(), shard(), merging()}) {
    const int n = n_calls_in(stage, "write");
    EXPECT_GE(n, 3) << stage.name;
    for (int k = 1; k <= n; ++k) {
      SCOPED_TRACE(stage.name + " " + std::to_string(k));
      EXPECT_EQ(disturbed(stage, {"torn", "write", std::to_string(k)}).exit_code, -1);
      expect_no_incomplete_result();
      expect_done(stage);
    }
  }
}

TEST_P(ShardFaults, ShortWritesChangeNothing)
{
  for (const Stage& stage : {spine(), shard(), lone_shard(), merging()}) {
    SCOPED_TRACE(stage.name);
    EXPECT_EQ(disturbed(stage, {"short", "write", "1+"}).exit_code, 0);
    expect_same(stage.after);
  }
}

TEST_P(ShardErrors, AnErrorIsOneLineAndTheSameCommandResumes)
{
  struct Row {
    Stage stage;
    std::string file, call;
  };
  for (const auto& [stage, file, call] :
       {Row{lone_shard(), "", "write"}, Row{lone_shard(), "", "fsync"}, Row{lone_shard(), "", "rename"},
        Row{merging(), "a.h5.partial", "write"}, Row{merging(), "a.h5.partial", "fsync"},
        Row{merging(), "a.h5.partial", "rename"}}) {
    const int n = n_calls_in(stage, call, file);
    for (int k = 1; k <= n; ++k) {
      SCOPED_TRACE(stage.name + " " + call + " " + std::to_string(k));
      expect_refused(disturbed(stage, {"eio", call, std::to_string(k), file}));
      expect_done(stage);
    }
  }
}

TEST_P(ShardErrors, AMergeThatCannotWriteTheCaseFileKeepsTheJournals)
{
  for (const std::string call : {"open", "write", "fsync", "close", "rename"}) {
    SCOPED_TRACE(call);
    const Ended ended = disturbed(merging(), {"eio", call, "1", "a.h5.case.json.partial"});
    EXPECT_EQ(ended.exit_code, 0);
    EXPECT_EQ(n_lines(ended.err), 1) << ended.err;
    EXPECT_THAT(ended.err, warns((folder_ / "a.h5.case.json").string()));
    EXPECT_EQ(names().size(), merging().before.size() + 2);  // the model and its run record
    expect_done(merging());
  }
}

TEST_P(ShardErrors, FilesAMergeCannotRemoveAreRemovedByTheNext)
{
  // Journals, start file and case file. The last call is the removal: earlier ones are for temporary names.
  for (const auto& [name, bytes] : merging().before) {
    SCOPED_TRACE(name);
    const std::string last = std::to_string(n_calls_in(merging(), "unlink", name));
    const Ended ended = disturbed(merging(), {"eio", "unlink", last, name});
    EXPECT_EQ(ended.exit_code, 0);
    EXPECT_EQ(n_lines(ended.err), 1) << ended.err;
    EXPECT_THAT(ended.err, warns(name));
    expect_no_incomplete_result();
    expect_done(merging());
  }
}

TEST_P(ShardFaults, ADamagedSpineIsSolvedAgainByTheShardThatReadsIt)
{
  const std::string name = "a.h5.spine.journal", bytes = shard().before.at(name);
  const std::size_t header = header_bytes(bytes), n_records = bytes.size() - header;
  ASSERT_GT(n_records, 500u);
  // Up to the last record, which with the search is derived from the others.
  for (std::size_t byte = header; byte < header + n_records * 4 / 5; byte += n_records / 5) {
    SCOPED_TRACE(byte);
    Files damaged = shard().before;
    damaged[name][byte] = static_cast<char>(bytes[byte] ^ 16);
    put(damaged);
    EXPECT_THAT(expect_done(shard()), warns(name, "bytes"));
    damaged[name] = bytes.substr(0, byte + 1);
    put(damaged);
    EXPECT_THAT(expect_done(shard()), warns(name, "bytes"));
  }
}

TEST_P(ShardFaults, ADamagedHeaderIsNamedAndUnchanged)
{
  for (const auto& [stage, name] :
       {std::pair{shard(), "a.h5.spine.journal"}, std::pair{merging(), "a.h5.spine.journal"},
        std::pair{merging(), "a.h5.shard-2-of-2.journal"}}) {
    Files damaged = stage.before;
    damaged[name][20] = static_cast<char>(damaged[name][20] ^ 1);
    put(damaged);
    const Ended ended = test::run(stage.command);
    expect_refused(ended);
    EXPECT_THAT(ended, refuses({.file = name, .field = "header"}));
    EXPECT_EQ(files(), damaged);
  }
}

TEST_P(ShardFaults, AMergeRejectsADamagedJournal)
{
  for (const std::string name :
       {"a.h5.spine.journal", "a.h5.shard-1-of-2.journal", "a.h5.shard-2-of-2.journal"}) {
    SCOPED_TRACE(name);
    Files damaged = merging().before;
    std::string& bytes = damaged[name];
    bytes[header_bytes(bytes) + 30] = static_cast<char>(bytes[header_bytes(bytes) + 30] ^ 1);
    put(damaged);
    const Ended ended = test::run(merge());
    EXPECT_THAT(ended.err, warns(name, "bytes"));
    EXPECT_THAT(ended, refuses({"a.h5", "journals"}));
    EXPECT_EQ(files(), damaged);
    for (const std::string words : {"1/2", "2/2"}) {
      EXPECT_EQ(test::run(part({"--shard", words})).exit_code, 0);
    }
    expect_done(merging());
  }
}

TEST_P(ShardFaults, AShardThatWaitsForTheSpineTakesItOverFromOneThatDies)
{
  const fs::path held = scratch_.path() / "gate.held";
  const int n = n_calls_in(spine(), "any");
  for (const int k : {3, n / 2, n - 4}) {  // the spine is locked and incomplete
    SCOPED_TRACE(k);
    clear();
    fs::remove(held);
    Command first = with_fault(spine().command, in_folder({"hold", "any", std::to_string(k)}));
    first.environment["VRDA_FAULT_GATE"] = scratch_.path() / "gate";
    Process holder(first);
    while (holder.is_running() && !fs::exists(held))
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    ASSERT_TRUE(holder.is_running());
    Command second = lone_shard().command;
    std::erase(second.arguments, "--quiet");
    Process waiting(second);
    while (waiting.is_running() && waiting.said().find("waiting for the run") == std::string::npos)
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    EXPECT_TRUE(waiting.is_running());
    holder.send(SIGKILL);
    const Ended ended = waiting.wait();
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    expect_same(lone_shard().after);
  }
}

INSTANTIATE_TEST_SUITE_P(All, ShardFaults, testing::ValuesIn(untraced_or(equilibrium())), name_of);
INSTANTIATE_TEST_SUITE_P(All, ShardErrors, testing::Values(search()), name_of);

}  // namespace vrda::test::shard_faults_test
