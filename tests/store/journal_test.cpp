#include "store/journal.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>
#include <set>
#include <thread>

#include "core/text.hpp"
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
  step.gap_medial_mm = n % 2 == 0 ? std::numeric_limits<double>::quiet_NaN() : -0.0;
  step.gap_lateral_mm = std::numeric_limits<double>::denorm_min();
  step.contact_medial = n % 2 == 0;
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
      [](StepRecord& r) { r.key.kind = static_cast<StepKind>(6); }};
  EXPECT_TRUE(core::value_of_bytes<StepRecord>(core::bytes_of_value(sound)).has_value());
  for (const auto& damage : damages) {
    StepRecord damaged = sound;
    damage(damaged);
    EXPECT_FALSE(core::value_of_bytes<StepRecord>(core::bytes_of_value(damaged)).has_value())
        << &damage - damages;
  }
}

TEST(Journal, CutAnywhereKeepsTheWholeRecordsBefore)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  std::vector<std::uintmax_t> ends;  // of the header, then of each record
  {
    store::JournalWriter writer = store::JournalWriter::create(path, key);
    ends.push_back(std::filesystem::file_size(path));
    for (int n = 0; n < 4; ++n) {
      writer.append(record(n, n % 3));
      ends.push_back(std::filesystem::file_size(path));
    }
  }
  const std::string whole = test::read_bytes(path);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    SCOPED_TRACE(size);
    const std::string cut = scratch.write("cut.journal", whole.substr(0, size));
    if (size < ends[0]) {
      EXPECT_EQ(input_error([&] { store::read_journal(cut); }).file, cut);
      continue;
    }
    const auto n_whole = std::upper_bound(ends.begin(), ends.end(), size) - ends.begin() - 1;
    const store::JournalContent content = store::read_journal(cut);
    expect_records(content, static_cast<std::size_t>(n_whole));
    EXPECT_EQ(content.valid_bytes, ends[static_cast<std::size_t>(n_whole)]);
    EXPECT_EQ(content.dropped_bytes, size - content.valid_bytes);
    EXPECT_EQ(content.dropped_reason.empty(), content.dropped_bytes == 0);
  }
}

TEST(Journal, AFlippedBitDropsItsRecordAndTheRest)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  write_journal(path, 1);
  const std::size_t first_end = std::filesystem::file_size(path);
  write_journal(path, 3);
  const std::string whole = test::read_bytes(path);
  write_journal(path, 2);
  const std::size_t second_end = std::filesystem::file_size(path);
  for (std::size_t byte = first_end; byte < second_end; ++byte) {
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = whole;
      damaged[byte] = static_cast<char>(damaged[byte] ^ (1 << bit));
      const store::JournalContent content = store::read_journal(scratch.write("damaged.journal", damaged));
      EXPECT_EQ(content.records.size(), 1u) << "byte " << byte << " bit " << bit;
      EXPECT_EQ(content.valid_bytes, first_end);
      EXPECT_EQ(content.dropped_bytes, whole.size() - first_end);
      EXPECT_NE(content.dropped_reason, "");
    }
  }
}

TEST(Journal, AFlippedBitInTheHeaderIsRefused)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  write_journal(path, 0);
  const std::string whole = test::read_bytes(path);
  for (std::size_t byte = 0; byte < whole.size(); ++byte) {
    std::string damaged = whole;
    damaged[byte] = static_cast<char>(damaged[byte] ^ 4);
    const std::string file = scratch.write("damaged.journal", damaged);
    EXPECT_EQ(input_error([&] { store::read_journal(file); }).file, file) << byte;
  }
}

TEST(Journal, ResumingCutsTheTailAndContinues)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  write_journal(path, 3);
  const std::string torn = scratch.write("torn.journal", test::read_bytes(path) + "half a rec");
  {
    store::OpenJournal opened = store::JournalWriter::open(torn, key);
    EXPECT_EQ(opened.content.dropped_bytes, 10u);
    opened.writer.append(record(3, 0));
  }
  expect_records(store::read_journal(torn), 4);
  write_journal(path, 4);
  EXPECT_EQ(test::read_bytes(torn), test::read_bytes(path));
}

TEST(Journal, CreateStartsOver)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  write_journal(path, 3);
  write_journal(path, 1);
  expect_records(store::read_journal(path), 1);
}

TEST(Journal, AnotherJobsJournalNamesFileAndBothKeys)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  write_journal(path, 1);
  const store::JournalContent content = store::read_journal(path);
  EXPECT_NO_THROW(store::require_key(content.key, path, key));
  const InputError::Facts facts = input_error([&] { store::require_key(content.key, path, other_key); });
  // vrda resume has no --fresh
  EXPECT_THAT(facts, test::refuses({path, "key", key, {other_key, "--fresh", "vrda resume"}}));
}

TEST(Journal, AnotherFileIsRefused)
{
  const test::Scratch scratch;
  for (const std::string& bytes :
       {std::string(), std::string("title = \"a job\"\n"), std::string(200, '\0')}) {
    const std::string file = scratch.write("job.toml", bytes);
    EXPECT_THAT(input_error([&] { store::read_journal(file); }),
                test::refuses({file, "header", "", "journal"}));
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

TEST(Journal, AMissingOrUnwritableFileIsNamed)
{
  const test::Scratch scratch;
  const std::string nowhere = scratch.path() / "no" / "such" / "a.journal";
  EXPECT_EQ(input_error([&] { store::read_journal(nowhere); }).file, nowhere);
  EXPECT_THAT(input_error([&] { store::JournalWriter::create(nowhere, key); }),
              test::refuses({nowhere, "", "", "written"}));
  EXPECT_EQ(input_error([&] { store::JournalWriter::open(nowhere, key); }).file, nowhere);
  const std::string folder = scratch.path();
  EXPECT_EQ(input_error([&] { store::JournalWriter::create(folder, key); }).file, folder);
}

TEST(Journal, AFullDiskIsNamedAndLeavesAValidJournal)
{
  // A file size limit simulates a full disk: the write stops in the middle of a record.
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  write_journal(path, 0);
  const rlim_t limit = std::filesystem::file_size(path) + 1200;
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit small{limit, limit};
    setrlimit(RLIMIT_FSIZE, &small);
    int n_errors = 0;
    store::JournalWriter writer = store::JournalWriter::open(path, key).writer;
    for (int n = 0; n < 20; ++n) {
      try {
        writer.append(record(n, n % 3));
      } catch (const InputError&) {
        ++n_errors;
      }
    }
    _exit(n_errors > 0 ? 0 : 1);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const store::JournalContent content = store::read_journal(path);
  EXPECT_GT(content.records.size(), 3u);
  EXPECT_EQ(content.dropped_bytes, 0u);
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

TEST(Journal, ASecondWriterIsRefused)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  store::JournalWriter writer = store::JournalWriter::create(path, key);
  for (const bool fresh : {true, false}) {
    const InputError::Facts facts = input_error([&] {
      if (fresh) store::JournalWriter::create(path, key);
      store::JournalWriter::open(path, key);
    });
    EXPECT_THAT(facts, test::refuses({path, "", std::to_string(getpid())}));
  }
  writer.append(record(0, 0));
  writer.flush();
  expect_records(store::read_journal(path), 1);
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

TEST(Journal, SurvivesAKillInTheMiddle)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "a.journal";
  write_journal(path, 0);
  for (int round = 0; round < 3; ++round) {
    SCOPED_TRACE(round);
    const store::JournalContent before = store::read_journal(path);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      store::JournalWriter writer = store::JournalWriter::open(path, key).writer;
      for (int n = static_cast<int>(before.records.size());; ++n) writer.append(record(n, n % 3));
    }
    // Each record takes at least 100 bytes: the kill comes after some hundreds.
    while (std::filesystem::file_size(path) < before.valid_bytes + 50000) usleep(100);
    kill(child, SIGKILL);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
    const store::JournalContent after = store::read_journal(path);
    EXPECT_GT(after.records.size(), before.records.size());
    expect_records(after, after.records.size());
  }
}

TEST(StepKey, IsOrderedByKindThenFlexionThenVarus)
{
  const StepKey probe{StepKind::spine_probe, 5, 5}, spine{StepKind::spine, 1, 9}, row{StepKind::row, 0, 0};
  EXPECT_LT(probe, spine);
  EXPECT_LT(spine, row);
  EXPECT_LT((StepKey{StepKind::row, 0, 9}), (StepKey{StepKind::row, 1, 0}));
  EXPECT_LT((StepKey{StepKind::row, 1, 0}), (StepKey{StepKind::row, 1, 1}));
}

}  // namespace vrda::journal_test
