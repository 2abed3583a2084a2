// User errors on the command line: one message, the right exit code, nothing lost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/scenes.hpp"
#include "store/journal.hpp"
#include "support/messages.hpp"

namespace vrda::bad_input_test {

namespace fs = std::filesystem;

class BadInput : public testing::Test {
 protected:
  test::Scratch scratch_;
  fs::path job_ = test::small_job(scratch_);
  fs::path output_ = scratch_.path() / "out.h5";
};

TEST_F(BadInput, KeysWithoutEffectAreNamed)
{
  const test::Ended ended = test::run_vrda({"check", job_.string(), "--set", "push.force_n=50"});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.out, test::warns("push.force_n"));
  EXPECT_THAT(test::run_vrda({"check", job_.string()}).out, testing::Not(test::warns("push.force_n")));
}

TEST_F(BadInput, NothingAlongDeltaIsAWarning)
{
  const test::Ended ended =
      test::run_vrda({"check", job_.string(), "--set", "moving.initial.translation_mm=[500, 0, 0]"});
  EXPECT_THAT(ended.out, test::warns("push.delta"));
}

TEST_F(BadInput, AJournalOfAnotherJobIsKeptUntilFresh)
{
  const fs::path journal = output_.string() + ".journal";
  store::JournalWriter::create(journal.string(), std::string(64, 'a')).close();
  const std::string before = test::read_bytes(journal);
  test::expect_run_refused(job_, output_, {"out.h5.journal", "key", std::string(64, 'a'), "--fresh"});
  EXPECT_EQ(test::read_bytes(journal), before);
  EXPECT_EQ(test::run_vrda({"run", job_.string(), "-o", output_.string(), "--fresh"}).exit_code, 0);
}

}  // namespace vrda::bad_input_test
