// Loss of storage during a run: a full disk, a removed folder. One message, exit code 2, and the same command
// resumes from the solved steps. tests/faults has a full disk at every write.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "store/journal.hpp"
#include "store/trace.hpp"
#include "support/messages.hpp"
#include "support/small_disk.hpp"

namespace vrda::lost_ground_test {

namespace fs = std::filesystem;

class LostGround : public testing::Test {
 protected:
  LostGround()
  {
    fs::create_directories(folder_);
    const fs::path whole = scratch_.path() / "whole.h5";
    EXPECT_EQ(test::run_vrda({"run", job_, "-o", whole.string(), "--quiet", "--trace"}).exit_code, 0);
    undisturbed_ = test::sha256_of_file(whole);
    undisturbed_trace_ = test::sha256_of_file(store::trace_name(whole.string()));
  }

  std::vector<std::string> command() const
  {
    std::vector<std::string> words{"run", job_, "-o", output_.string(), "--quiet"};
    if (is_traced_) words.emplace_back("--trace");
    return words;
  }
  std::size_t n_steps_kept() const { return store::read_journal(journal_.string()).records.size(); }

  /// Repeats the command: it must reuse `n_kept` steps and give the bytes of an undisturbed run.
  void expect_resumed(std::size_t n_kept) const
  {
    const test::Ended ended = test::run_vrda(command());
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    const auto record = nlohmann::json::parse(test::read_bytes(output_.string() + ".run.json"));
    EXPECT_EQ(record.at("steps_recalled"), n_kept);
    expect_undisturbed();
  }

  void expect_undisturbed() const
  {
    EXPECT_EQ(test::sha256_of_file(output_), undisturbed_);
    EXPECT_FALSE(fs::exists(journal_));
    EXPECT_EQ(is_traced_ ? test::sha256_of_file(store::trace_name(output_.string())) : undisturbed_trace_,
              undisturbed_trace_);
  }

  /// Starts the command and lets it solve some steps.
  void start(std::unique_ptr<test::Process>& process) const
  {
    process = std::make_unique<test::Process>(test::vrda(command()));
    test::wait_for_bytes(*process, journal_, 5000);
    ASSERT_TRUE(process->is_running()) << "ended before storage was lost";
  }

  /// Stops the run during the loss, so that the loss does not affect files it restores.
  static test::Ended ended_after(test::Process& process, const std::function<void()>& lose_ground)
  {
    process.send(SIGSTOP);
    lose_ground();
    process.send(SIGCONT);
    return process.wait();
  }

  static void expect_one_message(const test::Ended& ended)
  {
    EXPECT_EQ(ended.exit_code, 2);
    EXPECT_EQ(test::n_lines(ended.err), 1) << ended.err;
    EXPECT_EQ(ended.out, "");
  }

  test::Scratch scratch_;
  std::string job_ = test::longer_knee_job(scratch_).string();
  fs::path folder_ = scratch_.path() / "out" / "deep";
  fs::path output_ = folder_ / "knee.h5";
  fs::path journal_ = folder_ / "knee.h5.journal";
  std::string undisturbed_;
  std::string undisturbed_trace_;
  bool is_traced_ = false;
};

TEST_F(LostGround, AJournalThatMeetsAFullDiskMidRunGoesOnWhenThereIsRoom)
{
  if (!test::mount_refusal().empty()) GTEST_SKIP() << "a separate disk, missing: " << test::mount_refusal();
  // The ballast leaves space for the start file only.
  test::SmallDisk disk(folder_, 4 << 20);
  std::unique_ptr<test::Process> process;
  start(process);
  std::ofstream(folder_ / "ballast") << std::string(4 << 20, 'x');
  const test::Ended ended = process->wait();
  expect_one_message(ended);
  EXPECT_THAT(ended, test::refuses({journal_.string(), "", "No space left"}));
  const std::size_t n_kept = n_steps_kept();
  EXPECT_GT(n_kept, 10u);
  fs::remove(folder_ / "ballast");
  expect_resumed(n_kept);
}

TEST_F(LostGround, AModelThatIsReplacedStaysWhenTheNewOneDoesNotFit)
{
  if (!test::mount_refusal().empty()) GTEST_SKIP() << "a separate disk, missing: " << test::mount_refusal();
  test::SmallDisk disk(folder_, 4 << 20);
  ASSERT_EQ(test::run_vrda(command()).exit_code, 0);
  std::ofstream(folder_ / "ballast") << std::string(4 << 20, 'x');
  std::vector<std::string> words = command();
  words.emplace_back("--fresh");
  expect_one_message(test::run_vrda(words));
  EXPECT_EQ(test::sha256_of_file(output_), undisturbed_);
}

TEST_F(LostGround, AFolderThatIsDeletedComesBackWithTheJournals)
{
  for (const bool is_traced : {false, true}) {
    SCOPED_TRACE(is_traced);
    is_traced_ = is_traced;
    std::unique_ptr<test::Process> process;
    start(process);
    const test::Ended ended = ended_after(*process, [&] { fs::remove_all(scratch_.path() / "out"); });
    expect_one_message(ended);
    EXPECT_THAT(ended, test::refuses({output_.string(), "folder", "deleted"}));
    const std::size_t n_kept = n_steps_kept();
    EXPECT_GT(n_kept, 10u);
    EXPECT_TRUE(test::names_value(ended.err, std::to_string(n_kept) + " steps")) << ended.err;
    expect_resumed(n_kept);
  }
}

TEST_F(LostGround, AFolderThatIsMovedLeavesItsStepsInBothPlaces)
{
  std::unique_ptr<test::Process> process;
  start(process);
  fs::rename(scratch_.path() / "out", scratch_.path() / "elsewhere");
  expect_one_message(process->wait());
  const std::size_t n_kept = n_steps_kept();
  EXPECT_EQ(store::read_journal((scratch_.path() / "elsewhere/deep/knee.h5.journal").string()).records.size(),
            n_kept);
  expect_resumed(n_kept);
}

TEST_F(LostGround, WhereNothingCanBePutBackTheMessageSaysSo)
{
  // A file replaces the folder; another journal replaces the journal.
  for (const bool is_folder_blocked : {true, false}) {
    std::unique_ptr<test::Process> process;
    start(process);
    const test::Ended ended = ended_after(*process, [&] {
      fs::remove_all(scratch_.path() / "out");
      scratch_.write(is_folder_blocked ? "out" : "out/deep/knee.h5.journal", "in the way");
    });
    expect_one_message(ended);
    EXPECT_THAT(ended.err, test::reports("folder", {"deleted", "lost", journal_.string()}));
    EXPECT_EQ(test::read_bytes(is_folder_blocked ? scratch_.path() / "out" : journal_), "in the way");
    fs::remove_all(scratch_.path() / "out");
    fs::create_directories(folder_);
  }
}

}  // namespace vrda::lost_ground_test
