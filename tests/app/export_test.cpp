// `vrda export`: output files. The formats are tested in tests/exports.
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

}  // namespace vrda::export_test
