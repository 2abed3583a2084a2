// Polling a growing journal in every state.
#include "core/framed_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "store/journal.hpp"
#include "support/scratch.hpp"

namespace vrda::frame_tail_test {

const std::string key(64, 'a');
const std::string other_key(64, 'b');

StepRecord record(int n, int n_contacts = 2)
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
  for (int n = first; n <= last; ++n) frames.push_back(core::bytes_of_value(record(n, n_contacts)));
  return frames;
}

class Tail : public testing::Test {
 protected:
  store::JournalWriter fresh(int n_records, const std::string& its_key = key, int n_contacts = 2)
  {
    store::JournalWriter writer = store::JournalWriter::create(path_, its_key);
    for (int n = 0; n < n_records; ++n) writer.append(record(n, n_contacts));
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

TEST_F(Tail, EveryRecordIsReadOnceAsItComes)
{
  EXPECT_FALSE(tail_.poll().file_exists);
  store::JournalWriter writer = fresh(0);
  expect(tail_.poll(), false, {});
  EXPECT_EQ(tail_.key(), key);
  for (int n = 0; n < 5; ++n) {
    writer.append(record(n));
    expect(tail_.poll(), false, frames_of(n, n));
    expect(tail_.poll(), false, {});
  }
  writer.append(record(5));
  writer.append(record(6));
  expect(tail_.poll(), false, frames_of(5, 6));
}

TEST_F(Tail, ATornRecordIsReadWhenItIsWhole)
{
  fresh(3).close();
  const std::string bytes = test::read_bytes(path_);
  const std::size_t frame_bytes = core::frame_head_bytes + core::bytes_of_value(record(0)).size();
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
  writer.append(record(2));
  expect(tail_.poll(), false, frames_of(2, 2));
}

TEST_F(Tail, AFileCutBelowTheLastPollIsReadAgain)
{
  fresh(4).close();
  expect(tail_.poll(), false, frames_of(0, 3));
  const std::size_t frame_bytes = core::frame_head_bytes + core::bytes_of_value(record(0)).size();
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 2 * frame_bytes);
  expect(tail_.poll(), true, frames_of(0, 1));
  {
    store::JournalWriter writer = std::move(store::JournalWriter::open(path_, key).writer);
    writer.append(record(2));
    expect(tail_.poll(), false, frames_of(2, 2));
  }
  // Cut and grown beyond the previous length between two polls.
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) - 2 * frame_bytes);
  {
    store::JournalWriter writer = std::move(store::JournalWriter::open(path_, key).writer);
    for (int n = 7; n < 10; ++n) writer.append(record(n));
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

TEST_F(Tail, AnotherFileIsReported)
{
  scratch_.write("knee.h5.journal", std::string(200, 'x'));
  EXPECT_EQ(tail_.poll().invalid_reason, "not a journal (200 bytes)");
  std::filesystem::remove(path_);
  std::filesystem::create_directory(path_);
  EXPECT_FALSE(tail_.poll().file_exists);
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
  writer.append(record(1000, 100000));
  expect(tail_.poll(), false, frames_of(1000, 1000, 100000));
}

}  // namespace vrda::frame_tail_test
