// A submission of local processes, one of which is killed or fails: resumed, it gives the same bytes.
#include <gmock/gmock.h>

#include <fstream>

#include "app/scenes.hpp"
#include "faults/faulty_run.hpp"
#include "support/messages.hpp"

namespace vrda::test::submission_faults_test {

namespace fs = std::filesystem;

class SubmissionFaults : public FaultyRun {
 protected:
  Command submit() const
  {
    std::vector<std::string> words = command().arguments;  // run JOB -o ... --quiet --threads 1 --set ...
    words[0] = "submit";
    words[3] = folder_;
    words.erase(words.begin() + 5, words.begin() + 7);
    words.insert(words.end(), {"--shards", "2", "--local", "--workers", "1"});
    return vrda(words);
  }

  /// The remedy after a failure: the same command until there is a submission, then resume.
  Ended go_on() const
  {
    const bool is_submitted = fs::exists(folder_ / "submission.json");
    return test::run(is_submitted ? vrda({"resume", folder_, "--local", "--workers", "1", "--quiet"})
                                  : submit());
  }

  fs::path model() const { return folder_ / job_.stem() += ".h5"; }

  /// Only one process gets the fault, at its k-th such call.
  Ended disturbed(Command command, const Fault& fault) const
  {
    fs::remove(once_);
    command = with_fault(command, in_folder(fault));
    command.environment["VRDA_FAULT_ONCE"] = once_;
    return test::run(command);
  }

  /// Each of the faults at calls of any process of the command, which starts in a folder made by `put`; the
  /// remedy then makes the model.
  template <typename Put>
  void expect_resumable(const Command& command, const Put& put, const std::vector<std::string>& whats) const
  {
    put();
    // Of all processes together; a single one makes fewer.
    const int n = n_calls_of(command, in_folder({"count"}), scratch_.path() / "counts");
    expect_made();
    EXPECT_GT(n, 50);
    int n_disturbed = 0, n_refused = 0;
    for (const std::string& what : whats) {
      for (int k = 1; k <= n; k += runs_full_set() ? 1 : 7) {
        SCOPED_TRACE(what + " " + std::to_string(k));
        put();
        const Ended ended = disturbed(command, {what, "any", std::to_string(k)});
        if (!fs::exists(once_)) break;  // no process makes so many calls
        ++n_disturbed;
        EXPECT_NE(ended.exit_code, 5) << ended.err;
        EXPECT_TRUE(what != "short" || ended.exit_code == 0) << ended.err;
        n_refused += ended.exit_code == 2 ? 1 : 0;
        expect_goes_on();
      }
    }
    EXPECT_GT(n_disturbed, 12);
    EXPECT_GT(n_refused, 0);
  }

  void expect_goes_on() const
  {
    const Ended after = go_on();
    EXPECT_EQ(after.exit_code, 0) << after.err;
    expect_made();
  }

  void expect_made() const
  {
    EXPECT_TRUE(read_bytes(model()) == whole_run().after.at("a.h5"));
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      const std::string name = entry.path().filename();
      EXPECT_FALSE(name.ends_with(".partial") || name.ends_with(".journal") || name.ends_with(".start.h5"))
          << name;
    }
  }

  const fs::path once_ = scratch_.path() / "once";
};

TEST_P(SubmissionFaults, IsResumedAfterAnyProcessIsKilledOrFails)
{
  expect_resumable(submit(), [&] { fs::remove_all(folder_); }, {"kill", "torn", "eio"});
}

// The submission stopped at its half; a fault of any process of resume itself keeps the next one able to
// finish.
TEST_P(SubmissionFaults, IsResumedAfterAResumeIsKilledOrFails)
{
  fs::remove_all(folder_);
  const std::string spine = model().filename().string() + ".spine.journal";
  ASSERT_NE(disturbed(submit(), {"torn", "write", "3", spine}).exit_code, 0);
  const fs::path kept = scratch_.path() / "interrupted";
  fs::copy(folder_, kept, fs::copy_options::recursive);
  const auto put = [&] {
    fs::remove_all(folder_);
    fs::copy(kept, folder_, fs::copy_options::recursive);
  };
  expect_resumable(vrda({"resume", folder_, "--local", "--workers", "1", "--quiet"}), put,
                   {"kill", "torn", "eio", "enospc", "short"});
}

// All tasks but the merge are done; then a bit of a journal is flipped, or its end cut off.
TEST_P(SubmissionFaults, ADamagedJournalIsRepairedByResume)
{
  fs::remove_all(folder_);
  ASSERT_EQ(test::run(submit()).exit_code, 0);
  fs::remove(model());
  const auto task = [&](const std::vector<std::string>& words) {
    std::vector<std::string> all{"task", folder_, "--kind"};
    all.insert(all.end(), words.begin(), words.end());
    return test::run(vrda(all));
  };
  ASSERT_EQ(task({"spine"}).exit_code, 0);
  ASSERT_EQ(task({"shard", "--shard", "1"}).exit_code, 0);
  ASSERT_EQ(task({"shard", "--shard", "2"}).exit_code, 0);
  const fs::path kept = scratch_.path() / "kept";
  fs::copy(folder_, kept, fs::copy_options::recursive);
  for (const std::string which : {".spine.journal", ".shard-2-of-2.journal"}) {
    const std::string bytes = read_bytes(kept / (model().filename() += which));
    const std::size_t at = bytes.size() * 3 / 4;  // after the header, before the end of the last step
    std::string flipped = bytes;
    flipped[at] = static_cast<char>(flipped[at] ^ 16);
    for (const std::string& damaged : {flipped, bytes.substr(0, at)}) {
      SCOPED_TRACE(which + (damaged == flipped ? " flipped" : " cut"));
      fs::remove_all(folder_);
      fs::copy(kept, folder_, fs::copy_options::recursive);
      std::ofstream(model() += which, std::ios::binary) << damaged;
      const Ended merged = task({"merge"});
      EXPECT_EQ(merged.exit_code, 2) << merged.err;
      EXPECT_FALSE(fs::exists(model()));
      expect_goes_on();
    }
  }
}

TEST_P(SubmissionFaults, AFileSystemWithoutLocksIsReportedInOneLine)
{
  fs::remove_all(folder_);
  const Ended ended = test::run(with_fault(submit(), in_folder({"enolck", "lock", "1+", "submission.lock"})));
  EXPECT_EQ(n_lines(ended.err), 1) << ended.err;
  EXPECT_THAT(ended, refuses({"submission.lock", "", "No locks available", {"flock", "-o flock"}}));
  expect_goes_on();
}

// What a submission writes does not depend on the method; the search is faster here.
INSTANTIATE_TEST_SUITE_P(All, SubmissionFaults, testing::ValuesIn(untraced_or(search())), name_of);

}  // namespace vrda::test::submission_faults_test
