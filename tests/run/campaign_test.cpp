// Cases of a campaign, and what they cost.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>

#include "core/units.hpp"
#include "job/job.hpp"
#include "run/campaign.hpp"
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

solve::SweepPlan plan_of(solve::SpineRule rule, int n_flexion, int n_varus)
{
  solve::SweepPlan plan;
  plan.spine = rule;
  for (int i = 0; i < n_flexion; ++i) plan.flexion_rad.push_back(rad_from_deg(5.0 * i));
  for (int j = 0; j < n_varus; ++j) plan.varus_rad.push_back(rad_from_deg(2.0 * (j - n_varus / 2)));
  return plan;
}

struct Solved {
  std::map<StepKind, std::int64_t> by_kind;
  std::int64_t n_kept = 0;
};

// Sweeps with a counting solver: every step stable, both compartments in contact, highest at zero varus.
Solved solved_by(const solve::SweepPlan& plan)
{
  Solved solved;
  std::mutex mutex;
  const solve::SolveStep solve = [&](const solve::StepTask& task) {
    const std::lock_guard lock(mutex);
    ++solved.by_kind[task.key.kind];
    StepRecord record;
    record.status = StepStatus::stable;
    record.is_in_contact[0] = record.is_in_contact[1] = true;
    record.varus_rad = task.is_varus_free ? 0.0 : task.attitude.varus_rad;
    record.pose.translation_mm = {0.0, -std::abs(task.attitude.varus_rad), 0.0};
    return record;
  };
  solve::SweepHooks hooks;
  hooks.keep = [&](const StepRecord&) {
    const std::lock_guard lock(mutex);
    ++solved.n_kept;
  };
  EXPECT_TRUE(solve::sweep(plan, solve, hooks, 2).is_complete);
  return solved;
}

void expect_counted(const solve::SweepPlan& plan)
{
  Solved solved = solved_by(plan);
  const run::StepCounts counts = run::step_counts(plan);
  std::map<StepKind, std::int64_t>& n = solved.by_kind;
  EXPECT_EQ(counts.spine(), n[StepKind::spine_probe] + n[StepKind::free_spine]);
  EXPECT_EQ(counts.bands, n[StepKind::band]);
  EXPECT_EQ(counts.cells, n[StepKind::row] + n[StepKind::spine]);
  EXPECT_EQ(counts.records, solved.n_kept);
}

TEST(StepCounts, AreWhatASweepSolvesByEverySpineRule)
{
  for (const solve::SpineRule rule :
       {solve::SpineRule::nearest_zero, solve::SpineRule::walk_to_balance, solve::SpineRule::free_varus}) {
    for (const int n_flexion : {1, 2, 7}) {
      for (const int n_varus : {1, 2, 3, 6}) {
        for (const bool has_band : {false, true}) {
          SCOPED_TRACE(testing::Message()
                       << static_cast<int>(rule) << ' ' << n_flexion << ' ' << n_varus << ' ' << has_band);
          solve::SweepPlan plan = plan_of(rule, n_flexion, n_varus);
          plan.has_band = has_band;
          plan.n_restarts = has_band ? 4 : 0;
          expect_counted(plan);
          plan.rows = std::vector<std::int32_t>{0};
          expect_counted(plan);
          plan.rows = std::vector<std::int32_t>{};
          expect_counted(plan);
        }
      }
    }
  }
}

TEST(StepCounts, OfVarusLeftFreeOnlyTheBandsAreInTheRows)
{
  solve::SweepPlan plan = plan_of(solve::SpineRule::free_varus, 91, 1);
  plan.is_varus_free = plan.has_band = true;
  plan.n_restarts = 4;
  expect_counted(plan);
  const run::StepCounts counts = run::step_counts(plan);
  EXPECT_EQ(counts.chain, 2 * 91 + 2 * 90);
  EXPECT_EQ(counts.restarts, 91 * (4 + 12));
  EXPECT_EQ(counts.bands, 182);
  EXPECT_EQ(counts.cells, 0);
}

run::CaseSize size_of_knee()
{
  return {false, 4746, 10602, 21, 91, 21, 1};
}

// Whole runs measured with one thread on the machine of results/benchmarks.md: processor seconds of the spine
// and of the rows together, resident memory, bytes of all journals and of the model.
TEST(Cost, RunsMeasuredLieWithinTheSpread)
{
  struct Run {
    const char* name;
    run::CaseSize size;
    run::StepCounts steps;
    double solving_s, memory_mb, journal_kb, model_kb;
  };
  const Run runs[] = {
      {"generic knee, 91 x 21", size_of_knee(), {182, 364, 182, 1911, 2639}, 1.98, 41, 1413, 2859},
      {"generic knee, four times finer",
       {false, 74636, 128428, 21, 31, 9, 1},
       {62, 124, 62, 279, 527},
       2.28,
       111,
       767,
       3676},
      {"generic knee by search", {true, 4746, 10602, 0, 31, 9, 1}, {93, 0, 0, 248, 372}, 6.57, 31, 299, 648},
      {"a real knee by its 55 fibres, varus free",
       {false, 75274, 81596, 55, 91, 1, 1},
       {182, 364, 182, 0, 819},
       2.46,
       99,
       573,
       2109},
      {"a real knee by contact",
       {false, 81596, 81596, 0, 31, 9, 1},
       {62, 124, 0, 279, 465},
       1.78,
       120,
       328,
       2141},
      {"a real knee by search", {true, 97182, 97182, 0, 10, 9, 1}, {30, 0, 0, 80, 120}, 10.5, 133, 89, 2644},
  };
  for (const Run& run : runs) {
    SCOPED_TRACE(run.name);
    const run::CaseCost cost = run::cost_of(run.size, run.steps);
    const auto expect_near = [](double estimate, double measured) {
      EXPECT_LT(estimate, run::cost_spread * measured);
      EXPECT_GT(estimate, measured / run::cost_spread);
    };
    expect_near(cost.solving_s(), run.solving_s);
    expect_near(cost.memory_bytes, 1e6 * run.memory_mb);
    expect_near(cost.journal_bytes, 1e3 * run.journal_kb);
    expect_near(cost.model_bytes, 1e3 * run.model_kb);
  }
}

}  // namespace vrda::campaign_test
