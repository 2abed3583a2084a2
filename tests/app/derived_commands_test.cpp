// `vrda smooth` and `vrda audit`: additions to a motion model.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "analysis/audit.hpp"
#include "app/scenes.hpp"
#include "store/motion_model.hpp"
#include "support/messages.hpp"

namespace vrda::derived_commands_test {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::IsEmpty;

// Rounding of a gap that is measured again with another order of summation.
constexpr double margin_mm = 2.0 * analysis::contact_margin_mm;

class DerivedCommands : public testing::Test {
 protected:
  // Two balls under a plate with two dents, 7 x 5 attitudes, with the sets "raw", "degree_2" and its
  // recontacted one.
  void SetUp() override
  {
    const test::Ended ended = run({"run", test::small_knee_job(scratch_, "left").string(), "-o", file_});
    ASSERT_EQ(ended.exit_code, 0) << ended.err;
  }

  test::Ended run(const std::vector<std::string>& words) const { return test::run_vrda(words); }

  Json json_of(std::vector<std::string> words) const
  {
    words.emplace_back("--json");
    const test::Ended ended = run(words);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return Json::parse(ended.out);
  }

  test::Scratch scratch_;
  std::string file_ = (scratch_.path() / "knee.h5").string();
};

TEST_F(DerivedCommands, ARunRecontactsItsSmoothedSetsUnlessDisabled)
{
  const store::MotionModel model = store::read_motion_model(file_);
  ASSERT_EQ(model.smoothed.size(), 1u);
  EXPECT_TRUE(model.smoothed.front().recontact_mm.has_value());
  EXPECT_FALSE(model.smoothed.front().is_robust);
  const std::string job = test::small_knee_job(scratch_, "right").string();
  const std::string plain = (scratch_.path() / "plain.h5").string();
  const test::Ended ended =
      run({"run", job, "-o", plain, "--set", "smooth.recontact=false", "--set", "smooth.robust=true"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  const store::MotionModel other = store::read_motion_model(plain);
  EXPECT_FALSE(other.smoothed.front().recontact_mm.has_value());
  EXPECT_TRUE(other.smoothed.front().is_robust);
}

TEST_F(DerivedCommands, RecontactLeavesNoOverlapAndTheMarginAtTheAttitudes)
{
  const Json sets = json_of({"audit", file_});
  ASSERT_EQ(sets.size(), 5u);
  const Json &recontacted = sets[1], &smoothed = sets[2], &raw = sets[3];
  EXPECT_EQ(sets[0].at("set"), "two_sided");
  EXPECT_EQ(sets[0].at("overlapping"), 0);
  EXPECT_EQ(sets[0].at("two_sided").at("both_in_contact"), sets[0].at("poses"));
  EXPECT_LE(sets[0].at("two_sided").at("largest_gap_medial_mm").get<double>(), margin_mm);
  EXPECT_EQ(recontacted.at("two_sided").at("poses"), 35);
  EXPECT_LT(recontacted.at("two_sided").at("both_in_contact").get<int>(), 35) << "varus from -10 to 10";
  EXPECT_EQ(recontacted.at("set"), "degree_2_recontacted");
  EXPECT_EQ(recontacted.at("poses"), 35);
  EXPECT_EQ(recontacted.at("overlapping"), 0);
  EXPECT_EQ(recontacted.at("nothing_ahead"), 0);
  EXPECT_TRUE(recontacted.at("largest_penetration").is_null());
  EXPECT_LE(recontacted.at("largest_gap").at("mm").get<double>(), margin_mm);
  EXPECT_EQ(smoothed.at("set"), "degree_2");
  EXPECT_GT(smoothed.at("overlapping"), 0);
  EXPECT_GT(smoothed.at("largest_penetration").at("mm").get<double>(), 0.01);
  EXPECT_EQ(raw.at("set"), "raw");
  EXPECT_EQ(raw.at("overlapping"), 0);
  EXPECT_EQ(sets[4].at("set"), "zero_varus");
  const Json info = json_of({"info", file_});
  EXPECT_EQ(info.at("remeasured").at("largest_gap_mm"), raw.at("largest_gap").at("mm"));
  for (std::size_t k = 0; k < 5; ++k)
    EXPECT_EQ(info.at("two_sided").at(sets[k].at("set").get<std::string>()), sets[k].at("two_sided"));

  const Json fine = json_of({"audit", file_, "--set", "degree_2_recontacted", "--refine", "3"});
  ASSERT_EQ(fine.size(), 1u);
  EXPECT_EQ(fine[0].at("attitudes"), 19 * 13);
  EXPECT_GT(fine[0].at("largest_gap").at("mm").get<double>(), margin_mm);
  const store::MotionModel model = store::read_motion_model(file_);
  ASSERT_EQ(model.audits.size(), 5u);  // the last of the two grids of that set
  EXPECT_EQ(model.audits[1].name, "degree_2_recontacted");
  EXPECT_EQ(model.audits[1].refine, 3);
  EXPECT_EQ(run({"validate", file_}).exit_code, 0);
}

TEST_F(DerivedCommands, TheTableNamesSetsAndWhereTheirWorstIs)
{
  const test::Ended ended = run({"audit", file_});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.err, IsEmpty());
  EXPECT_EQ(test::n_lines(ended.out), 2 + 5 + 2 + 5);
  EXPECT_THAT(ended.out, test::reports("", {"degree_2_recontacted", "1", "35", "0"}));
  EXPECT_THAT(ended.out, test::reports("", "penetration"));
  EXPECT_THAT(ended.out, test::reports("", "0.145 mm"));
}

TEST_F(DerivedCommands, EveryDegreeOfCompareCanBeSmoothed)
{
  EXPECT_EQ(run({"smooth", file_, "--degree", "0"}).exit_code, 0);
  EXPECT_EQ(store::read_motion_model(file_).smoothed.front().degree, 0);
}

TEST_F(DerivedCommands, ASecondTimeLeavesTheSameBytesForAnyNumberOfThreads)
{
  const std::vector<std::vector<std::string>> commands{
      {"smooth", file_, "--degree", "3", "--recontact"},
      {"smooth", file_, "--degree", "3", "--recontact", "--robust"},
      {"smooth", file_, "--degree", "2"},
      {"audit", file_, "--refine", "2"},
  };
  for (std::vector<std::string> words : commands) {
    words.insert(words.end(), {"--threads", "1"});
    EXPECT_EQ(run(words).exit_code, 0);
    const std::string once = test::sha256_of_file(file_);
    words.back() = "5";
    EXPECT_EQ(run(words).exit_code, 0);
    EXPECT_EQ(test::sha256_of_file(file_), once) << words.front();
  }
}

TEST_F(DerivedCommands, SmoothReplacesItsDegreeAndDropsAuditsOfWhatChanged)
{
  json_of({"audit", file_});
  const Json same = json_of({"smooth", file_, "--degree", "2", "--recontact"});
  EXPECT_EQ(same.at("degree"), 2);
  EXPECT_EQ(same.at("surfaces").size(), 4u);
  EXPECT_EQ(same.at("surfaces").at("ty").at("cells"), 35);
  EXPECT_EQ(same.at("recontact").at("without_contact"), 0);
  EXPECT_EQ(store::read_motion_model(file_).audits.size(), 5u);

  EXPECT_TRUE(json_of({"smooth", file_, "--degree", "3"}).at("recontact").is_null());
  EXPECT_EQ(store::read_motion_model(file_).audits.size(), 5u);
  EXPECT_EQ(store::read_motion_model(file_).smoothed.size(), 2u);

  const test::Ended ended = run({"smooth", file_, "--degree", "2"});
  EXPECT_THAT(ended.err, test::reports("", "/audit/degree_2_recontacted"));
  EXPECT_THAT(ended.out, test::reports("", {"degree 2", "6 terms"}));
  const store::MotionModel model = store::read_motion_model(file_);
  EXPECT_FALSE(model.smoothed.front().recontact_mm.has_value());
  ASSERT_EQ(model.audits.size(), 4u);
  EXPECT_EQ(model.audits.front().name, "degree_2");
}

}  // namespace vrda::derived_commands_test
