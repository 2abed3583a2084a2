#include "run/campaign.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "job/job.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::campaign_test {

using test::input_error;
using testing::ElementsAre;
using testing::IsEmpty;

// A job; its meshes need not exist.
const char* const joint = R"(
[[reference.component]]
name = "upper"
file = "reference.stl"
[[moving.component]]
name = "lower"
file = "moving.stl"
)";

run::Campaign campaign_of_text(const std::string& text, const std::vector<std::string>& overrides = {})
{
  const test::Scratch scratch;
  return run::campaign_of(scratch.write("study.toml", text).string(), "", overrides);
}

InputError::Facts refused(const std::string& text, const std::vector<std::string>& overrides = {})
{
  return input_error([&] { campaign_of_text(text, overrides); });
}

std::vector<std::string> names_of(const run::Campaign& campaign)
{
  std::vector<std::string> names;
  for (const run::CampaignCase& one : campaign.cases) names.push_back(one.spec.name);
  return names;
}

TEST(Campaign, APlainJobIsOneCase)
{
  const test::Scratch scratch;
  const std::string job = scratch.write("knee.toml", joint).string();
  const run::Campaign campaign = run::campaign_of(job, scratch.path(), {"side=left"});
  EXPECT_THAT(campaign.axes, IsEmpty());
  ASSERT_EQ(campaign.cases.size(), 1U);
  EXPECT_EQ(campaign.cases[0].spec, run::case_of_job(job, scratch.path(), {"side=left"}));
  EXPECT_THAT(campaign.cases[0].levels, IsEmpty());
}

const char* const two_axes = R"(
[campaign]
title = "Two by three"
[[campaign.resolution]]
name = "coarse"
set = { grid.flexion.step = 30 }
[[campaign.resolution]]
name = "fine"
set = { grid.flexion.step = 10 }
[[campaign.method]]
name = "rest"
[[campaign.method]]
name = "search"
set = { solver = { method = "stability-search", search = { approach_step_mm = 6.0 } }, smooth.degrees = [4, 6] }
[[campaign.method]]
name = "free"
set = { grid.varus = "free" }
)";

TEST(Campaign, CasesAreTheProductTheLastAxisFastest)
{
  const run::Campaign campaign = campaign_of_text(std::string(joint) + two_axes);
  EXPECT_EQ(campaign.title, "Two by three");
  // In the order written, not alphabetically.
  EXPECT_THAT(campaign.axes, ElementsAre("resolution", "method"));
  EXPECT_THAT(names_of(campaign), ElementsAre("coarse_rest", "coarse_search", "coarse_free", "fine_rest",
                                              "fine_search", "fine_free"));
  const run::CampaignCase& one = campaign.cases[4];
  EXPECT_THAT(one.levels, ElementsAre("fine", "search"));
  EXPECT_THAT(one.spec.overrides, ElementsAre("grid.flexion.step=10", "solver.method=\"stability-search\"",
                                              "solver.search.approach_step_mm=6", "smooth.degrees=[4, 6]"));
}

TEST(Campaign, TheOverridesOfACaseAreTheValuesOfItsLevels)
{
  const test::Scratch scratch;
  const std::string file = scratch.write("study.toml", std::string(joint) + two_axes).string();
  const run::Campaign campaign = run::campaign_of(file, "", {"push.force_n=30"});
  const run::CaseSpec& spec = campaign.cases[4].spec;
  EXPECT_EQ(spec.job_file, file);
  const job::Job job = job::read_job(spec.job_file, spec.overrides);
  EXPECT_TRUE(job.has_campaign);
  EXPECT_EQ(job.method, job::SolverMethod::stability_search);
  EXPECT_EQ(job.grid.flexion_deg.size(), 10U);
  EXPECT_THAT(job.smooth_degrees, ElementsAre(4, 6));
  EXPECT_EQ(job.push.force_n.value(0, 0), 30.0);
  // The same case as a plain job: the same resolved job, hence the same journal key.
  const std::string by_hand = std::string("[grid]\nflexion.step = 10\n[smooth]\ndegrees = [4, 6]\n") +
                              "[solver]\nmethod = \"stability-search\"\nsearch.approach_step_mm = 6\n" +
                              "[push]\nforce_n = 30\n" + joint;
  EXPECT_EQ(job.resolved_text, job::parse_job("by_hand.toml", by_hand).resolved_text);
}

TEST(Campaign, SubjectsAreJobsOfTheirOwnBesideTheCampaign)
{
  const test::Scratch scratch;
  std::filesystem::create_directory(scratch.path() / "studies");
  const std::string file = scratch
                               .write("studies/study.toml", R"(
[campaign]
[[campaign.subject]]
name = "a"
job = "../a.toml"
[[campaign.subject]]
name = "b"
job = "b.toml"
data = "meshes"
set = { side = "left" }
)")
                               .string();
  const run::Campaign campaign = run::campaign_of(file, "everywhere", {});
  ASSERT_EQ(campaign.cases.size(), 2U);
  const run::CaseSpec &a = campaign.cases[0].spec, &b = campaign.cases[1].spec;
  EXPECT_EQ(a.job_file, scratch.path() / "a.toml");
  EXPECT_EQ(a.data_directory, std::filesystem::current_path() / "everywhere");
  EXPECT_THAT(a.overrides, IsEmpty());
  EXPECT_EQ(b.job_file, scratch.path() / "studies" / "b.toml");
  EXPECT_EQ(b.data_directory, scratch.path() / "studies" / "meshes");
  EXPECT_THAT(b.overrides, ElementsAre("side=\"left\""));
}

TEST(Campaign, CombinationsAreLeftOut)
{
  const std::string exclude =
      "exclude = [{ resolution = \"fine\", method = \"search\" }, { method = \"free\" }]\n";
  std::string text = std::string(joint) + two_axes;
  text.replace(text.find("title"), 0, exclude);
  EXPECT_THAT(names_of(campaign_of_text(text)), ElementsAre("coarse_rest", "coarse_search", "fine_rest"));
}

TEST(Campaign, WithoutAnAxisItIsTheJobOnce)
{
  const run::Campaign campaign = campaign_of_text(std::string(joint) + "[campaign]\ntitle = \"One\"\n");
  EXPECT_THAT(names_of(campaign), ElementsAre("study"));
  EXPECT_THAT(campaign.axes, IsEmpty());
}

}  // namespace vrda::campaign_test
