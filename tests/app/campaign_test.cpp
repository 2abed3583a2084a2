// vrda plan and vrda index on campaigns of small joints.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "app/scenes.hpp"
#include "support/messages.hpp"

namespace vrda::campaign_test {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;
using testing::Not;

// Both methods and two grids of the ball under a dish: four cases, each solved in well under a second.
fs::path small_campaign(const test::Scratch& scratch, const std::string& more = "")
{
  const std::string job = test::small_job(scratch).filename().string();
  return scratch.write(
      "study.toml",
      "[campaign]\ntitle = \"Balls\"\n[[campaign.subject]]\nname = \"ball\"\njob = \"" + job + "\"\n" + R"(
[[campaign.method]]
name = "rest"
set = { solver.method = "equilibrium" }
[[campaign.method]]
name = "search"
set = { solver.method = "stability-search" }
[[campaign.resolution]]
name = "coarse"
set = { grid.flexion = { from = 0, to = 10, step = 10 } }
[[campaign.resolution]]
name = "fine"
set = { grid.flexion = { from = 0, to = 10, step = 5 } }
)" + more);
}

TEST(Plan, ListsTheCasesOfACampaign)
{
  const test::Scratch scratch;
  const std::string file = small_campaign(scratch).string();
  const json plan = test::json_of({"plan", file});
  EXPECT_EQ(plan.at("axes"), (std::vector<std::string>{"subject", "method", "resolution"}));
  ASSERT_EQ(plan.at("cases").size(), 4U);
  const json& one = plan.at("cases").at(3);
  EXPECT_EQ(one.at("name"), "ball_search_fine");
  EXPECT_EQ(one.at("levels").at("method"), "search");
  EXPECT_EQ(one.at("method"), "stability-search");
  EXPECT_EQ(one.at("flexions"), 3);
  EXPECT_EQ(one.at("attitudes"), 15);
  const json check =
      json::parse(test::run_vrda({"check", "--json", (scratch.path() / "small.toml").string()}).out);
  std::int64_t n_triangles = 0;
  for (const json& component : check.at("components"))
    n_triangles += component.at("triangles").get<std::int64_t>();
  EXPECT_EQ(one.at("triangles").at("all"), n_triangles);
  double processor_s = 0.0;
  for (const json& c : plan.at("cases")) processor_s += c.at("processor_s").at("all").get<double>();
  EXPECT_DOUBLE_EQ(plan.at("total").at("processor_s").get<double>(), processor_s);
  EXPECT_EQ(plan.at("total").at("attitudes"), 2 * (10 + 15));
  EXPECT_EQ(plan.at("estimate_is_within_a_factor_of"), 2.0);
  // The same as a table.
  const test::Ended text = test::run_vrda({"plan", file});
  EXPECT_EQ(text.exit_code, 0);
  for (const test::Values& values :
       {test::Values{"Balls"}, {"ball_search_fine", "3 x 5"}, {"4 cases", "50 attitudes"}, {"half", "twice"}})
    EXPECT_THAT(text.out, test::reports("", values));
}

TEST(Plan, OfASingleJobListsTheCellsOfEachShard)
{
  const test::Scratch scratch;
  const std::string file = test::small_job(scratch).string();
  const json plan = test::json_of({"plan", file, "--shards", "2"});
  ASSERT_EQ(plan.at("cases").size(), 1U);
  const json& shards = plan.at("cases").at(0).at("shards");
  ASSERT_EQ(shards.size(), 2U);
  EXPECT_EQ(shards.at(0).at("rows"), 2);
  EXPECT_EQ(shards.at(1).at("attitudes"), 5);
  EXPECT_THAT(test::run_vrda({"plan", file, "--shards", "5"}).out, test::reports("", "2 of 5 shards"));
}

TEST(Plan, SaysWhereShardsDoNotHelp)
{
  const test::Scratch scratch;
  const std::string file = test::small_job(scratch).string();
  const test::Ended freely = test::run_vrda(
      {"plan", file, "--shards", "2", "--set", "solver.method=equilibrium", "--set", "grid.varus=free"});
  EXPECT_EQ(freely.exit_code, 0);
  EXPECT_THAT(freely.err, test::warns("--shards", "spine"));
}

TEST(Plan, IdenticalCasesAreReported)
{
  const test::Scratch scratch;
  const std::string file =
      small_campaign(scratch, "[[campaign.scaling]]\nname = \"a\"\n[[campaign.scaling]]\nname = \"b\"\n")
          .string();
  const test::Ended ended = test::run_vrda({"plan", file});
  EXPECT_EQ(ended.exit_code, 0);
  EXPECT_THAT(ended.err, test::warns("", {"ball_rest_coarse_b", "ball_rest_coarse_a"}));
}

TEST(Plan, CasesThatDifferInScalingOnlyShareTheirSteps)
{
  const test::Scratch scratch;
  const std::string file =
      small_campaign(scratch,
                     "[[campaign.scaling]]\nname = \"adult\"\n"
                     "[[campaign.scaling]]\nname = \"small\"\nset = { scaling.factor = 0.9 }\n"
                     "[[campaign.scaling]]\nname = \"wide\"\nset = { scaling.factor = [1, 1, 1.1] }\n")
          .string();
  const json plan = test::json_of({"plan", file});
  ASSERT_EQ(plan.at("cases").size(), 12U);
  EXPECT_EQ(plan.at("cases").at(1).at("name"), "ball_rest_coarse_small");
  EXPECT_EQ(plan.at("cases").at(1).at("same_steps_as"), "ball_rest_coarse_adult");
  EXPECT_EQ(plan.at("cases").at(0).at("same_steps_as"), "");
  EXPECT_EQ(plan.at("cases").at(2).at("same_steps_as"), "") << "another shape";
  for (const json& one : plan.at("cases")) EXPECT_EQ(one.at("same_as"), "");
  EXPECT_THAT(test::run_vrda({"plan", file}).err, test::reports("", {"4 of 12", "scaling"}));
}

std::vector<std::string> split(const std::string& line, char separator)
{
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, separator);) fields.push_back(field);
  return fields;
}

std::string field_of(const std::string& csv, std::size_t row, const std::string& column)
{
  const std::vector<std::string> lines = split(csv, '\n');
  const std::vector<std::string> names = split(lines.at(0), ',');
  const auto at = static_cast<std::size_t>(std::find(names.begin(), names.end(), column) - names.begin());
  return split(lines.at(row + 1), ',').at(at);
}

TEST(Index, ASubmissionHasOneRowACaseAndEachCanBeRepeatedByHand)
{
  const test::Scratch scratch;
  const std::string file = small_campaign(scratch).string();
  const std::string folder = scratch.path() / "results";
  const test::Ended submitted = test::run_vrda({"submit", file, "--local", "--workers", "2", "-o", folder});
  ASSERT_EQ(submitted.exit_code, 0) << submitted.err;
  const std::string csv = test::text_of(fs::path(folder) / "index.csv");
  ASSERT_EQ(test::n_lines(csv), 5);
  const json plan = test::json_of({"plan", file});
  for (std::size_t k = 0; k < 4; ++k) {
    const json& one = plan.at("cases").at(k);
    SCOPED_TRACE(one.at("name"));
    EXPECT_EQ(field_of(csv, k, "case"), one.at("name"));
    EXPECT_EQ(field_of(csv, k, "status"), "done");
    EXPECT_EQ(field_of(csv, k, "attitudes"), std::to_string(one.at("attitudes").get<int>()));
    std::vector<std::string> words = one.at("command");
    words.erase(words.begin());
    const fs::path output = scratch.path() / "by_hand.h5";
    words.insert(words.end(), {"-o", output.string(), "--progress", "none"});
    EXPECT_EQ(test::run_vrda(words).exit_code, 0);
    EXPECT_EQ(field_of(csv, k, "sha256"), test::sha256_of_file(output));
    fs::remove(output);
  }
}

TEST(Index, CasesThatAreNotDoneAreRowsToo)
{
  const test::Scratch scratch;
  const std::string file = small_campaign(scratch).string();
  const fs::path folder = scratch.path() / "results";
  ASSERT_EQ(test::run_vrda({"submit", file, "--local", "-o", folder.string()}).exit_code, 0);
  const std::string before = test::text_of(folder / "index.csv");
  fs::remove_all(folder / "ball_rest_coarse");
  fs::rename(folder / "ball_rest_fine" / "ball_rest_fine.h5",
             folder / "ball_rest_fine" / "ball_rest_fine.h5.journal");
  fs::resize_file(folder / "ball_search_coarse" / "ball_search_coarse.h5", 100);
  const test::Ended ended = test::run_vrda({"index", folder.string(), "--json"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  const json counts = json::parse(ended.out);
  for (const char* status : {"done", "partial", "failed", "missing"})
    EXPECT_EQ(counts.at(status), 1) << status;
  const std::string csv = test::text_of(folder / "index.csv");
  EXPECT_EQ(field_of(csv, 0, "status"), "missing");
  EXPECT_EQ(field_of(csv, 1, "status"), "partial");
  EXPECT_EQ(field_of(csv, 2, "status"), "failed");
  EXPECT_THAT(csv, Not(HasSubstr(scratch.path().string())));
  EXPECT_EQ(split(csv, '\n').back(), split(before, '\n').back());
}

}  // namespace vrda::campaign_test
