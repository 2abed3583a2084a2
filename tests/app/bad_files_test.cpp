// Motion models that cannot be used, and outputs that take nothing: one line, exit code 2, nothing written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/scenes.hpp"
#include "store/journal.hpp"
#include "store/motion_model.hpp"
#include "support/damaged_models.hpp"
#include "support/messages.hpp"

namespace vrda::bad_files_test {

namespace fs = std::filesystem;
using testing::AnyOf;

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

TEST_F(BadFiles, AJournalOfAnotherJobIsKeptUntilFresh)
{
  const fs::path journal = output_.string() + ".journal";
  store::JournalWriter::create(journal.string(), std::string(64, 'a')).close();
  const std::string before = test::read_bytes(journal);
  test::expect_run_refused(job_, output_, {"out.h5.journal", "key", std::string(64, 'a'), "--fresh"});
  EXPECT_EQ(test::read_bytes(journal), before);
  EXPECT_EQ(test::run_vrda({"run", job_.string(), "-o", output_.string(), "--fresh"}).exit_code, 0);
}

class UnusableModels : public testing::Test {
 protected:
  std::string solved(const std::string& name, const std::vector<std::string>& more, int exit_code)
  {
    const std::string file = (scratch_.path() / name).string();
    std::vector<std::string> words{"run", test::small_knee_job(scratch_, "right").string(), "-o", file};
    words.insert(words.end(), more.begin(), more.end());
    EXPECT_EQ(test::run_vrda(words).exit_code, exit_code);
    return file;
  }

  void expect_refused(const std::string& file, const testing::Matcher<const test::Ended&>& refusal) const
  {
    const std::string output = (scratch_.path() / "output").string(), before = test::sha256_of_file(file);
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"smooth", file, "--degree", "2"},
          {"smooth", file, "--degree", "2", "--recontact"},
          {"audit", file},
          {"compare", file},
          {"compare", file, "--recontact", "--json"},
          {"reduce", file},
          {"reduce", file, "--json"},
          {"report", file, "-o", output},
          {"report", whole_, file, "-o", output},
          {"export", file, "--to", "sto", "-o", output + ".sto"},
          {"export", file, "--to", "mot", "-o", output + ".mot"},
          {"export", file, "--to", "csv", "-o", output + ".csv"},
          {"export", file, "--to", "csv", "--full", "-o", output + ".csv"},
          {"export", file, "--to", "gltf", "-o", output + ".glb"},
          {"export", file, "--to", "vtk", "-o", output + ".pvd"}}) {
      SCOPED_TRACE(testing::PrintToString(words));
      const test::Ended ended = test::run_vrda(words);
      EXPECT_THAT(ended, refusal);
      EXPECT_EQ(ended.out, "");
      EXPECT_EQ(test::n_lines(ended.err), 1) << ended.err;
      EXPECT_FALSE(test::printed_facts(ended.err).wanted.empty()) << ended.err;
    }
    EXPECT_EQ(test::sha256_of_file(file), before);
    for (const fs::directory_entry& entry : fs::directory_iterator(scratch_.path()))
      EXPECT_NE(entry.path().stem(), "output") << entry.path();
  }

  test::Scratch scratch_;
  std::string whole_ = solved("whole.h5", {}, 0);
};

TEST_F(UnusableModels, Damaged)
{
  const std::string bytes = test::text_of(whole_);
  expect_refused(scratch_.write("half.h5", bytes.substr(0, bytes.size() / 2)).string(),
                 test::refuses({.file = "half.h5", .found = "truncated"}));
  struct Row {
    const char *damage, *field;
  };
  for (const Row& row : {Row{"newer_format", "/@format_version"}, Row{"no_clinical", "/clinical"},
                         Row{"no_bodies", "/bodies"}, Row{"no_job", "/job"}}) {
    SCOPED_TRACE(row.damage);
    expect_refused(test::damaged_copy(whole_, scratch_.path(), row.damage),
                   test::refuses({std::string(row.damage) + ".h5", row.field}));
  }
}

TEST_F(UnusableModels, OfObjectsThatNeverMet)
{
  const std::vector<std::string> apart{"--set", "moving.initial.translation_mm=[500, -40, 0]"};
  const auto names = [](const char* field) { return test::refuses({"apart.h5", field}); };
  expect_refused(
      solved("apart.h5", apart, 3),
      AnyOf(test::refuses({"apart.h5", "/status", {"35", "no_contact"}}), names("status"), names("raw"),
            names("contact_medial, contact_lateral, gap_medial_mm, gap_lateral_mm")));
}

}  // namespace vrda::bad_files_test
