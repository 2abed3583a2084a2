// User errors on the command line: one message, the right exit code, nothing lost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include "app/scenes.hpp"
#include "journal/journal.hpp"

namespace vrda::bad_input_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

class BadInput : public testing::Test {
 protected:
  void expect_refused(const std::vector<std::string>& words) const
  {
    test::expect_refused(job_, output_, words);
  }

  test::Scratch scratch_;
  fs::path job_ = test::small_job(scratch_);
  fs::path output_ = scratch_.path() / "out.h5";
};

TEST_F(BadInput, MissingJob)
{
  const test::Ended ended = test::run_vrda({"run", "nowhere.toml"});
  EXPECT_EQ(ended.exit_code, 2);
  EXPECT_THAT(ended.err, HasSubstr("nowhere.toml"));
}

TEST_F(BadInput, MissingMesh)
{
  test::edit(job_, "ball.stl", "bal.stl");
  expect_refused({"bal.stl", "found", "wanted"});
}

TEST_F(BadInput, EmptyMesh)
{
  scratch_.write("ball.stl", "");
  expect_refused({"ball.stl", "found", "wanted"});
}

TEST_F(BadInput, TruncatedStl)
{
  const std::string bytes = test::read_bytes(scratch_.path() / "ball.stl");
  scratch_.write("ball.stl", bytes.substr(0, bytes.size() / 2));
  expect_refused({"ball.stl", "found", "wanted"});
}

TEST_F(BadInput, TruncatedPly)
{
  scratch_.write(
      "ball.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n");
  test::edit(job_, "ball.stl", "ball.ply");
  expect_refused({"ball.ply", "found", "wanted"});
}

TEST_F(BadInput, VerticesFacesCountsThatLie)
{
  scratch_.write("ball.obj", "4 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n");
  test::edit(job_, "ball.stl", "ball.obj");
  expect_refused({"ball.obj", "found", "wanted"});
}

TEST_F(BadInput, NanVertex)
{
  std::string bytes = test::read_bytes(scratch_.path() / "ball.stl");
  constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(bytes.data() + 84 + 12, &not_a_number, sizeof not_a_number);
  scratch_.write("ball.stl", bytes);
  expect_refused({"ball.stl", "found", "wanted"});
}

TEST_F(BadInput, LeftHandedAxes)
{
  test::edit(job_, "[reference]",
             "[frame]\nanterior = \"+X\"\nproximal = \"+Y\"\nright = \"-Z\"\n[reference]");
  expect_refused({"small.toml", "frame", "found", "wanted", "hand"});
}

TEST_F(BadInput, ReversedRange)
{
  test::edit(job_, "from = 0, to = 4", "from = 9, to = 4");
  expect_refused({"small.toml", "grid.flexion", "found", "wanted"});
}

TEST_F(BadInput, ZeroStep)
{
  test::edit(job_, "from = -4, to = 4, step = 2", "from = -4, to = 4, step = 0");
  expect_refused({"small.toml", "grid.varus", "found", "wanted"});
}

TEST_F(BadInput, UnknownKeyNamesTheNearest)
{
  test::edit(job_, "material = \"bone\"", "materiel = \"bone\"");
  expect_refused({"small.toml", "materiel", "material"});
}

TEST_F(BadInput, MissingLigamentFilesAreNamed)
{
  scratch_.write("fibres.csv", "name\n");
  const auto with = [&](const std::string& table) {
    test::edit(job_, "[smooth]", table + "\n[smooth]");
    expect_refused({"small.toml", "ligaments.", "no file", "wanted", "folder of the job"});
    const test::Ended check = test::run_vrda({"check", job_.string()});
    EXPECT_EQ(check.exit_code, 2);
    EXPECT_EQ(test::n_lines(check.err), 1) << check.err;
    test::edit(job_, table, "");
  };
  with("[ligaments]\nfibres = \"ligament.csv\"");
  with("[ligaments]\nfibres = \"fibres.csv\"\nwraps = \"wraps.json\"");
}

TEST_F(BadInput, LigamentFilesAreRefusedInOneLine)
{
  const std::string columns =
      "name,reference_x_mm,reference_y_mm,reference_z_mm,moving_x_mm,moving_y_mm,moving_z_mm,stiffness_n,"
      "slack_length_mm,wrap\n";
  test::edit(job_, "[smooth]", "[ligaments]\nfibres = \"fibres.csv\"\n[smooth]");
  const auto refused = [&](const std::string& table, const std::vector<std::string>& words) {
    SCOPED_TRACE(table);
    scratch_.write("fibres.csv", table);
    expect_refused(words);
    const test::Ended check = test::run_vrda({"check", job_.string()});
    EXPECT_EQ(check.exit_code, 2);
    EXPECT_EQ(test::n_lines(check.err), 1) << check.err;
  };
  refused("nmae,stiffness_n\n", {"fibres.csv", "line 1", "\"nmae\"", "\"name\""});
  refused(columns + "a,0,0,0,0,0,0,-1,30,\n", {"fibres.csv", "line 2, stiffness_n", "-1", "above 0"});
  refused(columns + "a,0,0,0,0,0,0,1,0,\n", {"fibres.csv", "line 2, slack_length_mm", "0", "above 0"});
  refused(columns + "a,0,9e4,0,0,0,0,1,30,\n",
          {"fibres.csv", "line 2, reference_mm", "90000", "bounding box"});
  refused(columns + "a,0,0,0,0,0,0,1,30,Hoop\n", {"fibres.csv", "line 2, wrap", "\"Hoop\"", "wraps"});
}

TEST_F(BadInput, KeysThatDoNotFitTogetherNameTheCommandLineToo)
{
  const auto said = [&](const std::string& set) {
    const test::Ended ended = test::run_vrda({"check", job_.string(), "--set", set});
    EXPECT_EQ(ended.exit_code, 2);
    return ended.err;
  };
  EXPECT_THAT(said("grid.flexion.to=-9"),
              HasSubstr("small.toml with --set grid.flexion.to: grid.flexion: found from 0 to -9"));
  EXPECT_THAT(
      said("solver.search.translation_step_mm=0.01"),
      HasSubstr("with --set solver.search.translation_step_mm: solver.search.translation_resolution"));
  EXPECT_THAT(said("solver.search.rotation_resolution_deg=3"),
              HasSubstr("with --set solver.search.rotation_resolution_deg: "));
  EXPECT_THAT(said("frame.right=-Z"), HasSubstr("with --set frame.right: frame"));
}

TEST_F(BadInput, UnwritableOutput)
{
  scratch_.write("file", "in the way");
  output_ = scratch_.path() / "file" / "out.h5";
  expect_refused({"out.h5", "found", "wanted"});
}

TEST_F(BadInput, AnOutputThatIsNoModelIsNeverOverwritten)
{
  const std::string before = test::text_of(job_);
  for (const fs::path& taken : {job_, scratch_.path() / "ball.stl", scratch_.path()}) {
    const test::Ended ended =
        test::run_vrda({"run", job_.string(), "-o", taken.string(), "--progress", "none"});
    EXPECT_EQ(ended.exit_code, 2) << taken;
    EXPECT_THAT(ended.err, HasSubstr(taken.string() + ": output: found"));
    EXPECT_THAT(ended.err, HasSubstr("a motion model to replace"));
  }
  EXPECT_EQ(test::text_of(job_), before);
}

TEST_F(BadInput, KeysWithoutEffectAreNamed)
{
  const test::Ended ended = test::run_vrda({"check", job_.string(), "--set", "push.force_n=50"});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.out, HasSubstr("push.force_n: it has no effect"));
  EXPECT_THAT(test::run_vrda({"check", job_.string()}).out, testing::Not(HasSubstr("no effect")));
}

TEST_F(BadInput, NothingAlongDeltaIsAWarning)
{
  const test::Ended ended =
      test::run_vrda({"check", job_.string(), "--set", "moving.initial.translation_mm=[500, 0, 0]"});
  EXPECT_THAT(ended.out, HasSubstr("warning: push.delta: "));
}

TEST_F(BadInput, AWrongUnitIsRefusedAtOnce)
{
  // Ball and dish in metres, read as millimetres.
  test::edit(job_, "[reference]",
             "[frame]\nunit = \"mm\"\nanterior = \"+X\"\nproximal = \"+Y\"\nright = \"+Z\"\n[reference]");
  for (const std::string name : {"ball.stl", "dish.stl"}) {
    std::string bytes = test::read_bytes(scratch_.path() / name);
    for (std::size_t at = 84; at < bytes.size(); at += 50) {
      for (std::size_t k = 3; k < 12; ++k) {
        float value = 0;
        std::memcpy(&value, bytes.data() + at + 4 * k, 4);
        value *= 0.001F;
        std::memcpy(bytes.data() + at + 4 * k, &value, 4);
      }
    }
    scratch_.write(name, bytes);
  }
  expect_refused({"small.toml", "frame.unit: found \"mm\"", "frame.unit = \"m\""});
}

TEST_F(BadInput, AJournalOfAnotherJobIsKeptUntilFresh)
{
  const fs::path journal = output_.string() + ".journal";
  journal::JournalWriter::create(journal.string(), std::string(64, 'a')).close();
  const std::string before = test::read_bytes(journal);
  expect_refused({"out.h5.journal", std::string(64, 'a'), "wanted", "--fresh"});
  EXPECT_EQ(test::read_bytes(journal), before);
  EXPECT_EQ(test::run_vrda({"run", job_.string(), "-o", output_.string(), "--fresh"}).exit_code, 0);
}

TEST_F(BadInput, NotAMotionModel)
{
  scratch_.write("no.h5", "not HDF5 at all");
  for (const std::string command : {"info", "validate"}) {
    const test::Ended ended = test::run_vrda({command, (scratch_.path() / "no.h5").string()});
    EXPECT_EQ(ended.exit_code, 2);
    EXPECT_THAT(ended.err, HasSubstr("no.h5"));
  }
}

}  // namespace vrda::bad_input_test
