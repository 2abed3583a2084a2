// `vrda report`: its output.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "app/scenes.hpp"
#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "support/messages.hpp"

namespace vrda::report_test {

using nlohmann::json;

class ReportCommand : public test::CommandTest {
 protected:
  std::string folder() const { return (scratch_.path() / "report").string(); }

  static test::Ended report(std::vector<std::string> words)
  {
    words.insert(words.begin(), "report");
    return test::run_vrda(words);
  }

  // Expects a refusal and no report.
  void expect_refused(std::vector<std::string> arguments, const test::Refusal& refusal)
  {
    arguments.insert(arguments.begin(), "report");
    arguments.insert(arguments.end(), {"-o", folder()});
    test::expect_refused(arguments, refusal);
    EXPECT_FALSE(std::filesystem::exists(folder()));
  }
};

TEST_F(ReportCommand, WritesOnePageAndPrintsItsPath)
{
  const std::string file = solved_knee("right"), before = test::text_of(file);
  const test::Ended first = report({file, "-o", folder(), "--quiet"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(first.out, folder() + "/index.html\n");
  const std::string page = test::text_of(folder() + "/index.html");
  EXPECT_EQ(page.rfind("<!DOCTYPE html>", 0), 0u);
  EXPECT_EQ(report({file, "-o", folder(), "--quiet"}).exit_code, 0);
  EXPECT_TRUE(test::text_of(folder() + "/index.html") == page);
  EXPECT_EQ(test::text_of(file), before);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder()), {}), 1);
  const std::string named = (scratch_.path() / "made" / "page.html").string();
  EXPECT_EQ(report({file, "-o", named, "--quiet"}).out, named + "\n");
  EXPECT_TRUE(test::text_of(named) == page);
}

TEST_F(ReportCommand, DataHoldWhatWasMeasuredAndCompared)
{
  const json data = json::parse(report({solved_knee("right"), "-o", folder(), "--json"}).out);
  const json model = data.at("models").at(0);
  EXPECT_EQ(data.at("program"), "vrda 0.1.0");
  // The search keeps the last free pose within its resolution: nothing overlaps.
  EXPECT_EQ(model.at("numbers").at("overlapping"), 0);
  EXPECT_LE(model.at("numbers").at("largest_gap_mm").get<double>(),
            model.at("numbers").at("contact_resolution_mm").get<double>());
  EXPECT_FALSE(model.at("axes").is_null());
  EXPECT_EQ(model.at("curves").at(0).at("name"), "zero_varus");
  ASSERT_FALSE(model.at("comparison").is_null());
  EXPECT_EQ(model.at("comparison").at("rows").at(0).at("faults").at("attitudes"), 35);
  const json quick = json::parse(report({solved_knee("right"), "-o", folder(), "--json", "--quick"}).out);
  EXPECT_TRUE(quick.at("models").at(0).at("comparison").at("rows").at(0).at("faults").is_null());
}

TEST_F(ReportCommand, AMirroredLeftKneeHasTheSameCurves)
{
  const json data =
      json::parse(report({solved_knee("right"), solved_knee("left"), "-o", folder(), "--json"}).out);
  const json right = data.at("models").at(0).at("curves"), left = data.at("models").at(1).at("curves");
  EXPECT_EQ(right, left);
  EXPECT_EQ(data.at("models").at(1).at("name"), "left");
}

TEST_F(ReportCommand, FilesOfOneNameStayApart)
{
  const std::string file = solved_knee("right");
  const json data = json::parse(report({file, file, "-o", folder(), "--json"}).out);
  EXPECT_EQ(data.at("models").at(0).at("name"), "right");
  EXPECT_EQ(data.at("models").at(1).at("name"), "right (2)");
  const json differences = data.at("differences");
  const auto itself = std::find_if(differences.begin(), differences.end(), [](const json& d) {
    return d.at("model") == "right (2)" && d.at("curve") == "zero_varus";
  });
  ASSERT_NE(itself, differences.end());
  EXPECT_EQ(itself->at("against"), "right, zero_varus");
  EXPECT_EQ(itself->at("by_quantity").size(), 5u);
  for (const json& d : itself->at("by_quantity")) EXPECT_EQ(d.at("largest"), 0.0);
}

TEST_F(ReportCommand, AnOtherJointHasAReportToo)
{
  const std::string file = (scratch_.path() / "ball.h5").string();
  ASSERT_EQ(
      test::run_vrda({"run", test::small_job(scratch_).string(), "-o", file, "--progress", "none"}).exit_code,
      0);
  const json model = json::parse(report({file, "-o", folder(), "--json"}).out).at("models").at(0);
  EXPECT_EQ(model.at("joint"), "other");
  EXPECT_TRUE(model.at("contact_paths").is_null());
  EXPECT_TRUE(model.at("contact_grid").is_null());
}

TEST_F(ReportCommand, OneAttitudeIsEnough)
{
  const std::string file = (scratch_.path() / "one.h5").string();
  const test::Ended run =
      test::run_vrda({"run", test::small_job(scratch_).string(), "-o", file, "--progress", "none", "--set",
                      "grid.flexion={from=0,to=0,step=1}", "--set", "grid.varus={from=0,to=0,step=1}"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const test::Ended ended = report({file, "-o", folder(), "--json"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const json model = json::parse(ended.out).at("models").at(0);
  EXPECT_EQ(model.at("numbers").at("stable"), 1);
  EXPECT_EQ(model.at("curves").at(0).at("flexion"), json({0.0}));
}

TEST_F(ReportCommand, WithoutAPlayerThePageSaysSo)
{
  const std::string file = solved_knee("right");
  const auto note_with = [&](const std::string& player) {
    const test::Ended ended = report({file, "-o", folder(), "--json", "--player", player});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    const json stills = json::parse(ended.out).at("models").at(0).at("stills");
    EXPECT_TRUE(stills.at("stills").empty());
    EXPECT_THAT(ended.err, test::warns("", stills.at("note").get<std::string>()));
    return stills.at("note").get<std::string>();
  };
  EXPECT_THAT(note_with("/bin/false"), test::reports("", {"vrda-player", "exit code 1"}));
  const std::string no_program = scratch_.write("player", "no program").string();
  EXPECT_THAT(note_with(no_program), test::reports("", "vrda-player"));
  std::filesystem::remove_all(folder());
  expect_refused({file, "--player", (scratch_.path() / "absent").string()}, {"absent", "--player"});
}

TEST_F(ReportCommand, APlayersPicturesAreInThePage)
{
  const std::string player = (scratch_.path() / "player").string();
  // Called as: show FILE --offscreen FOLDER ...
  scratch_.write(
      "player",
      "#!/bin/sh\nprintf Man > \"$4/front_flexion_030.png\"\nprintf Ma > \"$4/lateral_flexion_007.5.png\"\n"
      "exit 3\n");
  std::filesystem::permissions(player, std::filesystem::perms::owner_all);
  const json stills =
      json::parse(report({solved_knee("right"), "-o", folder(), "--json", "--player", player, "-q"}).out)
          .at("models")
          .at(0)
          .at("stills");
  ASSERT_EQ(stills.at("stills").size(), 2u);
  EXPECT_EQ(stills.at("stills").at(0), json({{"view", "front"}, {"label", "flexion 30°"}, {"png", "TWFu"}}));
  EXPECT_EQ(stills.at("stills").at(1).at("label"), "flexion 7.5°");
  EXPECT_TRUE(test::names_value(stills.at("note").get<std::string>(), "without a pose"));
}

TEST_F(ReportCommand, AnExportedTableIsReadAsAPublishedCurve)
{
  const std::string file = solved_knee("right");
  const std::string csv = (scratch_.path() / "exported.csv").string();
  ASSERT_EQ(test::run_vrda({"export", file, "--to", "csv", "--set", "degree_2", "-o", csv}).exit_code, 0);
  const test::Ended ended = report({file, "-o", folder(), "--json", "--quick", "--against", csv});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const json differences = json::parse(ended.out).at("differences");
  const auto exported = std::find_if(differences.begin(), differences.end(), [](const json& d) {
    return d.at("curve") == "degree_2" && d.at("against") == "exported";
  });
  ASSERT_NE(exported, differences.end());
  constexpr double rounding = 1e-9;  // mm and degrees converted to radians and text
  EXPECT_EQ(exported->at("by_quantity").size(), 5u);
  for (const json& d : exported->at("by_quantity")) EXPECT_LT(d.at("largest").get<double>(), rounding) << d;
}

}  // namespace vrda::report_test
