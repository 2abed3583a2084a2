// Invalid files on the command line: no area, indices out of range, gigabytes announced by a few bytes, and a
// full standard output.
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

std::string u32(std::uint32_t value)
{
  return {reinterpret_cast<const char*>(&value), 4};
}

std::string floats(const std::vector<float>& values)
{
  return {reinterpret_cast<const char*>(values.data()), 4 * values.size()};
}

std::string stl_header(std::uint32_t n)
{
  return std::string(80, ' ') + u32(n);
}

// Three corners, collinear or equal.
std::string stl_facet(const std::vector<float>& corners)
{
  return floats({0, 0, 1}) + floats(corners) + std::string(2, '\0');
}

std::string ply(const std::string& format, const std::string& vertices, const std::string& faces)
{
  return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces + "\nend_header\n";
}
const std::string bytes_list = "\nproperty list uchar int vertex_indices";
const std::string long_list = "\nproperty list uint int vertex_indices";
const std::string corners = "0 0 0\n1 0 0\n0 1 0\n";

class BadFiles : public testing::Test {
 protected:
  struct Row {
    std::string file;  // replaces the ball's file
    std::string bytes;
    std::string field;
    test::Values found = {};
    test::Values wanted = {};
  };

  void expect_all_refused(const std::vector<Row>& rows)
  {
    std::string name = "ball.stl";
    for (const Row& row : rows) {
      SCOPED_TRACE(row.file + ", " + std::to_string(row.bytes.size()) + " bytes");
      scratch_.write(row.file, row.bytes);
      test::edit(job_, "\"" + name + "\"", "\"" + row.file + "\"");
      name = row.file;
      const test::Refusal refusal{row.file, row.field, row.found, row.wanted};
      test::expect_run_refused(job_, output_, refusal);
      EXPECT_LT(test::expect_refused({"check", job_.string(), "--json"}, refusal).peak_kb, absurd_kb);
    }
  }

  test::Scratch scratch_;
  fs::path job_ = test::small_job(scratch_);
  fs::path output_ = scratch_.path() / "out.h5";
};

TEST_F(BadFiles, NothingWithoutAreaIsAMesh)
{
  const std::string line = floats({0, 0, 0, 1, 1, 1, 2, 2, 2});
  expect_all_refused({
      {"line.stl",
       stl_header(2) + stl_facet({0, 0, 0, 1, 1, 1, 2, 2, 2}) + stl_facet({5, 5, 5, 5, 5, 5, 5, 5, 5}), "",
       "zero"},
      {"ascii.stl",
       "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 2 3\nvertex 2 4 "
       "6\nendloop\nendfacet\n"
       "endsolid a\n",
       "", "zero"},
      {"ascii.ply", ply("ascii", "3", "2" + bytes_list) + "0 0 0\n1 1 1\n2 2 2\n3 0 1 2\n3 1 1 1\n", "",
       "zero"},
      {"little.ply",
       ply("binary_little_endian", "3", "1" + bytes_list) + line + '\3' + u32(0) + u32(1) + u32(2), "",
       "zero"},
      {"line.obj", "v 0 0 0\nv 1 1 1\nv 2 2 2\nv 3 3 3\nf 1 2 3\nf 1 2 3 4\n", "", "zero"},
      {"vf.obj", "4 2\n0 0 0\n1 1 1\n2 2 2\n2 2 2\n3 0 1 2\n4 0 1 2 3\n", "", "zero"},
      {"line.vf", "3 1\n0 0 0\n0 0 0\n0 0 0\n3 0 1 2\n", "", "zero"},
  });
}

TEST_F(BadFiles, IndicesOutOfRange)
{
  const std::string binary = ply("binary_little_endian", "3", "1" + bytes_list) +
                             floats({0, 0, 0, 1, 0, 0, 0, 1, 0}) + '\3' + u32(0) + u32(1);
  expect_all_refused({
      {"far.vf", "3 1\n" + corners + "3 0 1 7\n", "line 5", "7"},
      {"below.vf", "3 1\n" + corners + "3 0 1 -1\n", "line 5", "-1"},
      {"both.vf", "3 2\n" + corners + "3 0 1 2\n3 1 2 3\n", "line 6", {"0", "5", "3"}},
      {"huge.vf", "3 1\n" + corners + "3 0 1 9223372036854775807\n", "line 5"},
      {"far.ply", ply("ascii", "3", "1" + bytes_list) + corners + "3 0 1 3\n", "face 0", "3"},
      {"below.ply", ply("ascii", "3", "1" + bytes_list) + corners + "3 0 1 -1\n", "face 0", "-1"},
      {"binary.ply", binary + u32(0x7fffffff), "face 0", "2147483647"},
      {"sign.ply", binary + u32(0x80000001), "face 0", "-2147483647"},
      {"far.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n", "line 4", "4", "3"},
      {"zero.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 0 1 2\n", "line 4", "\"0\""},
      {"back.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -4\n", "line 4", "\"-4\""},
      {"normal.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//2 3//1\n", "line 5", "2"},
  });
}

TEST_F(BadFiles, GigabytesPromisedByAFewBytes)
{
  expect_all_refused({
      {"binary.stl", stl_header(0xffffffffU), "header", {"4294967295", "84"}},
      {"ten.stl", stl_header(200'000'000) + std::string(1000, '\0'), "header", "200000000"},
      {"vertices.ply", ply("ascii", "999999999999", "1" + bytes_list), "line 3", "999999999999"},
      {"faces.ply", ply("ascii", "3", "999999999999" + bytes_list) + corners, "line 7", "999999999999"},
      {"allowed.ply", ply("binary_little_endian", "14999999", "1" + bytes_list) + std::string(900, '\0'),
       "vertex 75", "truncated"},
      {"list.ply",
       ply("binary_little_endian", "3", "1" + long_list) + std::string(36, '\0') + u32(0xffffffffU), "face 0",
       "truncated"},
      {"words.ply", ply("ascii", "3", "1" + long_list) + corners + "4000000000 0 1 2\n", "face 0",
       "truncated"},
      {"vertices.vf", "1000000000000 1\n" + corners, "line 1", "1000000000000"},
      {"faces.vf", "3 9223372036854775807\n" + corners, "line 1", "9223372036854775807"},
      {"corners.vf", "3 1\n" + corners + "4000000000 0 1 2\n", "line 5", "4000000000"},
      {"coordinates.obj", "v 1e300 0 0\nv 0 1e300 0\nv 0 0 1e300\nf 1 2 3\n", "vertex 0", "", "1e9"},
  });
}

TEST_F(BadFiles, AJournalThatPromisesGigabytes)
{
  const std::string header = std::string("VRDAJRNL") + u32(1);
  for (const std::string& bytes :
       {header + u32(0xffffffffU) + "key", header + u32(4096) + std::string(100, 'a')}) {
    scratch_.write("out.h5.journal", bytes);
    test::expect_run_refused(job_, output_,
                             {"out.h5.journal", "header", "damaged", {"--fresh", "vrda resume"}});
  }
}

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
