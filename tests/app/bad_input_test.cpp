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
  void expect_refused(const test::Refusal& refusal) const
  {
    test::expect_run_refused(job_, output_, refusal);
  }

  test::Scratch scratch_;
  fs::path job_ = test::small_job(scratch_);
  fs::path output_ = scratch_.path() / "out.h5";
};

TEST_F(BadInput, MissingJob)
{
  test::expect_refused({"run", "nowhere.toml"}, {"nowhere.toml", "", "no file"});
}

TEST_F(BadInput, MeshesThatAreMissingEmptyTruncatedOrNotFinite)
{
  const std::string bytes = test::read_bytes(scratch_.path() / "ball.stl");
  scratch_.write("ball.stl", "");
  expect_refused({"ball.stl", "", "empty"});
  scratch_.write("ball.stl", bytes.substr(0, bytes.size() / 2));
  expect_refused({"ball.stl", "header", "168", std::to_string(bytes.size())});
  std::string damaged = bytes;
  constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(damaged.data() + 84 + 12, &not_a_number, sizeof not_a_number);
  scratch_.write("ball.stl", damaged);
  expect_refused({"ball.stl", "vertex 0", "nan"});
  test::edit(job_, "ball.stl", "bal.stl");
  expect_refused({"small.toml", "moving.component.0.file", "bal.stl"});
}

TEST_F(BadInput, TruncatedPly)
{
  scratch_.write(
      "ball.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n");
  test::edit(job_, "ball.stl", "ball.ply");
  expect_refused({"ball.ply", "vertex 2", "truncated", "3"});
}

TEST_F(BadInput, VerticesFacesCountsThatLie)
{
  scratch_.write("ball.obj", "4 4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n");
  test::edit(job_, "ball.stl", "ball.obj");
  expect_refused({"ball.obj", "line 8", "", "2"});
}

TEST_F(BadInput, KeysOfTheJobAreNamed)
{
  struct Row {
    const char *from, *to;
    test::Refusal refusal;
  };
  for (const Row& row :
       {Row{"[reference]",
            "[frame]\nanterior = \"+X\"\nproximal = \"+Y\"\nright = \"-Z\"\n[reference]",
            {"small.toml", "frame", "left-handed"}},
        {"from = 0, to = 4", "from = 9, to = 4", {"small.toml", "grid.flexion", {"9", "4"}}},
        {"from = -4, to = 4, step = 2",
         "from = -4, to = 4, step = 0",
         {"small.toml", "grid.varus.step", "0"}},
        {"material = \"bone\"",
         "materiel = \"bone\"",
         {"small.toml", "reference.component.0.materiel", "", "\"reference.component.material\""}}}) {
    test::edit(job_, row.from, row.to);
    expect_refused(row.refusal);
    test::edit(job_, row.to, row.from);
  }
}

TEST_F(BadInput, MissingLigamentFilesAreNamed)
{
  scratch_.write("fibres.csv", "name\n");
  const auto with = [&](const std::string& table, const test::Refusal& refusal) {
    test::edit(job_, "[smooth]", table + "\n[smooth]");
    expect_refused(refusal);
    test::expect_refused({"check", job_.string()}, refusal);
    test::edit(job_, table, "");
  };
  with("[ligaments]\nfibres = \"ligament.csv\"", {"small.toml", "ligaments.fibres", "ligament.csv"});
  with("[ligaments]\nfibres = \"fibres.csv\"\nwraps = \"wraps.json\"",
       {"small.toml", "ligaments.wraps", "wraps.json"});
}

TEST_F(BadInput, LigamentFilesAreRefusedInOneLine)
{
  const std::string columns =
      "name,reference_x_mm,reference_y_mm,reference_z_mm,moving_x_mm,moving_y_mm,moving_z_mm,stiffness_n,"
      "slack_length_mm,wrap\n";
  test::edit(job_, "[smooth]", "[ligaments]\nfibres = \"fibres.csv\"\n[smooth]");
  const auto refused = [&](const std::string& table, const test::Refusal& refusal) {
    scratch_.write("fibres.csv", table);
    expect_refused(refusal);
    test::expect_refused({"check", job_.string()}, refusal);
  };
  refused("nmae,stiffness_n\n", {"fibres.csv", "line 1", "\"nmae\"", "\"name\""});
  refused(columns + "a,0,0,0,0,0,0,-1,30,\n", {"fibres.csv", "line 2, stiffness_n", "-1", "0"});
  refused(columns + "a,0,0,0,0,0,0,1,0,\n", {"fibres.csv", "line 2, slack_length_mm", "0", "0"});
  refused(columns + "a,0,9e4,0,0,0,0,1,30,\n", {"fibres.csv", "line 2, reference_mm", "(0, 90000, 0)"});
  refused(columns + "a,0,0,0,0,0,0,1,30,Hoop\n", {"fibres.csv", "line 2, wrap", "\"Hoop\""});
}

TEST_F(BadInput, KeysThatDoNotFitTogetherNameTheCommandLineToo)
{
  const std::string search = "solver.search.";
  for (const auto& [key, value, field] : std::vector<std::array<std::string, 3>>{
           {"grid.flexion.to", "-9", "grid.flexion"},
           {search + "translation_step_mm", "0.01", search + "translation_resolution_mm"},
           {search + "rotation_resolution_deg", "3", search + "rotation_resolution_deg"},
           {"frame.right", "-Z", "frame"}})
    test::expect_refused({"check", job_.string(), "--set", key + "=" + value},
                         {job_.string() + " with --set " + key, field});
}

TEST_F(BadInput, UnwritableOutput)
{
  scratch_.write("file", "in the way");
  output_ = scratch_.path() / "file" / "out.h5";
  expect_refused({"out.h5", "folder", "Not a directory"});
}

TEST_F(BadInput, AnOutputThatIsNoModelIsNeverOverwritten)
{
  const std::string before = test::text_of(job_);
  for (const fs::path& taken : {job_, scratch_.path() / "ball.stl", scratch_.path()}) {
    test::expect_refused({"run", job_.string(), "-o", taken.string(), "--progress", "none"},
                         {taken.string(), "output", "", "motion model"});
  }
  EXPECT_EQ(test::text_of(job_), before);
}

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
  expect_refused({"small.toml", "frame.unit", "\"mm\"", "frame.unit = \"m\""});
}

TEST_F(BadInput, AJournalOfAnotherJobIsKeptUntilFresh)
{
  const fs::path journal = output_.string() + ".journal";
  store::JournalWriter::create(journal.string(), std::string(64, 'a')).close();
  const std::string before = test::read_bytes(journal);
  expect_refused({"out.h5.journal", "key", std::string(64, 'a'), "--fresh"});
  EXPECT_EQ(test::read_bytes(journal), before);
  EXPECT_EQ(test::run_vrda({"run", job_.string(), "-o", output_.string(), "--fresh"}).exit_code, 0);
}

TEST_F(BadInput, NotAMotionModel)
{
  scratch_.write("no.h5", "not HDF5 at all");
  for (const std::string command : {"info", "validate"})
    test::expect_refused({command, (scratch_.path() / "no.h5").string()}, {"no.h5", "", {"15", "HDF5"}});
}

}  // namespace vrda::bad_input_test
