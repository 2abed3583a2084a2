// Polling a growing journal in every state.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <set>
#include <thread>

#include "core/framed_file.hpp"
#include "core/text.hpp"
#include "store/journal.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::journal_test {

using test::input_error;

const std::string key(64, 'a');
const std::string other_key(64, 'b');

StepRecord record(int n, int n_contacts = 2)
{
  StepRecord step;
  step.key = {static_cast<StepKind>(n % 5), n, -n};
  step.pose = {{0.1 * n, -20.0 / 3.0, 1e-300}, -0.7 * n};
  step.status = all_step_statuses[static_cast<std::size_t>(n) % std::size(all_step_statuses)];
  step.iterations = 1000 + n;
  step.queries = 2000000000;
  step.residual_mm = 0.05 / (n + 1);
  step.gap_mm[0] = n % 2 == 0 ? std::numeric_limits<double>::quiet_NaN() : -0.0;
  step.gap_mm[1] = std::numeric_limits<double>::denorm_min();
  step.is_in_contact[0] = n % 2 == 0;
  step.theta_determined = n % 3 == 0;
  step.varus_rad = 0.01 * n;
  step.balance.energy_nmm = -20.0 / 7.0 * n;
  step.balance.varus_moment_nmm = -0.0;
  for (int c = 0; c < n % 4; ++c) {
    step.balance.forces.push_back(
        {{1.5 * c, -2.0, 3.0}, {0, -1, 0}, 0.1 + c, 3 + c, 5 - c, static_cast<std::int8_t>(c % 3)});
  }
  if (n % 3 == 1) {
    step.coordinates.emplace();
    step.coordinates->flexion_rad = 0.3 * n;
    for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
      step.coordinates->holding[k] =
          k == 2 ? std::numeric_limits<double>::quiet_NaN() : 0.5 * n - static_cast<double>(k);
      step.coordinates->determined[k] = static_cast<std::int8_t>(k % 3 - 1);
    }
  }
  for (int c = 0; c < n_contacts; ++c) {
    step.contacts.push_back(
        {{1.0 * c, 2.0, 3.0}, {0, -1, 0}, 0.01 * c, 7 + c, 9 - c, static_cast<std::int8_t>(c % 3)});
  }
  return step;
}

void write_journal(const std::string& path, int n_records)
{
  store::JournalWriter writer = store::JournalWriter::create(path, key);
  for (int n = 0; n < n_records; ++n) writer.append(record(n, n % 3));
  writer.close();
}

void expect_records(const store::JournalContent& content, std::size_t n_records)
{
  ASSERT_EQ(content.records.size(), n_records);
  for (std::size_t n = 0; n < n_records; ++n) {
    SCOPED_TRACE(n);
    const int index = static_cast<int>(n);
    EXPECT_EQ(core::bytes_of_value(content.records[n]), core::bytes_of_value(record(index, index % 3)));
  }
}

TEST(Journal, GivesBackEveryBit)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  write_journal(path, 20);
  const store::JournalContent content = store::read_journal(path);
  EXPECT_EQ(content.key, key);
  EXPECT_EQ(content.dropped_bytes, 0u);
  EXPECT_EQ(content.dropped_reason, "");
  EXPECT_EQ(content.valid_bytes, std::filesystem::file_size(path));
  expect_records(content, 20);
}

// The bytes of version 2 of the format, in which other programs' journals were written: a field that moves,
// or is not written, changes them. A change raises the version.
TEST(Journal, LayoutOfVersion2)
{
  std::string bytes;
  for (int n = 0; n < 6; ++n) bytes += core::bytes_of_value(record(n, n % 3));
  EXPECT_EQ(core::u32_at(core::frame_of(bytes), 4), 429053899u);  // CRC-32, golden
}

// Numbers that a model could not store are no record, though every checksum fits.
TEST(Journal, UnusableValues)
{
  const StepRecord sound = record(1);
  ASSERT_EQ(sound.status, StepStatus::stable);
  const std::function<void(StepRecord&)> damages[] = {
      [](StepRecord& r) { r.pose.translation_mm.y() = 1e30; },
      [](StepRecord& r) { r.pose.translation_mm.y() = nan; },
      [](StepRecord& r) { r.pose.theta_rad = -1e10; },
      [](StepRecord& r) { r.varus_rad = nan; },
      [](StepRecord& r) { r.coordinates->flexion_rad = 1e10; },
      [](StepRecord& r) { r.coordinates->determined[3] = 2; },
      [](StepRecord& r) { r.status = static_cast<StepStatus>(9); },
      [](StepRecord& r) { r.key.kind = static_cast<StepKind>(12); }};
  EXPECT_TRUE(core::value_of_bytes<StepRecord>(core::bytes_of_value(sound)).has_value());
  for (const auto& damage : damages) {
    StepRecord damaged = sound;
    damage(damaged);
    EXPECT_FALSE(core::value_of_bytes<StepRecord>(core::bytes_of_value(damaged)).has_value())
        << &damage - damages;
  }
}

TEST(Journal, AnotherFormatVersionIsNamed)
{
  // A header of version 3, written by hand; CRC-32 by Python's zlib.crc32.
  const test::Scratch scratch;
  const std::string header("VRDAJRNL\x03\x00\x00\x00\x01\x00\x00\x00k", 17);
  const std::string file = scratch.write("a.journal", header + std::string("\xde\x14\xa3\x7e", 4));
  EXPECT_THAT(input_error([&] { store::read_journal(file); }),
              test::refuses({.field = "format version", .found = "3", .wanted = "2"}));
}

TEST(Journal, WaitsForTheDiskAtIntervals)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  store::JournalWriter writer = store::JournalWriter::create(path, key);
  const std::uintmax_t n_header = std::filesystem::file_size(path);
  writer.sync_every(std::chrono::hours(1));
  for (int n = 0; n < 3; ++n) writer.append(record(n, 1));
  EXPECT_EQ(writer.n_unsynced_bytes(), std::filesystem::file_size(path) - n_header);
  writer.sync_every(std::chrono::seconds(0));
  writer.append(record(3, 1));
  EXPECT_EQ(writer.n_unsynced_bytes(), 0u);
  writer.sync_every(std::chrono::hours(1));
  writer.append(record(4, 1));
  EXPECT_GT(writer.n_unsynced_bytes(), 0u);
  writer.flush();
  EXPECT_EQ(writer.n_unsynced_bytes(), 0u);
}

// A journal of three records whose folder is lost before the third.
void expect_put_back(const std::function<void(const std::filesystem::path& folder)>& lose)
{
  const test::Scratch scratch;
  const std::filesystem::path folder = scratch.path() / "out" / "deep";
  std::filesystem::create_directories(folder);
  const std::string path = folder / "a.journal";
  store::JournalWriter writer = store::JournalWriter::create(path, key);
  writer.append(record(0, 0));
  writer.append(record(1, 1));
  EXPECT_TRUE(writer.is_in_place());
  lose(folder);
  EXPECT_FALSE(writer.is_in_place());
  EXPECT_THAT(input_error([&] { writer.append(record(2, 2)); }), test::refuses({path, "", "deleted"}));
  EXPECT_EQ(input_error([&] { writer.flush(); }).file, path);
  writer.restore();
  expect_records(store::read_journal(path), 3);
}

TEST(Journal, ADeletedOrMovedFileIsDetectedAndRestored)
{
  expect_put_back(
      [](const std::filesystem::path& folder) { std::filesystem::remove_all(folder.parent_path()); });
  expect_put_back([](const std::filesystem::path& folder) { std::filesystem::remove(folder / "a.journal"); });
  expect_put_back([](const std::filesystem::path& folder) {
    std::filesystem::rename(folder, folder.parent_path() / "elsewhere");
  });
}

TEST(Journal, RestoreDoesNotReplaceAnotherFile)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  store::JournalWriter writer = store::JournalWriter::create(path, key);
  std::filesystem::remove(path);
  scratch.write("a.journal", "another run's");
  EXPECT_FALSE(writer.is_in_place());
  EXPECT_THAT(input_error([&] { writer.restore(); }), test::refuses({path, "", "another file"}));
  EXPECT_EQ(test::read_bytes(path), "another run's");
}

TEST(Journal, OfManyThatOpenANewOneAtOnceEachWritesAloneInTurn)
{
  // Each writer opens, appends one record and closes; it retries while the file is in use.
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  constexpr int n_writers = 8;
  std::vector<pid_t> writers;
  for (int n = 0; n < n_writers; ++n) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      for (;;) {
        std::optional<store::OpenJournal> opened = store::JournalWriter::try_open(path, key);
        if (!opened) continue;
        const bool is_in_order = opened->content.dropped_bytes == 0;
        opened->writer.append(record(n, 0));
        _exit(is_in_order ? 0 : 1);
      }
    }
    writers.push_back(child);
  }
  for (const pid_t writer : writers) {
    int status = 0;
    ASSERT_EQ(waitpid(writer, &status, 0), writer);
    EXPECT_EQ(status, 0);
  }
  const store::JournalContent content = store::read_journal(path);
  EXPECT_EQ(content.dropped_bytes, 0u);
  std::set<std::int32_t> found;
  for (const StepRecord& r : content.records) found.insert(r.key.flexion);
  EXPECT_EQ(found.size(), static_cast<std::size_t>(n_writers));
  EXPECT_FALSE(std::filesystem::exists(path + ".partial"));
}

TEST(Journal, ThreadsNeverTearEachOthersRecords)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  constexpr int n_each = 500;
  {
    store::JournalWriter writer = store::JournalWriter::create(path, key);
    const auto append_from = [&](int first) {
      for (int n = first; n < first + n_each; ++n) writer.append(record(n, n % 3));
    };
    const std::jthread one(append_from, 0);
    const std::jthread two(append_from, n_each);
  }
  const store::JournalContent content = store::read_journal(path);
  EXPECT_EQ(content.dropped_bytes, 0u);
  std::set<std::string> found, wanted;
  for (const StepRecord& step : content.records) found.insert(core::bytes_of_value(step));
  for (int n = 0; n < 2 * n_each; ++n) wanted.insert(core::bytes_of_value(record(n, n % 3)));
  EXPECT_EQ(content.records.size(), wanted.size());
  EXPECT_EQ(found, wanted);
}

StepRecord row_record(int n, int n_contacts = 2)
{
  StepRecord step;
  step.key = {StepKind::row, n, 2 * n};
  step.pose = {{0.1 * n, -20.0 / 3.0, 1e-300}, -0.7 * n};
  step.status = StepStatus::stable;
  step.contacts.resize(static_cast<std::size_t>(n_contacts));
  return step;
}

std::vector<std::string> frames_of(int first, int last, int n_contacts = 2)
{
  std::vector<std::string> frames;
  for (int n = first; n <= last; ++n) frames.push_back(core::bytes_of_value(row_record(n, n_contacts)));
  return frames;
}

class Tail : public testing::Test {
 protected:
  store::JournalWriter fresh(int n_records, const std::string& its_key = key, int n_contacts = 2)
  {
    store::JournalWriter writer = store::JournalWriter::create(path_, its_key);
    for (int n = 0; n < n_records; ++n) writer.append(row_record(n, n_contacts));
    return writer;
  }
  void expect(const core::TailUpdate& news, bool is_restarted, const std::vector<std::string>& frames)
  {
    EXPECT_TRUE(news.file_exists);
    EXPECT_EQ(news.is_restarted, is_restarted);
    EXPECT_EQ(news.frames, frames);
    EXPECT_FALSE(news.has_more);
  }

  test::Scratch scratch_;
  std::string path_ = (scratch_.path() / "knee.h5.journal").string();
  core::FrameTail tail_ = store::journal_tail(path_);
};

TEST_F(Tail, ATornRecordIsReadWhenItIsWhole)
{
  fresh(3).close();
  const std::string bytes = test::read_bytes(path_);
  const std::size_t frame_bytes = core::frame_head_bytes + core::bytes_of_value(row_record(0)).size();
  const std::size_t header_bytes = bytes.size() - 3 * frame_bytes;
  // A prefix of every length, as on a network file system.
  int n_read = 0, n_torn = 0, n_headless = 0;
  for (std::size_t n = 0; n <= bytes.size(); ++n) {
    scratch_.write("knee.h5.journal", bytes.substr(0, n));
    const core::TailUpdate news = tail_.poll();
    n_read += static_cast<int>(news.frames.size());
    n_torn += news.invalid_reason.find("torn") != std::string::npos ? 1 : 0;
    n_headless += news.invalid_reason.find("header") != std::string::npos ||
                  news.invalid_reason.find("not a journal") == 0;
    const auto n_whole = n < header_bytes ? 0 : static_cast<int>((n - header_bytes) / frame_bytes);
    ASSERT_EQ(n_read, n_whole) << n << " bytes";
  }
  EXPECT_EQ(n_read, 3);
  EXPECT_EQ(n_torn, 3 * static_cast<int>(frame_bytes - 1));
  EXPECT_EQ(n_headless, static_cast<int>(header_bytes));
}

TEST_F(Tail, AJournalStartedOverIsReadFromItsBeginning)
{
  fresh(4).close();
  expect(tail_.poll(), false, frames_of(0, 3));
  fresh(2, other_key).close();
  expect(tail_.poll(), true, frames_of(0, 1));
  EXPECT_EQ(tail_.key(), other_key);
  // Longer than before, in the same file and by the same job.
  std::filesystem::copy_file(path_, path_ + ".copy");
  fresh(6, other_key, 3).close();
  const std::string longer = test::read_bytes(path_);
  std::filesystem::rename(path_ + ".copy", path_);
  expect(tail_.poll(), true, frames_of(0, 1));
  std::ofstream(path_, std::ios::binary | std::ios::trunc) << longer;
  expect(tail_.poll(), true, frames_of(0, 5, 3));
}

TEST_F(Tail, AResumedJournalWithATornEndIsNotRestarted)
{
  fresh(2).close();
  std::ofstream(path_, std::ios::binary | std::ios::app) << "torn";
  const core::TailUpdate torn = tail_.poll();
  expect(torn, false, frames_of(0, 1));
  EXPECT_NE(torn.invalid_reason, "");
  store::JournalWriter writer = std::move(store::JournalWriter::open(path_, key).writer);
  writer.append(row_record(2));
  expect(tail_.poll(), false, frames_of(2, 2));
}

TEST_F(Tail, AFileCutBelowTheLastPollIsReadAgain)
{
  fresh(4).close();
  expect(tail_.poll(), false, frames_of(0, 3));
  const std::size_t frame_bytes = core::frame_head_bytes + core::bytes_of_value(row_record(0)).size();
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 2 * frame_bytes);
  expect(tail_.poll(), true, frames_of(0, 1));
  {
    store::JournalWriter writer = std::move(store::JournalWriter::open(path_, key).writer);
    writer.append(row_record(2));
    expect(tail_.poll(), false, frames_of(2, 2));
  }
  // Cut and grown beyond the previous length between two polls.
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 2 * frame_bytes);
  {
    store::JournalWriter writer = std::move(store::JournalWriter::open(path_, key).writer);
    for (int n = 7; n < 10; ++n) writer.append(row_record(n));
  }
  std::vector<std::string> all = frames_of(0, 0);
  for (const std::string& frame : frames_of(7, 9)) all.push_back(frame);
  expect(tail_.poll(), true, all);
}

TEST_F(Tail, AFileThatVanishesKeepsWhatWasReadUntilAnotherAppears)
{
  fresh(2).close();
  expect(tail_.poll(), false, frames_of(0, 1));
  std::filesystem::remove(path_);
  const core::TailUpdate gone = tail_.poll();
  EXPECT_FALSE(gone.file_exists);
  EXPECT_FALSE(gone.is_restarted);
  fresh(3).close();
  expect(tail_.poll(), true, frames_of(0, 2));
}

TEST_F(Tail, ALongJournalNeedsSeveralPolls)
{
  // 100 contacts are 7 kB: a thousand such records exceed the limit of one poll.
  fresh(1000, key, 100).close();
  std::vector<std::string> all;
  int n_polls = 0;
  for (bool has_more = true; has_more; ++n_polls) {
    const core::TailUpdate news = tail_.poll();
    EXPECT_EQ(news.invalid_reason, "");
    all.insert(all.end(), news.frames.begin(), news.frames.end());
    has_more = news.has_more;
  }
  EXPECT_GT(n_polls, 1);
  EXPECT_EQ(all, frames_of(0, 999, 100));
  // One record above the limit.
  store::JournalWriter writer = std::move(store::JournalWriter::open(path_, key).writer);
  writer.append(row_record(1000, 100000));
  expect(tail_.poll(), false, frames_of(1000, 1000, 100000));
}

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
  EXPECT_EQ(content.key, key);
  EXPECT_EQ(content.searches.size(), 2u);
  EXPECT_EQ(content.dropped_reason, "a torn trace");
  {
    core::FrameWriter writer = store::resume_trace_journal(cut, content);
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

}  // namespace vrda::journal_test
