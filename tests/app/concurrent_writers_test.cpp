// Two commands on one motion model, and outputs that would replace another result.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstring>
#include <random>
#include <set>

#include "app/scenes.hpp"
#include "core/files.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"

namespace vrda::two_writers_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

/// A command and a check of what it adds.
struct Change {
  std::vector<std::string> words;  ///< the file is inserted after the first
  bool (*is_in)(const store::MotionModel& model);
};

bool has_degree(const store::MotionModel& model, int degree)
{
  return std::any_of(model.smoothed.begin(), model.smoothed.end(),
                     [=](const store::SmoothedSet& set) { return set.degree == degree; });
}

const std::vector<Change> changes{
    {{"smooth", "--degree", "1"}, [](const store::MotionModel& model) { return has_degree(model, 1); }},
    {{"smooth", "--degree", "2"}, [](const store::MotionModel& model) { return has_degree(model, 2); }},
    {{"audit", "--set", "raw", "--refine", "1"},
     [](const store::MotionModel& model) { return !model.audits.empty(); }},
    {{"reduce"}, [](const store::MotionModel& model) { return model.zero_varus.has_value(); }},
};

test::Command command_of(const Change& change, const fs::path& file)
{
  std::vector<std::string> words = change.words;
  words.insert(words.begin() + 1, file.string());
  return test::vrda(words);
}

/// The small knee without the additions of these commands.
fs::path bare_model(const test::Scratch& scratch)
{
  const fs::path file = scratch.path() / "bare.h5";
  const test::Ended ended =
      test::run_vrda({"run", test::small_knee_job(scratch, "right").string(), "-o", file.string(), "--set",
                      "smooth.degrees=[]", "--progress", "none"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  store::MotionModel model = store::read_motion_model(file.string());
  model.zero_varus.reset();
  store::write_motion_model(file.string(), model);
  return file;
}

TEST(TwoWriters, NoCommittedChangeIsLostInInterleavingsAndKills)
{
  const test::Scratch scratch;
  const fs::path bare = bare_model(scratch), file = scratch.path() / "m.h5";
  const store::MotionModel raw = store::read_motion_model(bare.string());
  std::mt19937 random(20261122);
  const auto any_of = [&](int n) { return std::uniform_int_distribution<int>(0, n - 1)(random); };
  int n_both = 0, n_killed = 0;
  const int n_trials = test::runs_full_set() ? 200 : 50;
  for (int trial = 0; trial < n_trials; ++trial) {
    SCOPED_TRACE(trial);
    fs::copy_file(bare, file, fs::copy_options::overwrite_existing);
    const int first = any_of(4), second = (first + 1 + any_of(3)) % 4;
    const bool is_killed = any_of(3) == 0;
    test::Process one(command_of(changes[static_cast<std::size_t>(first)], file));
    usleep(static_cast<useconds_t>(any_of(30000)));
    test::Process other(command_of(changes[static_cast<std::size_t>(second)], file));
    if (is_killed) {
      usleep(static_cast<useconds_t>(any_of(40000)));
      one.send(SIGKILL);
    }
    const test::Ended one_ended = one.wait(), other_ended = other.wait();
    ASSERT_EQ(other_ended.exit_code, 0) << other_ended.err;
    ASSERT_THAT(store::validate_hdf5(file.string()), IsEmpty());
    const store::MotionModel model = store::read_motion_model(file.string());
    EXPECT_EQ(0, std::memcmp(model.X_reference_moving.data(), raw.X_reference_moving.data(),
                             raw.X_reference_moving.size() * sizeof(double)));
    EXPECT_TRUE(changes[static_cast<std::size_t>(second)].is_in(model));
    const bool is_first_done = one_ended.exit_code == 0;
    EXPECT_TRUE(!is_first_done || changes[static_cast<std::size_t>(first)].is_in(model)) << "lost";
    EXPECT_TRUE(is_first_done || is_killed) << one_ended.err;
    n_both += is_first_done ? 1 : 0;
    n_killed += is_first_done ? 0 : 1;
  }
  EXPECT_GE(n_both, 3 * n_trials / 10);
  EXPECT_GE(n_killed, n_trials / 10);
  // The last writer has removed the files of killed ones.
  for (const auto& entry : fs::directory_iterator(scratch.path()))
    EXPECT_THAT(entry.path().filename().string(), testing::Not(HasSubstr(".partial")));
}

TEST(TwoWriters, TwoMergesOfWhichOneIsKilledLoseNothing)
{
  const test::Scratch scratch;
  const fs::path folder = scratch.path() / "whole", output = folder / "m.h5";
  const std::string job = test::small_knee_job(scratch, "right").string();
  fs::create_directory(folder);
  for (const std::string shard : {"1/2", "2/2"}) {
    const test::Ended ended =
        test::run_vrda({"run", job, "-o", output.string(), "--shard", shard, "--progress", "none"});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
  }
  ASSERT_EQ(test::run_vrda({"merge", "-o", output.string(), "--keep"}).exit_code, 0);
  const std::string wanted = test::read_bytes(output);
  fs::remove(output);
  std::mt19937 random(5);
  for (int trial = 0; trial < (test::runs_full_set() ? 40 : 8); ++trial) {
    SCOPED_TRACE(trial);
    const fs::path copy = scratch.path() / "copy";
    fs::remove_all(copy);
    fs::copy(folder, copy, fs::copy_options::recursive);
    const test::Command merge = test::vrda({"merge", "-o", (copy / "m.h5").string()});
    test::Process one(merge), other(merge);
    usleep(std::uniform_int_distribution<useconds_t>(0, 60000)(random));
    one.send(SIGKILL);
    one.wait();
    EXPECT_EQ(other.wait().exit_code, 0);
    EXPECT_EQ(test::read_bytes(copy / "m.h5"), wanted);
  }
}

TEST(TwoWriters, TheSecondSaysWhomItWaitsFor)
{
  const test::Scratch scratch;
  const fs::path file = bare_model(scratch);
  std::optional<OutputLock> lock = OutputLock::acquire(file.string(), "vrda run", {});
  test::Process waiting(command_of(changes[0], file));
  while (waiting.is_running() && waiting.said().find("waiting for") == std::string::npos) usleep(5000);
  EXPECT_THAT(waiting.said(), test::reports(file.string(), {"vrda run", std::to_string(getpid())}));
  EXPECT_TRUE(waiting.is_running());
  lock.reset();
  EXPECT_EQ(waiting.wait().exit_code, 0);
}

TEST(TwoWriters, ModeAndLinkOfAModelStay)
{
  const test::Scratch scratch;
  const fs::path file = bare_model(scratch), link = scratch.path() / "link.h5";
  fs::create_symlink(file.filename(), link);
  ASSERT_EQ(chmod(file.c_str(), 0600), 0);
  for (const Change& change : changes) {
    SCOPED_TRACE(change.words.front());
    ASSERT_EQ(test::run(command_of(change, link)).exit_code, 0);
    EXPECT_TRUE(fs::is_symlink(link));
    EXPECT_EQ(fs::status(file).permissions(), fs::perms(0600));
    EXPECT_TRUE(change.is_in(store::read_motion_model(file.string())));
  }
  ASSERT_EQ(chmod(file.c_str(), 0400), 0);
  const std::string before = test::read_bytes(file);
  for (const Change& change : changes) {
    EXPECT_THAT(test::run(command_of(change, link)), test::refuses({"link.h5", "", "write permission"}));
  }
  EXPECT_EQ(test::read_bytes(file), before);
}

/// `vrda run` of a small knee to m.h5.
test::Ended run_small(const test::Scratch& scratch, const std::vector<std::string>& more)
{
  return test::run_vrda({"run", test::small_knee_job(scratch, "right").string(), "-o",
                         (scratch.path() / "m.h5").string(), "--progress", "none"},
                        more);
}

TEST(ExistingResult, AnotherJobIsRefusedWithTheFirstKeyThatDiffers)
{
  const test::Scratch scratch;
  const fs::path file = scratch.path() / "m.h5";
  ASSERT_EQ(run_small(scratch, {}).exit_code, 0);
  ASSERT_EQ(test::run(command_of(changes[0], file)).exit_code, 0);
  const std::string before = test::read_bytes(file);
  const std::vector<std::string> other{"--set", "solver.search.translation_step_mm=2", "--set",
                                       "title=other"};
  for (const std::vector<std::string>& part :
       {std::vector<std::string>{}, {"--fresh"}, {"--spine"}, {"--shard", "1/2"}}) {
    std::vector<std::string> words = other;
    words.insert(words.end(), part.begin(), part.end());
    const test::Ended ended = run_small(scratch, words);
    EXPECT_THAT(
        ended,
        test::refuses(
            {"m.h5", "output", {"solver.search.translation_step_mm", "1", "2", "\"other\""}, "--replace"}));
    EXPECT_EQ(test::read_bytes(file), before);
  }
  std::vector<std::string> words = other;
  words.emplace_back("--replace");
  EXPECT_EQ(run_small(scratch, words).exit_code, 0);
  EXPECT_EQ(store::read_motion_model(file.string()).title, "other");
}

TEST(ExistingResult, TheSameJobIsFinishedAndKeepsWhatWasAdded)
{
  const test::Scratch scratch;
  const fs::path file = scratch.path() / "m.h5";
  ASSERT_EQ(run_small(scratch, {}).exit_code, 0);
  const std::string raw = test::read_bytes(file);
  ASSERT_EQ(test::run(command_of(changes[0], file)).exit_code, 0);
  const std::string before = test::read_bytes(file);
  const test::Ended again = run_small(scratch, {});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_THAT(again.err, test::reports(file.string(), "--fresh"));
  EXPECT_EQ(test::read_bytes(file), before);
  EXPECT_EQ(run_small(scratch, {"--fresh"}).exit_code, 0);
  EXPECT_EQ(test::read_bytes(file), raw);
}

TEST(ExistingResult, OtherContentOfAnInputIsAnotherJob)
{
  const test::Scratch scratch;
  ASSERT_EQ(run_small(scratch, {}).exit_code, 0);
  const std::string job = test::small_knee_job(scratch, "right").string();
  std::set<std::string> meshes;
  for (const auto& entry : fs::directory_iterator(scratch.path()))
    if (entry.path().extension() == ".stl") meshes.insert(entry.path().filename());
  ASSERT_FALSE(meshes.empty());
  std::string bytes = test::read_bytes(scratch.path() / *meshes.begin());
  bytes[0] = bytes[0] == 'x' ? 'y' : 'x';  // in the comment at the start of the STL file
  scratch.write(*meshes.begin(), bytes);
  EXPECT_THAT(test::run_vrda({"run", job, "-o", (scratch.path() / "m.h5").string(), "--progress", "none"}),
              test::refuses({"m.h5", "output", *meshes.begin()}));
}

TEST(ExistingResult, AFileThatIsNoModelIsNeverReplaced)
{
  const test::Scratch scratch;
  const fs::path file = scratch.path() / "m.h5";
  ASSERT_EQ(run_small(scratch, {"--trace"}).exit_code, 0);
  fs::rename(scratch.path() / "m.trace.h5", file);  // HDF5, but not a motion model
  const std::string before = test::read_bytes(file);
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--replace"}, {"--fresh"}}) {
    EXPECT_THAT(run_small(scratch, more), test::refuses({"m.h5", "output", "motion model"}));
  }
  EXPECT_EQ(test::read_bytes(file), before);
}

TEST(ExistingResult, AFailedExportLeavesTheFileThatWasThere)
{
  const test::Scratch scratch;
  const fs::path file = bare_model(scratch), table = scratch.write("k.csv", "a,b\n1,2\n");
  ASSERT_EQ(chmod(table.c_str(), 0400), 0);
  EXPECT_THAT(test::run_vrda({"export", file.string(), "--to", "csv", "-o", table.string()}),
              test::refuses({"k.csv", "", "write permission"}));
  EXPECT_EQ(test::read_bytes(table), "a,b\n1,2\n");
}

}  // namespace vrda::two_writers_test
