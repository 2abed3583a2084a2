// `vrda export`: output files and refused input. The formats are tested in tests/exports.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "support/messages.hpp"

namespace vrda::export_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

/// The sample model has 4 flexions, 3 varus and one failed cell next to the spine.
class Export : public testing::Test {
 protected:
  Export() { store::write_motion_model(file_, test::sample_model({})); }

  std::string path(const std::string& name) const { return (scratch_.path() / name).string(); }

  test::Ended run(const std::string& format, const std::string& output,
                  const std::vector<std::string>& more = {}) const
  {
    std::vector<std::string> words{"export", file_, "--to", format, "-o", path(output)};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_vrda(words);
  }

  /// Expects a refusal in one line, and no file besides the model.
  void expect_refused(const test::Ended& ended, const test::Refusal& refusal) const
  {
    EXPECT_THAT(ended, test::refuses(refusal));
    EXPECT_EQ(test::n_lines(ended.err), 1) << ended.err;
    EXPECT_THAT(ended.out, IsEmpty());
    EXPECT_EQ(std::distance(fs::directory_iterator(scratch_.path()), {}), 1);
  }

  test::Scratch scratch_;
  std::string file_ = path("knee.h5");
};

TEST_F(Export, WritesEachFormatAndTheSameBytesAgain)
{
  struct Row {
    std::string format, output, start;
  };
  for (const Row& row : {Row{"sto", "knee.sto", "vrda: "}, Row{"mot", "knee.mot", "vrda: "},
                         Row{"csv", "knee.csv", "flexion_deg,varus_deg,internal_deg,anterior_mm,"},
                         Row{"gltf", "new/folder/knee.glb", "glTF"}, Row{"vtk", "knee.pvd", "<?xml"}}) {
    SCOPED_TRACE(row.format);
    const test::Ended ended = run(row.format, row.output);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    EXPECT_THAT(ended.out, StartsWith(path(row.output) + "\n"));
    const std::string first = test::read_bytes(path(row.output));
    EXPECT_THAT(first, StartsWith(row.start));
    EXPECT_EQ(run(row.format, row.output, {"--quiet"}).err, "");
    EXPECT_EQ(test::read_bytes(path(row.output)), first);
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(path("knee")), {}), 4);
}

TEST_F(Export, SaysWhatItLeftOut)
{
  const test::Ended ended =
      run("csv", "knee.csv", {"--set", "raw", "--varus", "1", "--flexion", "0:4:1", "--json"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.err, test::warns("", {"2", "1 (unsolved_cell)", "4"}));
  const auto json = nlohmann::json::parse(ended.out);
  EXPECT_EQ(json.at("set"), "raw");
  EXPECT_EQ(json.at("attitudes"), 3);
  EXPECT_EQ(json.at("left_out").at(1).at("flexion_deg"), 4);
  EXPECT_EQ(json.at("files"), nlohmann::json::array({path("knee.csv")}));
  EXPECT_EQ(test::n_lines(test::read_bytes(path("knee.csv"))), 1 + 3);
}

TEST_F(Export, EveryCellIsARow)
{
  EXPECT_EQ(run("csv", "cells.csv", {"--full"}).exit_code, 0);
  EXPECT_EQ(test::n_lines(test::read_bytes(path("cells.csv"))), 1 + 4 * 3);
}

TEST_F(Export, ColumnsGoByTheNamesGiven)
{
  EXPECT_EQ(
      run("mot", "knee.mot", {"--coordinate", "flexion=knee_angle_r", "--coordinate", "tz=z"}).exit_code, 0);
  EXPECT_THAT(test::read_bytes(path("knee.mot")),
              HasSubstr("\ntime\tknee_angle_r\tknee_add_r\tknee_rot_r\tknee_tx_r\tknee_ty_r\tz\n"));
}

TEST_F(Export, RefusesWhatItCannotDo)
{
  struct Row {
    std::string format, output;
    std::vector<std::string> more;
    test::Refusal refusal;
  };
  for (const Row& row : {
           Row{"csv", "knee.txt", {}, {"vrda export", "--output", "knee.txt", ".csv"}},
           Row{"gltf", "knee.h5", {}, {"vrda export", "--output", "", ".glb"}},
           Row{"csv",
               "a.csv",
               {"--degrees"},
               {"vrda export", "--degrees", "--to csv", {"--to sto", "--to mot"}}},
           Row{"csv",
               "a.csv",
               {"--translations", "mesh-origin"},
               {"vrda export", "--translations", "--to csv", {"--to sto", "--to mot"}}},
           Row{"vtk", "a.pvd", {"--coordinate", "tx=x"}, {"vrda export", "--coordinate", "--to vtk"}},
           Row{"sto", "a.sto", {"--full"}, {"vrda export", "--full", "", "--to csv"}},
           Row{"csv", "a.csv", {"--full", "--set", "raw"}, {"vrda export", "--full", "--set"}},
           Row{"sto",
               "a.sto",
               {"--coordinate", "angle=x"},
               {"vrda export", "--coordinate", "angle=x", "internal"}},
           Row{"sto",
               "a.sto",
               {"--coordinate", "tx"},
               {"vrda export", "--coordinate", "tx", "COORDINATE=NAME"}},
           // A second sign would be lost in the name.
           Row{"mot",
               "a.mot",
               {"--coordinate", "flexion=--knee"},
               {"vrda export", "--coordinate", "flexion=--knee", "-NAME"}},
           Row{"mot",
               "a.mot",
               {"--coordinate", "flexion=\u2212knee"},
               {"vrda export", "--coordinate", "knee", "-NAME"}},
           Row{"osim", "a.osim", {"--coordinate", "tx=-x"}, {"vrda export", "--coordinate", "tx", "flexion"}},
           Row{"sto",
               "a.sto",
               {"--coordinate", "tx=x", "--coordinate", "tx=-y"},
               {"vrda export", "--coordinate", "tx twice", "once"}},
           Row{"sto", "a.sto", {"--coordinate", "tx=-"}, {"vrda export", "--coordinate", "tx=-", "NAME"}},
           Row{"sto", "a.sto", {"--coordinate", "tx=a b"}, {"vrda export", "--coordinate", "a b"}},
           Row{"sto",
               "a.sto",
               {"--coordinate", "tx=knee_ty_r"},
               {"vrda export", "--coordinate", "knee_ty_r"}},
           Row{"sto", "a.sto", {"--flexion", "0:90"}, {"vrda export", "--flexion", "0:90", "FROM:TO:STEP"}},
           Row{"sto", "a.sto", {"--flexion", "90:0:5"}, {"vrda export", "--flexion", "90:0:5"}},
           Row{"sto",
               "a.sto",
               {"--flexion", "0:90:0"},
               {"vrda export", "--flexion", "0:90:0", {"STEP", "0"}}},
           Row{"sto", "a.sto", {"--flexion", "0:x:1"}, {"vrda export", "--flexion", "0:x:1"}},
           Row{"sto",
               "a.sto",
               {"--flexion", "0:90:1e-9"},
               {"vrda export", "--flexion", "0:90:1e-9", "100000"}},
           Row{"sto", "a.sto", {"--flexion", "50:60:1"}, {"knee.h5", "degree_1", "pose"}},
           Row{"sto", "a.sto", {"--varus", "up"}, {"vrda export", "--varus", "up", {"spine", "zero"}}},
           Row{"sto", "a.sto", {"--varus", "zero"}, {"knee.h5", "--varus", "zero", "vrda reduce"}},
           Row{"sto", "a.sto", {"--varus", "30"}, {"knee.h5", "--varus", "30"}},
           Row{"sto", "a.sto", {"--set", "degree_9"}, {"knee.h5", "--set", "degree_9", {"degree_1", "raw"}}},
       }) {
    SCOPED_TRACE(testing::PrintToString(row.more));
    expect_refused(run(row.format, row.output, row.more), row.refusal);
  }
  EXPECT_EQ(run("stl", "a.stl").exit_code, 2);
  EXPECT_EQ(run("sto", "a.sto", {"--rate", "0"}).exit_code, 2);
}

TEST_F(Export, AModelWithoutAPoseIsRefused)
{
  store::write_motion_model(file_, store::with_pending_cells(test::sample_model({})));
  expect_refused(run("gltf", "knee.glb"), {"knee.h5", "raw", "pose"});
  expect_refused(run("csv", "cells.csv", {"--full"}), {"knee.h5", "status", "stable"});
}

TEST_F(Export, AFileThatIsNoModelIsRefused)
{
  const std::string whole = test::read_bytes(file_);
  for (const std::string& bytes :
       {whole.substr(0, whole.size() / 2), std::string("solid knee\n"), std::string()}) {
    scratch_.write("knee.h5", bytes);
    expect_refused(run("sto", "knee.sto"), {"knee.h5", "", bytes.size() > 20 ? "truncated" : "HDF5"});
  }
}

TEST_F(Export, AnOutputThatCannotBeWrittenIsRefused)
{
  fs::create_directories(path("folder/knee.csv"));
  const test::Ended folder = run("csv", "folder/knee.csv");
  EXPECT_THAT(folder, test::refuses({"folder/knee.csv", "output", "regular file"}));
  const test::Ended inside = run("csv", "knee.h5/a/knee.csv");
  EXPECT_EQ(inside.exit_code, 2);
  EXPECT_EQ(test::n_lines(inside.err), 1) << inside.err;
}

}  // namespace vrda::export_test
