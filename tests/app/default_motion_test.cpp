#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "app/scenes.hpp"
#include "support/messages.hpp"

namespace vrda::default_motion_test {

using Json = nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

constexpr double table_digits_deg = 1e-9;

Json json_of(std::vector<std::string> words)
{
  words.emplace_back("--json");
  const test::Ended ended = test::run_vrda(words);
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  return Json::parse(ended.out);
}

std::string exported(const std::string& file, const std::string& name, const std::vector<std::string>& more)
{
  std::vector<std::string> words{"export", file, "--to", name.substr(name.size() - 3), "-o", name};
  words.insert(words.end(), more.begin(), more.end());
  EXPECT_EQ(test::run_vrda(words).exit_code, 0);
  std::ostringstream text;
  text << std::ifstream(name).rdbuf();
  return text.str();
}

/// What follows the first line, which has the title, the set and the reason.
std::string without_name(const std::string& text)
{
  return text.substr(text.find('\n'));
}

// A smoothed motion that compare rejects is neither shown nor exported; the reason is said everywhere.
TEST(DefaultMotion, IsTheSmoothedOneOnlyIfItMeetsTheCriteriaOfCompare)
{
  struct Row {
    std::string degrees, fault, set;
  };
  for (const Row& row : {Row{"1,2", "none", "two_sided"}, Row{"3", "rough", "raw"}}) {
    SCOPED_TRACE(row.degrees);
    const test::Scratch scratch;
    const std::string file = (scratch.path() / "knee.h5").string(),
                      table = (scratch.path() / "a.sto").string();
    const test::Ended run = test::run_vrda({"run", test::small_knee_job(scratch, "right").string(), "-o",
                                            file, "--set", "smooth.degrees=[" + row.degrees + "]"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_THAT(run.err, HasSubstr("default motion: " + row.set));
    EXPECT_THAT(run.err, HasSubstr("screw-home along the spine: internal rotation net"));
    const Json compared = json_of({"compare", file, "--degrees", row.degrees, "--quiet"});
    EXPECT_EQ(compared.at("degrees").back().at("fault"), row.fault);
    const Json shown = json_of({"info", file}).at("default_motion");
    EXPECT_EQ(shown.at("set"), row.set);
    EXPECT_EQ(shown.at("is_compared"), true);
    const std::string reason = shown.at("reason");
    EXPECT_EQ(reason.empty(), row.fault == "none");
    EXPECT_THAT(run.err, HasSubstr(reason));
    const std::string text = exported(file, table, {});
    EXPECT_THAT(text.substr(0, text.find('\n')),
                testing::EndsWith(row.set + (reason.empty() ? "" : ": " + reason)));
    EXPECT_EQ(without_name(text), without_name(exported(file, table, {"--set", row.set})));
    EXPECT_EQ(test::run_vrda({"validate", file}).exit_code, 0);
  }
}

// The solved motion is exported along the spine; how it turns and where it jumps is in `run` and `info`.
TEST(DefaultMotion, OfSolvedPosesIsTheSpineAndItsJumpsAreNamed)
{
  const test::Scratch scratch;
  const std::string file = (scratch.path() / "knee.h5").string(), table = (scratch.path() / "a.mot").string();
  const test::Ended run =
      test::run_vrda({"run", test::small_knee_job(scratch, "right").string(), "-o", file, "--set",
                      "smooth.degrees=[1]", "--set", "grid.flexion={ from = 0, to = 60, step = 5 }"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json info = json_of({"info", file});
  const Json &spine = info.at("screw_home").at("spine"), &net = info.at("screw_home").at("net");
  std::istringstream rows(exported(file, table, {"--degrees"}));
  for (std::string line; line.rfind("time", 0) != 0;) ASSERT_TRUE(std::getline(rows, line));
  double time_s = 0.0, flexion_deg = 0.0, varus_deg = 0.0, internal_deg = 0.0, tx_m = 0.0, ty_m = 0.0,
         tz_m = 0.0;
  std::size_t row = 0;
  for (; rows >> time_s >> flexion_deg >> varus_deg >> internal_deg >> tx_m >> ty_m >> tz_m; ++row) {
    EXPECT_NEAR(flexion_deg, spine.at(row).at("flexion_deg").get<double>(), table_digits_deg);
    EXPECT_NEAR(internal_deg, spine.at(row).at("internal_rotation_deg").get<double>(), table_digits_deg);
  }
  EXPECT_EQ(row, spine.size());
  EXPECT_NEAR(net.at("deg").get<double>(),
              internal_deg - spine.front().at("internal_rotation_deg").get<double>(), table_digits_deg);
  EXPECT_GT(info.at("jump").at("perceptible_errors"), 10.0);
  EXPECT_LT(info.at("jump").at("from_flexion_deg"), info.at("jump").at("to_flexion_deg"));
  for (const std::string& text : {run.err, test::run_vrda({"info", file}).out})
    EXPECT_THAT(text, AllOf(HasSubstr("the raw motion jumps by"), HasSubstr("theta jumps by")));
  EXPECT_GT(info.at("spine_jump").at("deg"), 3.0);
}

// Without a two-sided motion the set that `smooth` adds is the new candidate.
TEST(DefaultMotion, IsDecidedAgainBySmooth)
{
  const test::Scratch scratch;
  const std::string file = (scratch.path() / "ball.h5").string();
  ASSERT_EQ(test::run_vrda({"run", test::small_job(scratch).string(), "-o", file}).exit_code, 0);
  EXPECT_THAT(json_of({"info", file}).at("default_motion").at("reason").get<std::string>(),
              testing::StartsWith("degree_1_recontacted "));
  ASSERT_EQ(test::run_vrda({"smooth", file, "--degree", "2"}).exit_code, 0);
  EXPECT_THAT(json_of({"info", file}).at("default_motion").at("reason").get<std::string>(),
              testing::StartsWith("degree_2 "));
}

}  // namespace vrda::default_motion_test
