#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <memory>

#include "app/scenes.hpp"
#include "run/campaign.hpp"
#include "run/submission.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"

namespace vrda::shard_test {

namespace fs = std::filesystem;
using testing::IsEmpty;

// A knee of two balls, 7 flexions x 5 varus angles.
class Shards : public testing::TestWithParam<const char*> {
 protected:
  // Equilibrium without ligaments: the rotation is not constrained.
  static std::ptrdiff_t n_warnings() { return GetParam() == std::string("equilibrium") ? 1 : 0; }

  test::Ended part(const std::vector<std::string>& words) { return test::run_vrda(run_words(words)); }

  std::vector<std::string> run_words(const std::vector<std::string>& more) const
  {
    std::vector<std::string> words{
        "run", job_.string(), "-o", output_.string(), "--set", std::string("solver.method=") + GetParam()};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  std::string whole_run()
  {
    const fs::path whole = scratch_.path() / "whole.h5";
    EXPECT_EQ(test::run_vrda({"run", job_.string(), "-o", whole.string(), "--set",
                              std::string("solver.method=") + GetParam()})
                  .exit_code,
              0);
    return test::sha256_of_file(whole);
  }

  void run_shards(int count)
  {
    for (int number = 1; number <= count; ++number) {
      const test::Ended ended = part({"--shard", std::to_string(number) + "/" + std::to_string(count)});
      EXPECT_EQ(ended.exit_code, 0) << ended.err;
      EXPECT_EQ(ended.out, store::shard_journal_of(output_, {number, count}) + "\n");
    }
  }

  test::Ended merge(const std::vector<std::string>& more = {})
  {
    return test::run_vrda({"merge", "-o", output_.string()}, more);
  }

  std::vector<std::string> files() const
  {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(output_.parent_path()))
      names.push_back(entry.path().filename());
    return names;
  }

  test::Scratch scratch_;
  fs::path job_ = test::small_knee_job(scratch_, "right");
  fs::path output_ = scratch_.path() / "out" / "knee.h5";
};

/// What does not depend on the method.
class ShardsOneWay : public Shards {};

TEST_P(Shards, AnyNumberOfThemGivesTheBytesOfOneRun)
{
  const std::string wanted = whole_run();
  // Of 7 rows.
  for (const int count : test::runs_full_set() ? std::vector{1, 2, 7, 10} : std::vector{2, 10}) {
    SCOPED_TRACE(count);
    EXPECT_EQ(part({"--spine"}).exit_code, 0);
    run_shards(count);
    const test::Ended merged = merge();
    EXPECT_EQ(merged.exit_code, 0) << merged.err;
    EXPECT_EQ(merged.out, output_.string() + "\n");
    EXPECT_EQ(test::sha256_of_file(output_), wanted);
    EXPECT_THAT(files(), testing::UnorderedElementsAre("knee.h5", "knee.h5.run.json"));
    const test::Ended again = merge();
    EXPECT_EQ(again.exit_code, 0) << again.err;
    EXPECT_THAT(again.err, test::reports(output_.string()));
    EXPECT_EQ(test::sha256_of_file(output_), wanted);
    fs::remove_all(output_.parent_path());
  }
}

TEST_P(ShardsOneWay, StartedAtOnceOneOfThemSolvesTheSpineForAll)
{
  const std::string wanted = whole_run();
  std::vector<std::unique_ptr<test::Process>> processes;
  for (int number = 1; number <= 4; ++number) {
    processes.push_back(
        std::make_unique<test::Process>(test::vrda(run_words({"--shard", std::to_string(number) + "/4"}))));
  }
  for (const auto& process : processes) {
    const test::Ended ended = process->wait();
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
  }
  const test::Ended merged = merge();
  EXPECT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_THAT(merged.err, testing::Not(test::reports("", store::shard_journal_of(output_, {1, 4}))));
  EXPECT_EQ(test::sha256_of_file(output_), wanted);
}

TEST_P(Shards, OneThatIsMissingIsNamedAndNothingIsLost)
{
  const std::string wanted = whole_run();
  run_shards(3);
  const std::string second = store::shard_journal_of(output_, {2, 3});
  fs::remove(second);
  const test::Ended refused = merge();
  EXPECT_EQ(test::n_lines(refused.err), 1 + n_warnings());
  // Rows 1 and 4 of 0 to 6; with the search the spine's journal contains their spine cells.
  const std::string n = GetParam() == std::string("stability-search") ? "8" : "10";
  EXPECT_THAT(refused,
              test::refuses({output_.string(), "journals", {n, "35", "flexion 2 and 8", "shard 2 of 3"}}));
  EXPECT_FALSE(fs::exists(output_));
  EXPECT_TRUE(fs::exists(store::shard_journal_of(output_, {1, 3})));

  const test::Ended again = part({"--shard", "2/3"});
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_EQ(merge().exit_code, 0);
  EXPECT_EQ(test::sha256_of_file(output_), wanted);
}

TEST_P(Shards, ASpineThatIsMissingIsNamed)
{
  run_shards(2);
  fs::remove(store::spine_journal_of(output_));
  const test::Ended refused = merge();
  EXPECT_EQ(test::n_lines(refused.err), 1 + n_warnings());
  // With the search the spine's journal also contains results.
  const bool is_search = GetParam() == std::string("stability-search");
  EXPECT_THAT(refused, test::refuses({output_.string(), "journals",
                                      is_search ? test::Values{"7", "35", "flexion 0", "spine"} : "spine"}));
}

TEST_P(ShardsOneWay, DuplicateStepsAreReportedAndDoNotChangeTheResult)
{
  const std::string wanted = whole_run();
  run_shards(2);
  const std::string copy = scratch_.path() / "copy.journal", first = store::shard_journal_of(output_, {1, 2});
  fs::copy_file(first, copy);
  // The copy, which does not record its owner, comes first.
  const test::Ended merged =
      merge({copy, store::spine_journal_of(output_), first, store::shard_journal_of(output_, {2, 2})});
  EXPECT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_THAT(merged.err, test::reports("", {"flexion 0, 4, 8 and 12", copy, first}));
  EXPECT_EQ(test::sha256_of_file(output_), wanted);
  EXPECT_TRUE(fs::exists(copy)) << "a copy elsewhere belongs to the user";
}

TEST_P(ShardsOneWay, JournalsOfAnotherJobAreRefused)
{
  run_shards(2);
  const std::string elsewhere = scratch_.path() / "other.h5";
  ASSERT_EQ(test::run_vrda({"run", job_.string(), "-o", elsewhere, "--set",
                            std::string("solver.method=") + GetParam(), "--set", "grid.varus.step=2.5",
                            "--shard", "1/2"})
                .exit_code,
            0);
  const test::Ended merged =
      merge({store::spine_journal_of(output_), store::shard_journal_of(output_, {1, 2}),
             store::shard_journal_of(elsewhere, {1, 2})});
  EXPECT_THAT(merged, test::refuses({"other.h5.shard-1-of-2.journal", "key", {"grid.varus.step", "2.5"}}));
  // The same for the journal that a run would resume.
  const test::Ended repeated = part({"--shard", "1/2", "--set", "grid.varus.step=2.5"});
  EXPECT_THAT(repeated, test::refuses({store::spine_journal_of(output_), "key", "grid.varus.step"}));
  EXPECT_FALSE(fs::exists(output_));
}

TEST_P(ShardsOneWay, ADamagedCaseFileIsNamed)
{
  run_shards(2);
  const std::string case_file = run::case_file_of(output_);
  test::edit(case_file, "solver.method", "solver.methud");
  const test::Ended merged = merge();
  EXPECT_THAT(merged,
              test::refuses({case_file + ": set", "solver.methud", "", {"\"solver.method\"", "--job"}}));
  EXPECT_EQ(test::n_lines(merged.err), 1);
  EXPECT_FALSE(test::names_value(merged.err, "--set"));
  const std::string whole = whole_run();
  EXPECT_EQ(merge({"--job", job_.string(), "--set", std::string("solver.method=") + GetParam()}).exit_code,
            0);
  EXPECT_EQ(test::sha256_of_file(output_), whole);
}

INSTANTIATE_TEST_SUITE_P(Methods, Shards, testing::Values("stability-search", "equilibrium"),
                         [](const auto& method) {
                           return std::string(method.param) == "equilibrium" ? "Equilibrium" : "Search";
                         });

INSTANTIATE_TEST_SUITE_P(Methods, ShardsOneWay, testing::Values("stability-search"));

TEST(ShardWords, TheJobOfAMergeMayBeNamed)
{
  const test::Scratch scratch;
  const std::string job = test::small_job(scratch), output = scratch.path() / "a.h5";
  ASSERT_EQ(test::run_vrda({"run", job, "-o", output, "--shard", "1/1"}).exit_code, 0);
  fs::remove(run::case_file_of(output));
  EXPECT_EQ(test::run_vrda({"merge", "-o", output}).exit_code, 2);
  const test::Ended merged = test::run_vrda({"merge", "-o", output, "--job", job, "--keep"});
  EXPECT_EQ(merged.exit_code, 0) << merged.err;
  EXPECT_TRUE(fs::exists(store::spine_journal_of(output)));
  EXPECT_THAT(store::validate_hdf5(output), IsEmpty());
}

}  // namespace vrda::shard_test
