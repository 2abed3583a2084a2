// Motion models that announce gigabytes in a few bytes, and outputs that take nothing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/scenes.hpp"
#include "store/motion_model.hpp"
#include "support/damaged_models.hpp"
#include "support/messages.hpp"

namespace vrda::bad_files_test {

namespace fs = std::filesystem;

// A gigabyte; a run of the small job needs about forty megabytes.
constexpr long absurd_kb = 1L << 20;

class BadFiles : public testing::Test {
 protected:
  test::Scratch scratch_;
  fs::path job_ = test::small_job(scratch_);
  fs::path output_ = scratch_.path() / "out.h5";
};

TEST_F(BadFiles, MotionModelsThatPromiseGigabytes)
{
  ASSERT_EQ(test::run_vrda({"run", job_.string(), "-o", output_.string(), "--quiet"}).exit_code, 0);
  for (const char* damage : {"gigabytes_of_vertices", "contacts_beyond_an_index"}) {
    const std::string file = test::damaged_copy(output_, scratch_.path(), damage);
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"info", file}, {"info", file, "--json"}, {"validate", file}}) {
      SCOPED_TRACE(words[0] + " " + file);
      const test::Ended ended = test::run_vrda(words);
      EXPECT_EQ(ended.exit_code, 2);
      // validate lists findings as data; the others print one message.
      EXPECT_EQ(test::n_lines(ended.err), words[0] == "info" ? 1 : 0) << ended.err;
      EXPECT_THAT(ended.err + ended.out, test::reports(file, "wanted"));
      EXPECT_LT(ended.peak_kb, absurd_kb);
    }
  }
}

// Runs `vrda` in a shell with redirected standard output.
test::Ended with_output(const std::string& words, const std::string& redirection)
{
  return test::run({"/bin/sh", {"-c", "exec '" VRDA_PROGRAM "' " + words + " " + redirection}, {}, {}});
}

TEST_F(BadFiles, StandardOutputThatTakesNothing)
{
  ASSERT_EQ(test::run_vrda({"run", job_.string(), "-o", output_.string(), "--quiet"}).exit_code, 0);
  const std::string job = "'" + job_.string() + "'", model = "'" + output_.string() + "'";
  for (const std::string& words :
       {"check " + job, "check --json " + job, "info " + model, "info --json " + model,
        "validate --quiet --json " + model,
        "shape hip -o '" + (scratch_.path() / "hip").string() + "' --quiet", std::string("--help"),
        std::string("run --help"), std::string("--version")}) {
    for (const std::string redirection : {">/dev/full", ">&-"}) {
      SCOPED_TRACE(words + redirection);
      const test::Ended ended = with_output(words, redirection);
      EXPECT_THAT(ended, test::refuses({.file = "standard output"}));
      EXPECT_EQ(test::n_lines(ended.err), 1);
    }
  }
}

TEST_F(BadFiles, AClosedStandardOutputNeverEndsUpInAFile)
{
  const test::Ended ended =
      with_output("run '" + job_.string() + "' -o '" + output_.string() + "' --quiet", "<&- >&-");
  EXPECT_THAT(ended, test::refuses({.file = "standard output"}));
  EXPECT_THAT(store::validate_hdf5(output_.string()), testing::IsEmpty());
}

TEST_F(BadFiles, OutputsWithoutRoomAreNamed)
{
  // The output name is a link to /dev/full.
  const fs::path folder = scratch_.path() / "parts";
  fs::create_directory(folder);
  fs::create_symlink("/dev/full", folder / "head.stl");
  fs::create_symlink("/dev/full", folder / "ball.ply");
  fs::create_symlink("/dev/full", folder / "job.toml");
  scratch_.write("knee.cfg", "MODEL 0 femur\nMODEL 1 tibmen\n");
  const std::string ball = (scratch_.path() / "ball.stl").string();
  const std::vector<std::pair<std::vector<std::string>, std::string>> rows{
      {{"shape", "hip", "-o", folder.string(), "--quiet"}, "head.stl"},
      {{"convert", "mesh", ball, (folder / "ball.ply").string()}, "ball.ply"},
      {{"convert", "config", (scratch_.path() / "knee.cfg").string(), "-o", (folder / "job.toml").string()},
       "job.toml"}};
  for (const auto& [words, file] : rows) {
    const test::Ended ended = test::run_vrda(words);
    EXPECT_THAT(ended, test::refuses({(folder / file).string(), "", "No space left"}));
    EXPECT_EQ(test::n_lines(ended.err), 1) << ended.err;
  }
}

}  // namespace vrda::bad_files_test
