#include "store/journal.hpp"

#include <gtest/gtest.h>

#include <unistd.h>
#include <cmath>

#include <filesystem>

#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::trace_journal_test {

const std::string key(64, 'a');

SearchTrace trace(int n, int n_moves)
{
  SearchTrace search;
  search.key = {n % 2 == 0 ? StepKind::spine_probe : StepKind::row, n, -n};
  search.seed = {{0.1, -20.0 / 3.0, 1e-300}, -0.7 * n};
  search.status = StepStatus::stable;
  for (int k = 0; k < n_moves; ++k) {
    SearchMove move;
    move.iteration = k;
    move.kind = all_move_kinds[static_cast<std::size_t>(k) % std::size(all_move_kinds)];
    move.pose = {{1.0 / (k + 1), 2.0, -0.0}, 0.3 * k};
    move.translation_step_mm = std::ldexp(1.0, -k);
    move.rotation_step_rad = 0.01 * k;
    move.collides = k % 2 == 0;
    move.is_cycle = k % 3 == 0;
    move.in_contact = k % 4 == 1;
    for (int c = 0; c < k % 3; ++c) {
      move.contacts.push_back({{1.0 * c, 2.0, 3.0}, {0, -1, 0}, 0.01 * c, 7 + c, 9 - c, 1});
    }
    search.moves.push_back(move);
  }
  return search;
}

// Of a constructed search of five moves with four contacts in total.
constexpr std::size_t key_bytes = 9, seed_bytes = 32, status_bytes = 1, count_bytes = 4;
constexpr std::size_t five_moves_bytes =
    key_bytes + seed_bytes + status_bytes + count_bytes + 5 * 60 + (0 + 1 + 2 + 0 + 1) * 65;

TEST(TraceJournal, GivesBackEveryBit)
{
  for (const int n_moves : {0, 1, 5, 40}) {
    const std::string bytes = core::bytes_of_value(trace(3, n_moves));
    const std::optional<SearchTrace> again = core::value_of_bytes<SearchTrace>(bytes);
    ASSERT_TRUE(again.has_value());
    EXPECT_EQ(core::bytes_of_value(*again), bytes);
    EXPECT_EQ(again->moves.size(), static_cast<std::size_t>(n_moves));
    EXPECT_EQ(again->key, (StepKey{StepKind::row, 3, -3}));
  }
  EXPECT_EQ(core::bytes_of_value(trace(3, 5)).size(), five_moves_bytes);
}

TEST(TraceJournal, InvalidBytesAreRefused)
{
  const std::string bytes = core::bytes_of_value(trace(3, 5));
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(core::value_of_bytes<SearchTrace>(std::string_view(bytes).substr(0, size)).has_value())
        << size;
  }
  EXPECT_FALSE(core::value_of_bytes<SearchTrace>(bytes + "x").has_value());
  const std::size_t first_move = key_bytes + seed_bytes + status_bytes + count_bytes;
  struct Row {
    const char* what;
    std::size_t at;
    char value;
  };
  for (const Row& row :
       {Row{"kind of node", 0, 3}, Row{"status", key_bytes + seed_bytes, 9},
        Row{"number of moves", first_move - 1, '\x7f'}, Row{"kind of move", first_move + 4, 7},
        Row{"flag", first_move + 5 + 48, 2}, Row{"number of contacts", first_move + 5 + 48 + 6, '\x7f'}}) {
    std::string damaged = bytes;
    damaged[row.at] = row.value;
    EXPECT_FALSE(core::value_of_bytes<SearchTrace>(damaged).has_value()) << row.what;
  }
}

TEST(TraceJournal, KeepsWholeSearchesAndDropsATornOne)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.trace.journal";
  {
    core::FrameWriter writer = store::create_trace_journal(path, key);
    for (int n = 0; n < 3; ++n) writer.append(core::bytes_of_value(trace(n, 5)));
  }
  const std::string whole = test::read_bytes(path);
  const std::string cut = scratch.write("cut.trace.journal", whole.substr(0, whole.size() - 1));
  store::TraceJournalContent content = store::read_trace_journal(cut);
  EXPECT_EQ(content.summary.key, key);
  EXPECT_EQ(content.searches.size(), 2u);
  EXPECT_EQ(content.summary.dropped_reason, "a torn trace");
  {
    core::FrameWriter writer = store::resume_trace_journal(cut, content.summary);
    writer.append(core::bytes_of_value(trace(2, 5)));
  }
  EXPECT_EQ(test::read_bytes(cut), whole);
}

TEST(TraceJournal, ADuplicateSearchIsReadOnce)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.trace.journal";
  {
    core::FrameWriter writer = store::create_trace_journal(path, key);
    for (int n = 0; n < 2; ++n) writer.append(core::bytes_of_value(trace(4, 5)));
  }
  EXPECT_EQ(store::read_trace_journal(path).searches.size(), 1u);
}

TEST(TraceJournal, TheTwoKindsOfJournalsAreDistinguished)
{
  const test::Scratch scratch;
  const std::string traces = scratch.path() / "a.trace.journal", steps = scratch.path() / "a.journal";
  store::create_trace_journal(traces, key);
  store::JournalWriter::create(steps, key);
  EXPECT_EQ(test::input_error([&] { store::read_journal(traces); }).field, "header");
  EXPECT_EQ(test::input_error([&] { store::read_trace_journal(steps); }).field, "header");
}

TEST(TraceJournal, ASecondWriterIsRefused)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.trace.journal";
  const core::FrameWriter writer = store::create_trace_journal(path, key);
  EXPECT_THAT(
      test::input_error([&] { store::resume_trace_journal(path, store::read_trace_journal(path).summary); }),
      test::refuses({.found = std::to_string(getpid())}));
}

}  // namespace vrda::trace_journal_test
