#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/commands.hpp"
#include "app/scenes.hpp"
#include "store/motion_model.hpp"
#include "support/input_error.hpp"
#include "support/messages.hpp"

namespace vrda::compare_test {

using testing::AnyOf;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

TEST(DegreesOf, ReadsRangesAndLists)
{
  EXPECT_THAT(app::parse_degrees("3"), ElementsAre(3));
  EXPECT_THAT(app::parse_degrees("1..4"), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(app::parse_degrees("6,2,4,2"), ElementsAre(2, 4, 6));
  EXPECT_THAT(app::parse_degrees("0..1,20"), ElementsAre(0, 1, 20));
}

/// A small knee of 7 x 5 attitudes, solved.
struct SolvedKnee {
  test::Scratch scratch;
  std::string file = (scratch.path() / "knee.h5").string();

  SolvedKnee() { EXPECT_EQ(run({}).exit_code, 0); }
  test::Ended run(const std::vector<std::string>& more)
  {
    std::vector<std::string> words{
        "run", test::small_knee_job(scratch, "right").string(), "-o", file, "--fresh", "--replace"};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_vrda(words);
  }
  test::Ended compare(const std::vector<std::string>& more) const
  {
    std::vector<std::string> words{"compare", file};
    words.insert(words.end(), more.begin(), more.end());
    return test::run_vrda(words);
  }
};

TEST(CompareCommand, PrintsARowADegreeAndTheRecommendation)
{
  const SolvedKnee knee;
  const std::string before = test::sha256_of_file(knee.file);
  const test::Ended ended = knee.compare({"--degrees", "1..3"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(test::n_lines(ended.out), 2 + 3 + 1);
  EXPECT_THAT(ended.out, test::reports("", "penetration"));
  EXPECT_THAT(ended.out, AnyOf(test::reports("recommended", "degree"), test::reports("", "no degree")));
  EXPECT_THAT(ended.err, test::reports("", "degree_3"));
  EXPECT_EQ(test::sha256_of_file(knee.file), before) << "the file is unchanged";
  const test::Ended quiet = knee.compare({"--degrees", "1..3", "--quiet", "--threads", "1"});
  EXPECT_THAT(quiet.err, IsEmpty());
  EXPECT_EQ(quiet.out, ended.out) << "for any number of threads";
}

TEST(CompareCommand, JsonHasEverything)
{
  const SolvedKnee knee;
  const test::Ended ended = knee.compare({"--degrees", "1,3", "--refine", "2", "--json"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const auto json = nlohmann::json::parse(ended.out);
  EXPECT_EQ(json.at("perceptible").at("mm"), 0.145);
  EXPECT_EQ(json.at("perceptible").at("degree"), 0.27);
  EXPECT_EQ(json.at("degrees").size(), 2u);
  const auto& row = json.at("degrees").at(1);
  EXPECT_EQ(row.at("degree"), 3);
  EXPECT_EQ(row.at("terms"), 10);
  EXPECT_EQ(row.at("converged"), true);
  for (const std::string name : {"tx", "ty", "tz", "theta"}) {
    const auto& surface = row.at("surfaces").at(name);
    EXPECT_EQ(surface.at("cells"), 35);
    for (const std::string key :
         {"rms", "largest_residual", "leave_one_out_rms", "roughness", "condition_number"})
      EXPECT_TRUE(surface.at(key).is_number()) << name << ' ' << key;
  }
  EXPECT_EQ(row.at("surfaces").at("theta").at("unit"), "degree");
  EXPECT_EQ(row.at("at_grid").at("attitudes"), 35);
  EXPECT_EQ(row.at("between").at("attitudes"), 13 * 9 - 35);
  EXPECT_GT(row.at("at_grid").at("largest_penetration_mm").get<double>(), 0.0);
  EXPECT_TRUE(row.at("left_out").at("error").is_number());
  EXPECT_TRUE(row.at("second_difference").is_number());
  EXPECT_EQ(row.at("contact").at("two_sided").at("both_in_contact"), row.at("contact").at("poses"));
  EXPECT_LE(row.at("contact").at("largest_gap_mm").get<double>(), 1e-3);
  EXPECT_EQ(row.at("contact").at("largest_overlap_mm"), 0.0);
  const auto& recommendation = json.at("recommendation");
  EXPECT_GE(recommendation.at("left_out").at("flexions").get<int>(), 1);
  EXPECT_FALSE(recommendation.at("reason").get<std::string>().empty());
  const bool is_any_good = json.at("degrees").at(0).at("fault") == "none" || row.at("fault") == "none";
  EXPECT_EQ(recommendation.at("status") == "recommended", is_any_good);
  EXPECT_EQ(recommendation.at("degree").is_number(), is_any_good);
}

TEST(CompareCommand, RecontactLeavesNoPenetrationOnTheGrid)
{
  const SolvedKnee knee;
  const test::Ended ended = knee.compare({"--degrees", "2", "--recontact", "--robust", "--json"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  const auto json = nlohmann::json::parse(ended.out);
  EXPECT_EQ(json.at("robust"), true);
  EXPECT_EQ(json.at("recontacted"), true);
  const auto& row = json.at("degrees").at(0);
  EXPECT_EQ(row.at("at_grid").at("overlapping"), 0);
  EXPECT_EQ(row.at("at_grid").at("largest_penetration_mm"), 0.0);
  // Issue 5: at most 1e-3 mm at grid attitudes.
  EXPECT_LE(row.at("at_grid").at("largest_gap_mm").get<double>(), 1e-3);
}

TEST(CompareCommand, SaysWhichDegreesTheCellsCannotCarry)
{
  const SolvedKnee knee;
  const test::Ended ended = knee.compare({"--refine", "0"});
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(test::n_lines(ended.out), 2 + 4 + 1) << "five columns determine degree 4";
  EXPECT_THAT(ended.out, Not(test::reports("", "penetration")));
  EXPECT_THAT(ended.err, test::reports(knee.file, "5"));
}

TEST(SmoothCommand, RobustIsStoredAndStays)
{
  const SolvedKnee knee;
  const auto smooth = [&] {
    return test::run_vrda({"smooth", knee.file, "--degree", "3", "--robust", "--json"});
  };
  const test::Ended ended = smooth();
  ASSERT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_EQ(nlohmann::json::parse(ended.out).at("robust"), true);
  const std::string once = test::sha256_of_file(knee.file);
  const store::MotionModel model = store::read_motion_model(knee.file);
  const auto set = std::find_if(model.smoothed.begin(), model.smoothed.end(),
                                [](const store::SmoothedSet& other) { return other.degree == 3; });
  ASSERT_NE(set, model.smoothed.end());
  EXPECT_TRUE(set->is_robust);
  EXPECT_EQ(smooth().out, ended.out);
  EXPECT_EQ(test::sha256_of_file(knee.file), once);
}

}  // namespace vrda::compare_test
